"""A room of S3DIS that we write ourselves: what a file is called, its points are."""

from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.capture import Capture
from openrooms_usd.errors import InputError
from openrooms_usd.steps.alignment.instances import instances_of
from orusd_scans.s3dis import S3disImporter

THINGS = ("board_1", "bookcase_1", "ceiling_1", "chair_1", "chair_2", "clutter_1", "wall_3")


def room(folder: Path) -> Path:
    rng = np.random.default_rng(7)
    (folder / "Annotations").mkdir(parents=True)
    for name in THINGS:
        rows = np.column_stack([rng.random((40, 3)) + 3.0, rng.integers(0, 256, (40, 3))])
        np.savetxt(folder / "Annotations" / f"{name}.txt", rows, "%.3f %.3f %.3f %d %d %d")
    (folder / "Annotations" / ".DS_Store").write_bytes(b"\0\1")
    return folder


def read(folder: Path) -> Capture:
    return S3disImporter().read(folder)


def test_things_are_what_their_files_are_called(tmp_path: Path) -> None:
    cloud = read(room(tmp_path / "office_1")).cloud
    assert cloud is not None
    assert cloud.instance is not None
    assert cloud.label is not None
    assert cloud.colors is not None
    assert len(cloud) == 40 * len(THINGS)
    assert cloud.words == {n: (name.split("_")[0],) for n, name in enumerate(THINGS, 1)}
    classes = [int(cloud.label[cloud.instance == n][0]) for n in range(1, len(THINGS) + 1)]
    # By NYU40: whiteboard, bookshelf, ceiling, two chairs, nothing, wall.
    assert classes == [30, 10, 22, 5, 5, 0, 1]
    found = instances_of(cloud)
    assert found is not None
    left = [one.words[0] for one in found if one.meaning.kind != "thing"]
    assert left == ["ceiling", "wall"]
    boxed = [one.words[0] for one in found if one.hint.choices == (("clutter",),)]
    assert boxed == ["clutter"]


def test_another_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not a room of S3DIS"):
        read(tmp_path)
    with pytest.raises(InputError, match="cannot be the path of a file"):
        read(Path("a\0b"))
    folder = room(tmp_path / "a")
    (folder / "Annotations" / "chair_1.txt").write_text("1 2 3 4 5 6\n1 2 x 4 5 6\n")
    with pytest.raises(InputError, match=r"1 of 2 lines are not a row of 6 numbers.* line 2"):
        read(folder)


@pytest.mark.parametrize(("column", "bad"), [(0, "3.1\x1042"), (5, "103.0\x100000"), (2, "-")])
def test_a_damaged_line_costs_one_point(tmp_path: Path, column: int, bad: str) -> None:
    file = room(tmp_path / "a") / "Annotations" / "chair_1.txt"
    lines = file.read_text().splitlines()
    words = lines[7].split()
    words[column] = bad
    file.write_text("\n".join([*lines[:7], " ".join(words), *lines[8:]]))
    found = read(tmp_path / "a")
    assert found.cloud is not None
    assert len(found.cloud) == 40 * len(THINGS) - 1
    said = "left out 1 of 40 lines, which are not 6 numbers each: the first is line 8"
    no_number = "1 points without finite coordinates were dropped"
    assert found.notes[0].startswith(no_number if bad == "-" else f"chair_1.txt: {said}")


@pytest.mark.parametrize("content", ["", "\n \n"])
def test_an_empty_file_costs_its_thing(tmp_path: Path, content: str) -> None:
    folder = room(tmp_path / "a")
    (folder / "Annotations" / "chair_2.txt").write_text(content)
    found = read(folder)
    assert found.cloud is not None
    assert len(found.cloud) == 40 * (len(THINGS) - 1)
    assert found.notes == ("1 files of things are empty, and left out",)
    assert len(S3disImporter().pack(folder).contents) == len(THINGS) - 1
    for path in (folder / "Annotations").glob("*.txt"):
        path.write_text(content)
    with pytest.raises(InputError, match="not a room of S3DIS"):
        read(folder)


def test_a_copy_has_the_same_files(tmp_path: Path) -> None:
    packed = S3disImporter().pack(room(tmp_path / "office_1"))
    assert packed.file == "office_1"
    assert len(packed.contents) == len(THINGS)
