"""The cache of textures: the same bytes with and without, safe from damage and from company."""

import json
import threading
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.furniture import CATEGORIES, part_of
from openrooms_usd.furniture.joinery.books import BINDINGS, Shelf, bound
from openrooms_usd.furniture.joinery.fronts import HANDLES, FrontDesign, leaf
from openrooms_usd.library.textures import cache
from openrooms_usd.library.textures.cache import Material, cached
from openrooms_usd.usercache import VARIABLE, cache_folder
from tests.furniture.pieces import made

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


def test_what_is_found_is_what_would_bemade(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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


STORAGE = (
    "cabinet",
    "wardrobe",
    "dresser",
    "bookshelf",
    "file_cabinet",
    "counter",
    "kitchen_cabinet",
)
STYLED = [(name, style) for name in STORAGE for style in CATEGORIES[name].styles]


@pytest.mark.parametrize(("name", "style"), STYLED)
@pytest.mark.parametrize("seed", range(3))
def test_every_door_and_drawer_moves(name: str, style: str, seed: int) -> None:
    furniture = made(name, style, seed)
    moving = {mesh for joint in furniture.joints for mesh in joint.meshes}
    fronts = {n for n in furniture.parts if part_of(n) in ("door", "drawer_front", "drawer_box")}
    assert fronts <= moving


@pytest.mark.parametrize(("name", "style"), STYLED)
def test_every_drawer_has_a_box(name: str, style: str) -> None:
    furniture = made(name, style)
    drawers = [joint for joint in furniture.joints if part_of(joint.name) == "drawer"]
    fronts = [mesh for mesh in furniture.parts if part_of(mesh) == "drawer_front"]
    assert len(drawers) == len(fronts)
    for joint in drawers:
        assert "drawer_box" in {part_of(mesh) for mesh in joint.meshes}


@pytest.mark.parametrize("name", ["cabinet", "wardrobe", "kitchen_cabinet", "counter"])
def test_doors_turn_about_one_of_their_edges(name: str) -> None:
    furniture = made(name, "hinged" if name == "wardrobe" else "doors")
    doors = [joint for joint in furniture.joints if part_of(joint.name) == "door"]
    assert doors
    for joint in doors:
        low, high = furniture.parts[joint.meshes[0]].extent
        assert min(abs(joint.origin[0] - low[0]), abs(joint.origin[0] - high[0])) < 1e-6
        assert joint.origin[1] == pytest.approx(low[1], abs=1e-6)
        # Opening to the front: about -Z on the left, about +Z on the right.
        left = joint.origin[0] < 0.5 * (low[0] + high[0])
        assert joint.axis == (0.0, 0.0, -1.0 if left else 1.0)


def test_a_tray_is_as_deep_as_its_drawer_runs() -> None:
    furniture = made("dresser", "double")
    assert furniture.joints
    for joint in furniture.joints:
        front, box = (furniture.parts[mesh].extent for mesh in joint.meshes[:2])
        assert front[1, 1] == pytest.approx(box[0, 1], abs=1e-4)
        assert joint.limits[1] < box[1, 1] - box[0, 1]


def test_framed_fronts_have_the_depth_of_their_panel() -> None:
    framed, plain = leaf(0.5, 0.7, 0.02, frame=0.06), leaf(0.5, 0.7, 0.02)
    panel = (0.5 - 0.126) * (0.7 - 0.126) * 0.006
    assert plain.volume() - framed.volume() == pytest.approx(panel, rel=0.02)


@pytest.mark.parametrize("handle", sorted(HANDLES))
def test_handles_stand_out_by_28_mm(handle: str) -> None:
    extent = HANDLES[FrontDesign(handle).handle](0.16).extent
    assert extent[0, 1] == pytest.approx(-0.028, abs=1e-3)
    assert extent[1, 1] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("seed", range(8))
def test_books_stand_inside_their_shelf(seed: int) -> None:
    low, size = np.array([0.3, -0.2, 1.1]), np.array([0.9, 0.28, 0.33])
    books = Shelf(tuple(low), tuple(size)).filled(np.random.default_rng(seed), 0.9)
    assert len(books) > 4
    for book in books:
        extent = book.cover().extent
        assert (extent[0] >= low - 1e-9).all()
        assert (extent[1] <= low + size + 1e-9).all()
        assert extent[0, 2] < low[2] + size[2] - 0.02
        inner = book.pages().extent
        assert (inner[0] >= extent[0] - 1e-3).all()
        assert (inner[1] <= extent[1] + 1e-3).all()


@pytest.mark.parametrize("seed", range(8))
def test_upright_books_do_not_share_their_place(seed: int) -> None:
    books = Shelf((0.0, 0.0, 0.0), (1.2, 0.3, 0.35)).filled(np.random.default_rng(seed), 0.9)
    upright = [book for book in books if np.array_equal(book.pose[:3, :3], np.eye(3))]
    spans = sorted(tuple(book.cover().extent[:, 0]) for book in upright)
    assert all(right <= left for (_, right), (left, _) in pairwise(spans))


def test_leaning_books_rest_on_a_corner() -> None:
    rng = np.random.default_rng(0)
    books = [b for _ in range(8) for b in Shelf((0, 0, 0), (1.2, 0.3, 0.35)).filled(rng, 0.9)]
    leaning = [b for b in books if 0 < abs(b.pose[0, 2]) < 0.9]
    assert leaning
    for book in leaning:
        assert book.cover().extent[0, 2] == pytest.approx(0, abs=1e-9)


def test_bindings_are_told_apart() -> None:
    books = Shelf((0, 0, 0), (1.2, 0.3, 0.35)).filled(np.random.default_rng(1), 0.95)
    covers, pages, _ = bound(books)
    assert 3 <= len(covers) <= BINDINGS
    assert len(pages) == 1
    total = sum(mesh.volume() for mesh in covers)
    assert total == pytest.approx(sum(book.cover().volume() for book in books))


@pytest.mark.parametrize("style", list(CATEGORIES["bookshelf"].styles))
@pytest.mark.parametrize("seed", range(3))
def test_bookshelves_have_books_within_their_outline(style: str, seed: int) -> None:
    furniture = made("bookshelf", style, seed)
    books = [m for n, m in furniture.parts.items() if part_of(n) == "book"]
    assert books
    rest = np.stack([m.extent for n, m in furniture.parts.items() if part_of(n) != "book"])
    for mesh in books:
        assert (mesh.extent[0] >= rest[:, 0].min(axis=0) - 1e-9).all()
        assert (mesh.extent[1] <= rest[:, 1].max(axis=0) + 1e-9).all()
