"""Free-standing walls as the steps author and read them."""

from pathlib import Path

import numpy as np
import pytest
import shapely
from pxr import Usd, UsdGeom, UsdPhysics

from openrooms_usd import names
from openrooms_usd.composing import compose_room
from openrooms_usd.description import parse_room
from openrooms_usd.errors import DescriptionError, StageError
from openrooms_usd.furniture import category
from openrooms_usd.generation.expansion import expanded
from openrooms_usd.steps.alignment.surroundings import surroundings
from openrooms_usd.usd.light.lights import read_portals
from openrooms_usd.usd.places.partitions import read_partitions
from openrooms_usd.usd.semantics import read_label

TEXT = """
layout:
  polygon: [[0, 0], [6, 0], [6, 4], [0, 4]]
  partitions:
    - {line: [[3, 0], [3, 2.5]]}
    - {name: screen, line: [[1, 3], [1, 1.5]], height: 120 cm, thickness: 0.2}
  openings:
    - {kind: window, wall: 3}
    - {kind: door, partition: partition_0, at: 1.0, open: 45}
furniture:
  objects: [{category: picture, at: [3.3, 2.2], on: wall}, {category: chair, at: [5, 3]}]
physics: {}
cameras: {resolution: [40, 30], views: [{eye: [5.8, 3.8, 1.6], target: [3, 1.5, 1]}]}
"""


@pytest.fixture(scope="module")
def stage(tmp_path_factory: pytest.TempPathFactory) -> Usd.Stage:
    folder = tmp_path_factory.mktemp("partitions")
    (folder / "room.yaml").write_text(TEXT)
    compose_room(folder / "room.yaml", folder / "out")
    return Usd.Stage.Open(str(folder / "out" / names.SCENE))


@pytest.mark.slow
def test_they_are_walls_with_colliders_and_looks(stage: Usd.Stage, assert_valid) -> None:
    assert_valid(Path(stage.GetRootLayer().realPath))
    for name in ("partition_0", "screen"):
        prim = stage.GetPrimAtPath(f"{names.WALLS}/{name}")
        assert read_label(prim, names.CATEGORY) == "wall"
        assert [p for p in stage.Traverse() if p.GetName().startswith(name) and _collides(p)]
    low = UsdGeom.Mesh(stage.GetPrimAtPath(f"{names.WALLS}/screen"))
    assert np.array(low.GetPointsAttr().Get())[:, 2].max() == pytest.approx(1.2)


def _collides(prim: Usd.Prim) -> bool:
    return bool(UsdPhysics.CollisionAPI(prim))


def test_what_is_read_is_what_was_described(stage: Usd.Stage) -> None:
    first, screen = read_partitions(stage)
    assert first.path == f"{names.WALLS}/partition_0"
    assert (first.height, screen.height) == (2.6, 1.2)
    off = shapely.Polygon(first.outline) ^ shapely.box(2.95, 0, 3.05, 2.5)
    assert off.area == pytest.approx(0.0, abs=1e-9)
    # The room is on the left of both faces.
    for start, end in screen.faces:
        left = np.array([start[1] - end[1], end[0] - start[0]]) / np.linalg.norm(end - start)
        beside = shapely.Point(0.5 * (start + end) + 0.01 * left)
        assert shapely.Polygon(screen.outline).distance(beside) == pytest.approx(0.01)


def test_a_door_in_one_stands_in_it_and_lets_no_daylight_in(stage: Usd.Stage) -> None:
    door = stage.GetPrimAtPath(f"{names.OPENINGS}/door_0")
    targets = door.GetRelationship(names.OPENING_WALL).GetTargets()
    assert targets == [f"{names.WALLS}/partition_0"]
    place = UsdGeom.Xformable(door).ComputeLocalToWorldTransform(0).ExtractTranslation()
    assert tuple(place) == pytest.approx((3.05, 1.0, 0.5 * 2.05))
    assert [p.path.rpartition("/")[2] for p in read_portals(stage)] == ["window_0"]


def test_things_hang_on_both_of_its_faces(stage: Usd.Stage) -> None:
    room = surroundings(stage)
    assert len(room.walls) == 4
    assert len(room.faces) == 8
    east, west = room.hang(3.4, 2.0, 0.4, 0.02), room.hang(2.6, 2.0, 0.4, 0.02)
    assert (east.x, west.x) == pytest.approx((3.06, 2.94))
    assert np.cos(np.radians(east.yaw - west.yaw)) == pytest.approx(-1.0)
    # Its door is in the way on both of them.
    for x in (3.4, 2.6):
        hung = room.hang(x, 1.1, 0.4, 0.02)
        assert room.covered(hung, 0.4, 1.0, 1.5) == ["door_0"]
    picture = stage.GetPrimAtPath(f"{names.FURNITURE}/picture_0")
    assert UsdGeom.Xformable(picture).GetLocalTransformation().ExtractTranslation()[
        0
    ] == pytest.approx(3.05, abs=0.05)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("[[3, 0], [3, 2.5]]", "[[3, 0], [3, 6]]"), "partition_0 does not lie inside the room"),
        (("at: 1.0", "at: 2.4"), "in partition_0 reaches beyond"),
        (("partition: partition_0", "partition: partition_1"), "there is no partition"),
        (("partition: partition_0", "wall: 1, partition: screen"), "not in both"),
        (("partition: partition_0, at: 1.0", "at: 1.0"), "'wall' is missing"),
        (("partition: partition_0", "partition: screen"), "reaches"),
    ],
)
def test_mistakes_are_said(change: tuple[str, str], said: str, tmp_path: Path) -> None:
    assert change[0] in TEXT
    (tmp_path / "room.yaml").write_text(TEXT.replace(*change))
    with pytest.raises((DescriptionError, StageError), match=said):
        compose_room(tmp_path / "room.yaml", tmp_path / "out")


def test_generated_furniture_keeps_off_them() -> None:
    text = """
room: bedroom
seed: 5
layout:
  polygon: [[0, 0], [6, 0], [6, 4], [0, 4]]
  partitions: [{line: [[3.5, 0], [3.5, 4]]}]
  openings: [{kind: door, wall: 0, at: 1}, {kind: window, wall: 3},
             {kind: opening, partition: partition_0, at: 2}]
furniture: {from: generate}
"""
    room = expanded(parse_room(text))
    kept = shapely.box(3.45, 0, 3.55, 4).union(shapely.box(2.7, 1.6, 4.3, 2.4))
    standing = [
        o
        for o in room.furniture.objects
        if (o.on or category(o.category).support) == "floor" and o.size
    ]
    assert len(standing) >= 3
    for thing in standing:
        if thing.relative_to or thing.category == "rug":
            continue
        width, depth, _ = thing.size
        box = shapely.affinity.rotate(
            shapely.box(-width / 2, -depth / 2, width / 2, depth / 2), thing.yaw, origin=(0, 0)
        )
        plan = shapely.affinity.translate(box, *thing.at[:2])
        assert plan.intersection(kept).area < 1e-3, thing
