"""The cache of panoramas: the same bytes with and without, safe from damage, and bounded."""

import os
from pathlib import Path

import pytest

from openrooms_usd.library import skycache
from openrooms_usd.library.skycache import cached_picture
from openrooms_usd.usercache import VARIABLE

KEY = "ab" * 32


class Maker:
    """Writes a picture, and counts how often."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self, path: Path) -> None:
        self.calls += 1
        path.write_bytes(b"pixels")


@pytest.fixture
def entries(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache" / skycache.FOLDER


def test_a_picture_is_made_once_and_again_where_its_entry_is_damaged(
    tmp_path: Path, entries: Path
) -> None:
    make = Maker()
    for name in "abc":
        cached_picture(KEY, tmp_path / name, make)
        assert (tmp_path / name).read_bytes() == b"pixels"
    assert make.calls == 1
    [entry] = entries.iterdir()
    entry.write_bytes(entry.read_bytes().replace(b"pixels", b"pixelz"))
    cached_picture(KEY, tmp_path / "d", make)
    assert make.calls == 2 and (tmp_path / "d").read_bytes() == b"pixels"
    cached_picture(KEY, tmp_path / "e", make)
    assert make.calls == 2


def test_it_is_made_each_time_where_there_is_no_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, "off")
    make = Maker()
    for name in "ab":
        cached_picture(KEY, tmp_path / name, make)
    assert make.calls == 2


def test_those_used_last_stay_and_files_of_others_too(
    tmp_path: Path, entries: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(skycache, "_MOST", 2)
    make = Maker()
    entries.mkdir(parents=True)
    (entries / "mine.sky").write_bytes(b"of somebody else")
    os.utime(entries / "mine.sky", (1, 1))
    for age, name in enumerate(("first", "second")):
        cached_picture(name, tmp_path / name, make)
        os.utime(entries / f"{name}.sky", (10 + age, 10 + age))
    cached_picture("third", tmp_path / "third", make)
    assert {path.stem for path in entries.iterdir()} == {"mine", "second", "third"}
