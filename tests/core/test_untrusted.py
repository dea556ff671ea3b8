"""The door for files of others: what is no file, too large or no path is refused at once."""

import os
from pathlib import Path

import pytest

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError


def test_a_file_is_read(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"\xef\xbb\xbfcaf\xe9")
    (tmp_path / "link").symlink_to("a")
    assert untrusted.read_bytes(tmp_path / "a", "text") == b"\xef\xbb\xbfcaf\xe9"
    assert untrusted.read_text(tmp_path / "link") == "caf�"
    assert untrusted.checked(tmp_path / "a", "json") == 7


def test_what_is_no_file_is_named(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "endless").symlink_to("/dev/zero")
    for name, what in (("pipe", "a pipe"), ("endless", "a device"), (".", "a folder")):
        with pytest.raises(InputError, match=f"this is {what}, not a file"):
            untrusted.read_bytes(tmp_path / name, "json")
    with pytest.raises(InputError, match="no such file"):
        untrusted.checked(tmp_path / "none", "json")


def test_a_file_without_end_is_cut_off(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(untrusted.MOST_BYTES, "json", 10)
    (tmp_path / "large").write_bytes(b"x" * 11)
    with pytest.raises(InputError, match="at most"):
        untrusted.read_bytes(tmp_path / "large", "json")
    # It says that it holds nothing, and does not end so soon.
    if Path("/proc/self/maps").exists():
        with pytest.raises(InputError, match="at most"):
            untrusted.read_bytes(Path("/proc/self/maps"), "json")


@pytest.mark.parametrize("name", ["a\0b", "x" * 256, "a/" * 3000, "\ud800"])
def test_paths_that_no_file_has(name: str) -> None:
    with pytest.raises(InputError, match="cannot be the path of a file"):
        untrusted.checked(Path(name), "text")


@pytest.mark.parametrize("name", ["", ".", "..", "../x", "a/../../x", "/etc/passwd", "out/x", "\0"])
def test_what_leaves_its_folder(name: str, tmp_path: Path) -> None:
    (tmp_path / "room").mkdir()
    (tmp_path / "room" / "out").symlink_to(tmp_path)
    with pytest.raises(InputError, match="cannot be the path of a file"):
        untrusted.inside(tmp_path / "room", name)


def test_what_stays_in_its_folder(tmp_path: Path) -> None:
    assert untrusted.inside(tmp_path, "a/b.png") == tmp_path / "a" / "b.png"


@pytest.mark.parametrize(
    "name", ["", ".", "..", "a/b", "a\\b", "a\0", "C:", "x" * 256, "\udc00\ud800"]
)
def test_names_that_are_paths(name: str) -> None:
    assert not untrusted.is_plain_name(name)
    assert untrusted.is_plain_name("view_1")
