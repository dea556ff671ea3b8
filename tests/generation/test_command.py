"""``orusd generate``."""

import json
from pathlib import Path

from openrooms_usd.description import load_room
from openrooms_usd.generation import generate, write
from tests import commands


def run(*words: object) -> tuple[int, str]:
    done = commands.run(*words)
    return done.exit_code, f"{done.output}{done.exception or ''}"


def test_one_room(tmp_path: Path) -> None:
    words = ("generate", "--type", "closet", "--seed", 3, "-o", tmp_path / "a")
    code, said = run(*words)
    assert code == 0 and "objects" in said and "orusd compose" in said
    path = tmp_path / "a/room.yaml"
    assert path.read_text() == write(generate("closet", 3, clutter=2))
    assert load_room(path).name == "closet_3"
    assert run(*words)[0] == 0  # the same room again


def test_several_rooms_as_data(tmp_path: Path) -> None:
    code, said = run(
        *"generate --type closet --seed 5 --count 3 --area 4 -o".split(), tmp_path, "--json"
    )
    rows = json.loads(said)["rooms"]
    assert code == 0
    assert [row["seed"] for row in rows] == [5, 6, 7]
    for row in rows:
        room = load_room(Path(row["room"]))
        assert Path(row["room"]).parent.name == f"closet_{row['seed']}"
        assert len(room.furniture.objects) == row["objects"]
        assert abs(row["area"] - 4.0) < 0.1


def test_another_room_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "room.yaml").write_text("room: office\n")
    code, said = run("generate", "--type", "office", "-o", tmp_path)
    assert code != 0 and "the folder already has another room" in said
    assert (tmp_path / "room.yaml").read_text() == "room: office\n"


def test_an_unknown_type_is_refused(tmp_path: Path) -> None:
    code, said = run("generate", "--type", "attic", "-o", tmp_path / "a")
    assert code != 0 and "attic" in said
    assert not (tmp_path / "a").exists()
