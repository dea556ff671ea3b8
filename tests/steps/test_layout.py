from pathlib import Path

import numpy as np
import pytest
import shapely
from pxr import Usd, UsdGeom

from openrooms_usd.description import parse_room
from openrooms_usd.errors import DescriptionError, InputError
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.layout.step import LayoutStep
from openrooms_usd.usd.files.layers import apply_metadata
from openrooms_usd.usd.semantics import read_label

L_SHAPE = [[0, 0], [5, 0], [5, 2], [2, 2], [2, 4], [0, 4]]
ROOMS = {
    "counter-clockwise": L_SHAPE,
    # The same walls with the same numbers from the other side: mirrored.
    "clockwise": [[-x, y] for x, y in L_SHAPE],
}
OPENINGS = """
  openings:
    - {kind: window, wall: 0, at: 1.0}
    - {kind: door, wall: 1, at: 60 cm, open: 30 deg, name: entrance}
    - {kind: opening, wall: 4, at: 0.8, width: 70 cm, height: 2.1}
    - {kind: door, wall: 0, at: 4.2, hinge: right, swing: out, open: 90}
"""


def author(text: str, source: Path = Path()) -> tuple[Usd.Stage, StepContext]:
    stage = Usd.Stage.CreateInMemory()
    apply_metadata(stage.GetRootLayer())
    context = StepContext(parse_room(text), source, stage, source / "layout")
    LayoutStep().author(context)
    return stage, context


def room(polygon: object, openings: str = OPENINGS) -> str:
    return f"room: office\nlayout:\n  polygon: {polygon}{openings}"


def to_world(prim: Usd.Prim, *points: list[float]) -> np.ndarray:
    M = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(0))
    return np.array([[*p, 1.0] for p in points]) @ M[:, :3]


def triangles(stage: Usd.Stage) -> RayCaster:
    points, rows = [np.empty((0, 3))], [np.empty((0, 3), dtype=int)]
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.Mesh):
            mesh = UsdGeom.Mesh(prim)
            offset = sum(len(p) for p in points)
            points.append(to_world(prim, *np.array(mesh.GetPointsAttr().Get()).tolist()))
            face = np.split(
                np.array(mesh.GetFaceVertexIndicesAttr().Get()),
                np.cumsum(mesh.GetFaceVertexCountsAttr().Get())[:-1],
            )
            fans = [[f[0], f[i], f[i + 1]] for f in face for i in range(1, len(f) - 1)]
            rows.append(np.array(fans) + offset)
    return RayCaster(np.concatenate(points), np.concatenate(rows))


def test_the_hierarchy_its_kinds_and_labels() -> None:
    stage, _ = author(room(L_SHAPE))
    paths = {str(prim.GetPath()): prim for prim in stage.Traverse()}
    assert [p for p in paths if "wall_" in p] == [f"/World/Room/Walls/wall_{i}" for i in range(6)]
    for path, kind, category in (
        ("/World", "assembly", None),
        ("/World/Room", "component", None),
        ("/World/Room/Floor", "", "floor"),
        ("/World/Room/Ceiling", "", "ceiling"),
        ("/World/Room/Walls/wall_3", "", "wall"),
        ("/World/Room/Openings/window_0", "subcomponent", "window"),
        ("/World/Room/Openings/entrance", "subcomponent", "door"),
        ("/World/Room/Openings/opening_0", "subcomponent", "opening"),
        ("/World/Room/Openings/door_1/Leaf/Panel", "", "door"),
    ):
        assert Usd.ModelAPI(paths[path]).GetKind() == kind, path
        assert read_label(paths[path], "category") == category, path
    assert read_label(paths["/World/Room/Openings/door_1/Leaf/Handle"], "part") == "handle"
    assert "/World/Room/Openings/opening_0/Frame" not in paths
    assert stage.GetDefaultPrim().GetPath() == "/World"


@pytest.mark.parametrize("name", ROOMS)
def test_openings_say_where_they_are(name: str) -> None:
    polygon = np.array(ROOMS[name], dtype=float)
    stage, _ = author(room(ROOMS[name]))
    inside = shapely.Polygon(polygon)
    for prim, wall, at, width, height, sill in (
        ("window_0", 0, 1.0, 1.2, 1.3, 0.9),
        ("entrance", 1, 0.6, 0.9, 2.05, 0.0),
        ("opening_0", 4, 0.8, 0.7, 2.1, 0.0),
        ("door_1", 0, 4.2, 0.9, 2.05, 0.0),
    ):
        opening = stage.GetPrimAtPath(f"/World/Room/Openings/{prim}")
        assert "OpenRoomsOpeningAPI" in opening.GetPrimTypeInfo().GetAppliedAPISchemas()
        values = [
            opening.GetAttribute(f"openrooms:opening:{key}").Get()
            for key in ("width", "height", "sill")
        ]
        assert values == pytest.approx([width, height, sill])
        assert opening.GetAttribute("openrooms:opening:kind").Get() == prim.replace(
            "entrance", "door"
        ).rstrip("_01")
        targets = opening.GetRelationship("openrooms:opening:wall").GetTargets()
        assert targets == [f"/World/Room/Walls/wall_{wall}"]
        # The middle of its rectangle, from the wall's start as the description lists the corners.
        start, end = polygon[wall], polygon[(wall + 1) % len(polygon)]
        middle = start + (end - start) * at / np.linalg.norm(end - start)
        origin, right, out, up = to_world(opening, [0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1])
        assert origin == pytest.approx([*middle, sill + 0.5 * height])
        assert up - origin == pytest.approx([0, 0, 1])
        assert not inside.contains(shapely.Point((origin + 0.01 * (out - origin))[:2]))
        assert inside.contains(shapely.Point((origin - 0.01 * (out - origin))[:2]))
        assert np.cross(right - origin, out - origin) == pytest.approx([0, 0, 1])
        # The hole is really there, in the wall that it names.
        mesh = UsdGeom.Mesh(stage.GetPrimAtPath(targets[0]))
        points = np.array(mesh.GetPointsAttr().Get())
        corners = [[x, 0.0, z] for x in (-0.5 * width, 0.5 * width) for z in (-0.5, 0.5)]
        scaled = np.array(corners) * [1, 1, height]
        for corner in to_world(opening, *scaled.tolist()):
            assert np.linalg.norm(points - corner, axis=1).min() < 1e-5


@pytest.mark.parametrize("name", ROOMS)
def test_the_room_says_its_type_height_and_floor_counter_clockwise(name: str) -> None:
    stage, _ = author(room(ROOMS[name]))
    prim = stage.GetPrimAtPath("/World/Room")
    assert "OpenRoomsRoomAPI" in prim.GetPrimTypeInfo().GetAppliedAPISchemas()
    assert prim.GetAttribute("openrooms:room:type").Get() == "office"
    assert prim.GetAttribute("openrooms:room:height").Get() == 2.6
    floor = shapely.Polygon(np.array(prim.GetAttribute("openrooms:room:floor").Get()))
    assert floor.exterior.is_ccw
    assert floor.equals(shapely.Polygon(ROOMS[name]))


@pytest.mark.parametrize("name", ROOMS)
def test_light_enters_a_room_with_closed_doors_through_its_windows_alone(name: str) -> None:
    """Of the authored stage: every ray that leaves passes a window's or a passage's rectangle."""
    stage, _ = author(
        room(
            ROOMS[name], OPENINGS.replace("open: 30 deg", "open: 0").replace("open: 90", "open: 0")
        )
    )
    rng = np.random.default_rng(2)
    origins = np.tile([0.9, 1.1, 1.3], (20_000, 1))
    if name == "clockwise":
        origins[:, 0] *= -1.0
    directions = rng.normal(size=origins.shape)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    free = np.isinf(triangles(stage).first_hit(origins, directions).distance)
    through = np.zeros(len(free), dtype=bool)
    for key, width, height in (("window_0", 1.2, 1.3), ("opening_0", 0.7, 2.1)):
        prim = stage.GetPrimAtPath(f"/World/Room/Openings/{key}")
        origin, right, out = to_world(prim, [0, 0, 0], [1, 0, 0], [0, 1, 0])
        with np.errstate(divide="ignore"):
            t = (origin - origins) @ (out - origin) / (directions @ (out - origin))
        offset = origins + directions * t[:, None] - origin
        across = np.abs(offset @ (right - origin)) < 0.5 * width
        through |= (t > 0) & across & (np.abs(offset[:, 2]) < 0.5 * height)
    assert free.sum() > 100
    assert not (free & ~through).any()


def test_an_open_leaf_turns_about_its_hinge() -> None:
    stage, _ = author(room(L_SHAPE))
    leaf = stage.GetPrimAtPath("/World/Room/Openings/entrance/Leaf")
    panel = UsdGeom.Mesh(stage.GetPrimAtPath(f"{leaf.GetPath()}/Panel"))
    points = to_world(panel.GetPrim(), *np.array(panel.GetPointsAttr().Get()).tolist())
    # Wall 1 is at x = 5 and runs north: seen from inside, left is north. The door is 0.15 to 1.05.
    lock = points[np.argmin(points[:, 0])]
    assert lock[0] == pytest.approx(5 - 0.83 * np.sin(np.radians(30)), abs=0.05)
    assert points[:, 1].max() == pytest.approx(1.05 - 0.03, abs=0.03)


def test_a_leaf_that_would_meet_a_wall_opens_less_and_says_so() -> None:
    _, context = author(
        "layout: {openings: [{kind: door, wall: 0, at: 52 cm, open: 170, hinge: right}]}"
    )
    assert len(context.notes) == 1
    assert "door_0 opens" in context.notes[0]


def test_equal_descriptions_give_equal_bytes() -> None:
    stages = [author(room(L_SHAPE))[0] for _ in range(2)]  # kept: a layer dies with its stage
    first, second = (stage.GetRootLayer().ExportToString() for stage in stages)
    assert first == second


@pytest.mark.parametrize(
    ("openings", "words"),
    [
        (
            "[{kind: window, wall: 2, width: 3, name: big}]",
            ["openings[0]: big in wall 2 is 3.000 m wide", "2.760 m of its 3.000 m", "0.020 m"],
        ),
        ("[{kind: door, wall: 0, at: 0.3}]", ["door_0 in wall 0 reaches beyond the right end"]),
        (
            "[{kind: window, wall: 0, height: 2.5}]",
            ["reaches up to 3.400 m", "ceiling is at 2.600"],
        ),
        (
            "[{kind: window, wall: 0, at: 1}, {kind: door, wall: 0, at: 1.9}]",
            ["window_0 and door_0 in wall 0 overlap", "0.400 to 1.600 m", "1.450 to 2.350 m"],
        ),
        (
            "[{kind: window, wall: 0, height: 9}, {kind: door, wall: 3, width: 9}]",
            ["openings[0]", "openings[1]"],
        ),
    ],
)
def test_openings_that_do_not_fit_are_refused_with_numbers(openings: str, words: list[str]) -> None:
    with pytest.raises(DescriptionError) as error:
        author(f"layout:\n  polygon: {L_SHAPE}\n  openings: {openings}")
    text = str(error.value)
    assert "layout.openings" in text
    assert all(word in text for word in words), text


def test_a_polygon_without_room_for_walls_is_refused() -> None:
    with pytest.raises(DescriptionError, match="nearer than 1 mm"):
        author("layout: {polygon: [[0, 0], [4, 0], [4, 3], [2, 0.0005], [0, 3]]}")


def test_a_missing_capture_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        author("layout: {from: roomplan, file: none.json}", tmp_path)
    step = LayoutStep()
    assert step.inputs(parse_room("layout: {from: roomplan, file: a.json}"), Path()) == ["a.json"]
    assert list(step.inputs(parse_room("name: a"), Path())) == []
