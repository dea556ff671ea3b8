"""Annotations in OpenRooms' formats: read as meant, refused with the line that is wrong."""

from pathlib import Path

import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.library.assignment.annotations import files_of, read_annotation


def written(tmp_path: Path, text: str, name: str = "ann.txt") -> Path:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def test_parts_by_number(tmp_path: Path) -> None:
    found = read_annotation(written(tmp_path, "# 4\n0 0 4\n1 6\n\n2 9\n3 7 5\n4 1\n"))
    assert found.numbered == {0: ("wood", "paint"), 1: ("metal",), 3: ("fabric", "leather")}
    assert found.substances("part3") == found.substances("lamp_part_3") == ("fabric", "leather")
    assert found.substances("part4") == () == found.substances("seat")
    assert found.lamps == {2} and found.is_lamp("part2") and not found.is_lamp("part1")


def test_the_count_beside_the_file_leaves_later_parts_out(tmp_path: Path) -> None:
    path = written(tmp_path, "0 0\n1 1\n2 2\n")
    assert set(read_annotation(path).numbered) == {0, 1, 2}
    written(tmp_path, "2\n", "matNum.txt")
    assert set(read_annotation(path).numbered) == {0, 1}
    assert [file.name for file in files_of(path)] == ["ann.txt", "matNum.txt"]


def test_parts_by_name(tmp_path: Path) -> None:
    text = "Chair\nchair_leg: wood, metal\nchair_seat:\nSeat Cushion:  fabric \n"
    found = read_annotation(written(tmp_path, text, "annoMatParts.txt"))
    assert found.named == {"chair_leg": ("wood", "metal"), "seat_cushion": ("fabric",)}
    assert found.substances("chair_leg_7") == ("wood", "metal")
    assert found.substances("SeatCushion") == ("fabric",)


def test_a_bad_model_says_so(tmp_path: Path) -> None:
    assert read_annotation(written(tmp_path, "!\n0 x\n")).bad


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0 0\n1 10\n", r"ann.txt:2: there is no category 10\n"),
        ("0 0\n1\n", "ann.txt:2: expected the number of a part"),
        ("0 wood\n", "expected the number of a part and of its categories, found '0 wood'"),
        ("-1 2\n", "expected the number of a part"),
        ("²\n", "expected the number of a part"),
        ("Chair\nleg: wod\n", r"ann.txt:2: there is no category 'wod' \(did you mean 'wood'"),
        ("Chair\nleg: wood\narm\n", "ann.txt:3: expected a part and its categories"),
        ("\n \n", "an annotation without a line"),
    ],
)
def test_what_is_no_annotation_is_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        read_annotation(written(tmp_path, text))
    caught.match(message)
    assert caught.value.remedy


def test_what_cannot_be_read_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_annotation(tmp_path / "none.txt")
    (tmp_path / "ann.txt").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="expected the number of a part"):
        read_annotation(tmp_path / "ann.txt")
