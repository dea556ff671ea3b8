"""A room composes the same from its file, from a Room and from wherever its files begin."""

from pathlib import Path

import pytest

from openrooms_usd.composing import compose_room
from openrooms_usd.description import load_room, parse_room
from openrooms_usd.errors import DescriptionError
from openrooms_usd.names import STEPS, section_of

ROOM = """\
room: office
layout: {polygon: [[0, 0], [3, 0], [3, 3], [0, 3]]}
furniture: {objects: [{name: thing, file: thing.obj, category: box, at: [1, 1]}]}
materials: {resolution: 16}
"""
MESH = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1\n" + "".join(
    f"f {face}\n" for face in ("4 3 2 1", "1 2 5", "2 3 5", "3 4 5", "4 1 5")
)


@pytest.fixture
def described(tmp_path: Path) -> Path:
    folder = tmp_path / "described"
    folder.mkdir()
    (folder / "room.yaml").write_text(ROOM)
    (folder / "thing.obj").write_text(MESH)
    return folder


def layers(out: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (out / "layers").glob("*.usda")}


@pytest.mark.slow
def test_a_room_finds_its_files_however_it_is_given(
    described: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compose_room(described / "room.yaml", tmp_path / "a")
    compose_room(load_room(described / "room.yaml"), tmp_path / "b")
    compose_room(parse_room(ROOM), tmp_path / "c", base=described)
    monkeypatch.chdir(described)
    compose_room(parse_room(ROOM), tmp_path / "d")
    first = layers(tmp_path / "a")
    assert f"{STEPS[1]}.usda" in first
    assert all(layers(tmp_path / name) == first for name in "bcd")


def test_a_file_that_is_not_there_is_named_where_it_was_looked_for(
    described: Path, tmp_path: Path
) -> None:
    with pytest.raises(DescriptionError) as refused:
        compose_room(parse_room(ROOM), tmp_path / "out", base=tmp_path)
    said = f"3:43: furniture.objects[0].file: {tmp_path / 'thing.obj'}: no such file"
    assert said in str(refused.value)


def test_progress_goes_from_nothing_to_the_whole(described: Path, tmp_path: Path) -> None:
    seen: list[tuple[str, float]] = []
    compose_room(
        described / "room.yaml", tmp_path, progress=lambda what, part: seen.append((what, part))
    )
    assert list(dict.fromkeys(what for what, _ in seen)) == list(map(section_of, STEPS))
    assert [part for _, part in seen] == sorted(part for _, part in seen)
    assert seen[0][1] == 0.0 and seen[-1][1] == 1.0
