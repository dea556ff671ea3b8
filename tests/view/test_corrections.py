"""What pages of corrections may be asked for, and what they refuse."""

import json
import shutil
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.library.thumbnails import thumbnail
from openrooms_usd.view.corrections import corrections
from openrooms_usd.view.materials import materials_app
from openrooms_usd.view.objects import objects_app
from openrooms_usd.view.server import TOKEN_HEADER, Server, serving

SEAT = "/World/Furniture/chair_1/Geometry/seat"


@pytest.fixture
def scene(composed_demo: Path, tmp_path: Path) -> Path:
    shutil.copytree(composed_demo.parent, tmp_path / "out")
    return tmp_path / "out/scene.usda"


@pytest.fixture
def materials(scene: Path) -> Iterator[Server]:
    with serving(materials_app(corrections(scene))) as server:
        yield server


@pytest.fixture
def furniture(scene: Path) -> Iterator[Server]:
    with serving(objects_app(corrections(scene))) as server:
        yield server


def asked(server: Server, path: str, given: Any = None) -> tuple[int, bytes]:
    data = None if given is None else json.dumps(given).encode()
    request = urllib.request.Request(
        f"http://127.0.0.1:{server.server_port}/{path}", data, {TOKEN_HEADER: server.token}
    )
    try:
        with urllib.request.urlopen(request) as answer:
            return answer.status, answer.read()
    except urllib.error.HTTPError as error:
        with error:
            return error.code, error.read()


def test_pictures_are_those_of_the_library_and_nothing_else_has_a_name(materials: Server) -> None:
    assert asked(materials, "resource/material/nappa/3.png") == (200, thumbnail("nappa", 3))
    for name in ("dragon/3.png", "nappa/64.png", "nappa/-1.png", "../../etc/passwd", "nappa"):
        assert asked(materials, f"resource/material/{name}")[0] == 404, name


@pytest.mark.parametrize(
    ("given", "status", "words"),
    [
        ({"path": SEAT, "scope": "room", "look": "wood"}, 400, "scope"),
        ({"path": SEAT, "scope": "part"}, 400, "look"),
        ({"path": SEAT, "scope": "part", "look": "wood", "more": 1}, 400, "more"),
        ({"path": SEAT, "scope": "part", "look": {"file": "/etc"}}, 422, "not files"),
        ({"path": SEAT, "scope": "part", "look": "oak_plank"}, 422, "did you mean 'oak_planks'"),
        ({"path": "/World/../x", "scope": "part", "look": "wood"}, 422, "no such prim"),
    ],
)
def test_what_comes_with_a_material_is_checked(
    materials: Server, scene: Path, given: dict[str, Any], status: int, words: str
) -> None:
    before = (scene.parent / "layers/edits.usda").read_bytes()
    found, answer = asked(materials, "command/assign", given)
    assert (found, words in answer.decode()) == (status, True), answer
    assert (scene.parent / "layers/edits.usda").read_bytes() == before


@pytest.mark.parametrize(
    ("command", "given", "status"),
    [
        ("place", {"name": "chair_1", "x": "far", "y": 0, "yaw": 0}, 400),
        ("place", {"name": "chair_1", "x": 1e300, "y": 0, "yaw": 0}, 400),
        ("place", {"name": "chair_1", "x": 1, "y": 1, "yaw": 0, "size": [1, 1, -1]}, 400),
        ("place", {"name": "chair_1", "x": 1, "y": 1, "yaw": 0, "size": [0, 1, 1]}, 400),
        ("place", {"name": "../Room", "x": 1, "y": 1, "yaw": 0}, 422),
        ("remove", {"name": "sofa"}, 422),
        ("remake", {"name": "chair_1", "category": "chair", "style": "rococo"}, 422),
        ("relabel", {"name": "chair_1", "category": "chiar"}, 422),
        ("undo", {}, 422),
        ("compose", {}, 422),
        ("adopt", {}, 404),
    ],
)
def test_what_comes_with_furniture_is_checked(
    furniture: Server, scene: Path, command: str, given: dict[str, Any], status: int
) -> None:
    before = (scene.parent / "layers/edits.usda").read_bytes()
    assert asked(furniture, f"command/{command}", given)[0] == status
    assert (scene.parent / "layers/edits.usda").read_bytes() == before


def test_what_is_put_far_out_of_the_room_is_told_and_can_be_taken_back(
    furniture: Server, scene: Path
) -> None:
    before = (scene.parent / "layers/edits.usda").read_bytes()
    given = {"name": "chair_1", "x": 99, "y": 1.5, "yaw": 0}
    told = json.loads(asked(furniture, "command/place", given)[1])
    assert len(told["warnings"]) == 1 and "out of the room" in told["warnings"][0]
    assert asked(furniture, "command/undo", {})[0] == 200
    assert (scene.parent / "layers/edits.usda").read_bytes() == before


def test_a_question_writes_nothing_and_says_where_it_would_stand(
    furniture: Server, scene: Path
) -> None:
    before = (scene.parent / "layers/edits.usda").read_bytes()
    given = {"name": "chair_1", "x": 4.1, "y": 1.5, "yaw": 85}
    status, answer = asked(furniture, "command/try", given)
    assert status == 200 and (scene.parent / "layers/edits.usda").read_bytes() == before
    assert json.loads(answer) == pytest.approx({"x": 3.735, "y": 1.5, "yaw": 90.0}, abs=1e-4)
    placed = json.loads(asked(furniture, "command/place", given)[1])
    assert placed["object"]["x"] == pytest.approx(3.735, abs=1e-4) and placed["undo"] == 1


def test_what_is_no_composed_room_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not a composed room"):
        corrections(tmp_path / "scene.usda")
