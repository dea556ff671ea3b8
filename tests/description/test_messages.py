"""What people read when a description is wrong, held as text beside the faulty descriptions.

``mistakes/NAME.yaml`` is wrong, ``mistakes/NAME.txt`` is what is said about it.
"""

import pickle
from pathlib import Path

import pytest

from openrooms_usd.description import load_room, parse_room
from openrooms_usd.description.mistakes import FieldsError
from openrooms_usd.errors import DescriptionError, InputError

FOLDER = Path(__file__).parent / "mistakes"


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.yaml")), ids=lambda path: path.stem)
def test_each_mistake_is_said_in_these_words(path: Path) -> None:
    with pytest.raises(DescriptionError) as caught:
        parse_room(path.read_bytes(), "room.yaml")
    assert f"{caught.value}\n" == path.with_suffix(".txt").read_text(encoding="utf-8")


def test_every_text_belongs_to_a_description() -> None:
    names = {path.stem for path in FOLDER.glob("*.txt")}
    assert names == {path.stem for path in FOLDER.glob("*.yaml")}


def test_the_message_names_the_file(tmp_path: Path) -> None:
    path = tmp_path / "wrong.yaml"
    path.write_text("seed: x\n")
    with pytest.raises(DescriptionError) as caught:
        load_room(path)
    assert f"{path}:1:7: seed: expected a whole number, found 'x'" in str(caught.value)
    assert caught.value.exit_code != 0


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        load_room(tmp_path / "missing.yaml")
    with pytest.raises(InputError, match="a folder, not a file"):
        load_room(tmp_path)
    with pytest.raises(InputError, match="longer than 4095 bytes"):
        load_room(tmp_path / ("x" * 5000))


@pytest.mark.slow
def test_ten_thousand_mistakes_make_a_short_message() -> None:
    objects = "\n".join(
        f"    - {{category: chair, name: chair_{i}, at: [0, 0], on: chiar_{i}}}"
        for i in range(10_000)
    )
    with pytest.raises(DescriptionError) as caught:
        parse_room(f"furniture:\n  objects:\n{objects}\n")
    lines = str(caught.value).splitlines()
    assert lines[0] == "room.yaml: 10,000 mistakes"
    assert lines[-1] == "  and 9,950 more"
    assert "did you mean 'chair_0'?" in lines[1]
    assert len(lines) == 52


def test_mistakes_pass_between_processes() -> None:
    """As from a pool of workers of a person's own."""
    with pytest.raises(DescriptionError) as told:
        parse_room("room: nowhere\nseed: many\n", "room.yaml")
    for error in (told.value, FieldsError((("layout",), "wrong"))):
        other = pickle.loads(pickle.dumps(error))
        assert (type(other), str(other)) == (type(error), str(error))
