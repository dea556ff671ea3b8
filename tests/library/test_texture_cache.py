"""The cache of textures: the same bytes with and without, safe from damage and from company."""

import json
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from openrooms_usd.library.textures import cache
from openrooms_usd.library.textures.cache import Material, cached
from openrooms_usd.usercache import VARIABLE, cache_folder

DENIM = Material("denim", 3, resolution=32)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "cache"))
    return tmp_path


def contents(files: list[Path]) -> list[bytes]:
    return [file.read_bytes() for file in files]


def unmakeable(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(**_: object) -> None:
        raise AssertionError("it was made again")

    monkeypatch.setattr(cache, "make", refuse)


def test_what_is_found_is_what_would_be_made(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = cached(DENIM, folder / "a", "x")
    assert [file.name for file in made] == ["x_albedo.png", "x_normal.png", "x_roughness.png"]
    with monkeypatch.context() as patch:
        unmakeable(patch)
        found = cached(DENIM, folder / "b", "y")
    monkeypatch.setenv(VARIABLE, "off")
    assert cache_folder("textures") is None
    alone = cached(DENIM, folder / "c", "z")
    assert contents(made) == contents(found) == contents(alone)


def test_everything_that_determines_a_set_is_in_its_digest() -> None:
    others = [
        replace(DENIM, name="twill"),
        replace(DENIM, number=4),
        replace(DENIM, color=(0.1, 0.2, 0.3)),
        replace(DENIM, roughness=0.5),
        replace(DENIM, resolution=64),
        replace(DENIM, size=0.123),
    ]
    assert len({material.digest for material in (DENIM, *others)}) == 7
    usual = cache.family_of("denim").size
    assert replace(DENIM, size=usual).digest == DENIM.digest


def test_entries_of_other_code_and_of_other_libraries_are_not_taken(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = contents(cached(DENIM, folder / "a", "x"))
    [entry] = (folder / "cache/textures").iterdir()
    for number, name in enumerate(("code_digest", "library_versions")):
        with monkeypatch.context() as patch:
            patch.setattr(cache, name, lambda *_, leaves=(): ("another",))
            assert DENIM.entry != entry.name
            assert contents(cached(DENIM, folder / f"b{number}", "x")) == made
            unmakeable(patch)
            cached(DENIM, folder / f"c{number}", "x")
    assert len(list((folder / "cache/textures").iterdir())) == 3


def test_code_names_the_files_of_layers_and_what_is_installed_does_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    before = DENIM.digest
    monkeypatch.setattr(cache, "library_versions", lambda *_, leaves=(): ("numpy 0",))
    assert DENIM.digest == before
    monkeypatch.setattr(cache, "code_digest", lambda *_, leaves=(): "another")
    assert DENIM.digest != before


@pytest.mark.parametrize("damage", ["changed", "cut", "gone", "sums"])
def test_damaged_entries_are_made_again(folder: Path, damage: str) -> None:
    whole = contents(cached(DENIM, folder / "a", "x"))
    entry = folder / "cache/textures" / DENIM.entry
    victim = entry / ("checksums.json" if damage == "sums" else "normal.png")
    if damage == "gone":
        victim.unlink()
    elif damage == "cut":
        victim.write_bytes(victim.read_bytes()[:-9])
    elif damage == "changed":
        data = bytearray(victim.read_bytes())
        data[len(data) // 2] ^= 1
        victim.write_bytes(bytes(data))
    else:
        victim.write_text("[]")
    assert contents(cached(DENIM, folder / "b", "x")) == whole
    # And the entry is whole again.
    sums = json.loads((entry / "checksums.json").read_text())
    assert set(sums) == {"albedo", "normal", "roughness"}
    assert (entry / "normal.png").read_bytes() == whole[1]


def test_a_cache_that_cannot_be_written_is_as_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv(VARIABLE, str(tmp_path / "file"))
    assert all(file.is_file() for file in cached(DENIM, tmp_path / "a", "x"))


def test_where_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder("textures") == tmp_path / "openrooms_usd/textures"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert cache_folder("textures") == tmp_path / ".cache/openrooms_usd/textures"


@pytest.mark.slow
def test_many_writers_at_once(folder: Path) -> None:
    results: list[list[bytes]] = []

    def write(number: int) -> None:
        results.append(contents(cached(DENIM, folder / f"out{number}", "x")))

    threads = [threading.Thread(target=write, args=(number,)) for number in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 6 and all(result == results[0] for result in results)
    entry = folder / "cache/textures" / DENIM.entry
    assert sorted(path.name for path in entry.iterdir()) == [
        "albedo.png",
        "checksums.json",
        "normal.png",
        "roughness.png",
    ]
