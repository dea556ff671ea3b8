"""Files appear whole or not at all."""

import os
from pathlib import Path

import pytest

from openrooms_usd import atomic, unfinished
from openrooms_usd.errors import OutputError


def test_a_failed_write_leaves_the_old_file_and_nothing_beside_it(tmp_path: Path) -> None:
    target = tmp_path / "a.txt"
    atomic.write_text(target, "old")
    with pytest.raises(RuntimeError), atomic.replacing(target) as beside:
        beside.write_text("half")
        raise RuntimeError
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_a_written_file_has_the_new_content_and_its_folder_is_made(tmp_path: Path) -> None:
    target = tmp_path / "new" / "b.bin"
    atomic.write_bytes(target, b"\x00\xff")
    assert target.read_bytes() == b"\x00\xff"
    assert [path.name for path in target.parent.iterdir()] == ["b.bin"]


def test_a_folder_that_is_a_file_is_an_output_error(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("")
    with pytest.raises(OutputError, match="cannot write"):
        atomic.write_text(tmp_path / "taken" / "c.txt", "x")


def test_a_folder_left_by_a_killed_run_is_in_nobody_s_way(tmp_path: Path) -> None:
    left = unfinished.beside(tmp_path / "new")
    left.mkdir()
    (left / "half.txt").write_text("half")
    with atomic.replacing_files(tmp_path) as beside:
        (beside / "whole.txt").write_text("whole")
    assert sorted(path.name for path in tmp_path.iterdir()) == [left.name, "whole.txt"]


def test_a_device_or_a_pipe_never_gives_way_to_a_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("/dev/null")
    (tmp_path / "folder").mkdir()
    for name, what in (("pipe", "a pipe"), ("link", "a device"), ("folder", "a folder")):
        with pytest.raises(OutputError, match=f"this is {what}, and will not be replaced"):
            atomic.write_text(tmp_path / name, "x")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder", "link", "pipe"]
    assert (tmp_path / "link").is_symlink()


def test_a_link_gives_way_and_what_it_leads_to_stays(tmp_path: Path) -> None:
    (tmp_path / "kept").write_text("kept")
    for name, leads in (("good", "kept"), ("broken", "nowhere")):
        (tmp_path / name).symlink_to(leads)
        atomic.write_text(tmp_path / name, "new")
        assert not (tmp_path / name).is_symlink()
    assert (tmp_path / "kept").read_text() == "kept"
