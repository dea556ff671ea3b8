"""Objects that hang on walls, and objects that are described in the frame of another one."""

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.errors import DescriptionError, StageError
from openrooms_usd.geometry.solids import box
from openrooms_usd.library.assets import Asset, Model
from openrooms_usd.steps.alignment.placement import Placement, ResolvedPose, Supports
from openrooms_usd.steps.alignment.surroundings import Gap, RoomGeometry, surroundings

SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])


def room(corners: np.ndarray = SQUARE, *gaps: Gap) -> RoomGeometry:
    return RoomGeometry(0.5, 3.0, np.stack([corners, np.roll(corners, -1, axis=0)], axis=1), gaps)


def item(name: str, x: float, y: float, **more: object) -> Placement:
    size = more.pop("size", (1.0, 0.2, 0.4))
    category = str(more.pop("category", "thing"))
    asset = Asset(category, (name,), lambda: Model({"body": box(size, (0, 0, size[2] / 2))}))  # type: ignore[arg-type, index]
    return Placement(name, asset, size, x, y, **more)  # type: ignore[arg-type]


def stands(
    *items: Placement, of: RoomGeometry | None = None, notes: list[str] | None = None
) -> dict[str, ResolvedPose]:
    kept = [] if notes is None else notes
    return Supports({thing.name: thing for thing in items}, of or room(), kept).resolve()


@pytest.mark.parametrize("turn", [0.0, 0.3, 2.0, -1.1])
def test_the_back_touches_the_nearest_wall_whatever_its_direction(turn: float) -> None:
    c, s = np.cos(turn), np.sin(turn)
    R = np.array([[c, -s], [s, c]])
    # In the square's own frame: the nearest wall, and the point of it behind the object.
    for place, foot, outward in [
        ((2.0, 0.4), (2.0, 0.0), (0, -1)),
        ((3.5, 1.4), (4.0, 1.4), (1, 0)),
        ((1.5, 2.9), (1.5, 3.0), (0, 1)),
        ((-0.3, 1.6), (0.0, 1.6), (-1, 0)),
    ]:
        x, y = (R @ place).tolist()
        found = stands(item("a", x, y, on="wall", level=1.25), of=room(SQUARE @ R.T))["a"]
        back = np.array([-np.sin(np.radians(found.yaw)), np.cos(np.radians(found.yaw))])
        np.testing.assert_allclose(back, R @ outward, atol=1e-12)
        np.testing.assert_allclose(np.array([found.x, found.y]) + 0.1 * back, R @ foot, atol=1e-9)
        # From the floor that is at 0.5 m.
        assert found.z == 1.75


def test_what_hangs_stays_within_its_wall() -> None:
    found = stands(item("a", 0.2, 0.1, on="wall"), item("b", 3.9, 2.99, on="wall"))
    assert (found["a"].x, found["a"].y) == (0.5, 0.1)
    assert (found["b"].x, found["b"].y) == pytest.approx((3.5, 2.9))


def test_what_is_too_wide_or_hangs_before_an_opening_is_noted() -> None:
    notes: list[str] = []
    window = Gap("window_0", 0, 2.0, 1.0, 1.4, 2.4)
    stands(
        item("broad", 2.0, 2.9, on="wall", size=(4.2, 0.1, 0.3)),
        item("before", 2.9, 0.0, on="wall", z=1.5),
        item("above", 2.9, 0.0, on="wall", z=2.4),
        item("beside", 3.1, 0.0, on="wall", z=1.5),
        item("drapery", 2.0, 0.0, on="wall", z=1.5, category="curtain"),
        of=room(SQUARE, window),
        notes=notes,
    )
    assert notes == ["broad is 4.2 m wide, its wall only 4 m", "before hangs before window_0"]


def test_a_room_without_walls_refuses() -> None:
    with pytest.raises(StageError, match="no walls"):
        stands(item("a", 1, 1, on="wall"), of=RoomGeometry())


def test_frames_of_others_go_on_from_one_to_the_next() -> None:
    found = stands(
        item("c", 1.0, 0.0, relative_to="b", yaw=45.0),
        item("b", 0.0, 1.0, relative_to="a", yaw=90.0),
        item("a", 2.0, 1.0, yaw=90.0),
    )
    # b is at the back of a, which looks to +X with its right at +Y: its back is at -X.
    assert (found["b"].x, found["b"].y, found["b"].yaw) == pytest.approx((1.0, 1.0, 180.0))
    assert (found["c"].x, found["c"].y, found["c"].yaw) == pytest.approx((0.0, 1.0, 225.0))
    assert found["a"].carrier is None


def test_heights_come_from_the_own_support() -> None:
    found = stands(
        item("lamp", 0.1, 0.0, relative_to="sofa", on="side"),
        item("side", 0.0, 0.0, relative_to="sofa", size=(1.0, 1.0, 0.6)),
        item("sofa", 2.0, 1.0, z=0.9),
        item("picture", 0.0, 1.9, relative_to="sofa", on="wall", level=1.0),
    )
    assert {name: stand.z for name, stand in found.items()} == {
        "lamp": 1.1,
        "side": 0.5,
        "sofa": 0.9,
        "picture": 1.5,
    }
    assert found["lamp"].carrier == "side"
    assert found["picture"].y == pytest.approx(2.9)


def test_frames_that_do_not_exist_or_go_round_are_refused() -> None:
    with pytest.raises(DescriptionError, match="a is relative to 'b', which is not an object"):
        stands(item("a", 0, 0, relative_to="b"))
    with pytest.raises(DescriptionError, match="circle: a, b, a"):
        stands(item("a", 0, 0, relative_to="b"), item("b", 0, 0, relative_to="a"))


@pytest.mark.slow
def test_ten_thousand_objects_in_a_chain_and_on_walls() -> None:
    chain = [item("o0", 0.0, 0.0)]
    chain += [item(f"o{i}", 0.001, 0.0, relative_to=f"o{i - 1}") for i in range(1, 5000)]
    hung = [item(f"w{i}", 0.0008 * i, 0.0, on="wall") for i in range(5000)]
    found = stands(*chain, *hung)
    assert found["o4999"].x == pytest.approx(4.999)
    assert len(found) == 10_000


def test_the_room_is_read_where_it_is() -> None:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Xform.Define(stage, names.WORLD).AddTranslateOp().Set((9, 9, 9))
    shell = UsdGeom.Xform.Define(stage, names.ROOM)
    shell.AddTranslateOp().Set((1, 0, 0))
    shell.AddRotateZOp().Set(90.0)
    kind = Sdf.ValueTypeNames
    shell.GetPrim().CreateAttribute(names.ROOM_FLOOR, kind.Double2Array).Set(SQUARE.tolist())
    hole = UsdGeom.Xform.Define(stage, f"{names.OPENINGS}/window_0")
    hole.AddTranslateOp().Set((1.5, 0.0, 1.4))
    for key, value in ((names.OPENING_WIDTH, 1.0), (names.OPENING_HEIGHT, 0.8)):
        hole.GetPrim().CreateAttribute(key, kind.Double).Set(value)
    found = surroundings(stage)
    np.testing.assert_allclose(found.walls[0], [[1, 0], [1, 4]], atol=1e-12)
    [gap] = found.gaps
    assert gap[:2] == ("window_0", 0)
    assert gap[2:] == pytest.approx((1.5, 1.0, 1.0, 1.8))
    assert (found.floor, found.ceiling) == (0.0, None)
