"""Heights of objects follow from what carries them."""

import numpy as np
import pytest

from openrooms_usd.errors import DescriptionError, StageError
from openrooms_usd.geometry.solids import box, sphere
from openrooms_usd.library.assets import Asset, Model
from openrooms_usd.steps.alignment.placement import Placement, ResolvedPose, Supports, top_at
from openrooms_usd.steps.alignment.surroundings import RoomGeometry


def _item(name: str, x: float = 0.0, y: float = 0.0, **more: object) -> Placement:
    size = more.pop("size", (1.0, 1.0, 0.5))
    solid = box(size, (0.0, 0.0, 0.5 * size[2]))  # type: ignore[arg-type, index]
    asset = Asset("thing", (name,), lambda: Model({"body": solid}))
    return Placement(name, asset, size, x, y, **more)  # type: ignore[arg-type]


def _heights(*items: Placement, ceiling: float | None = 2.5) -> dict[str, float]:
    return {name: stand.z for name, stand in _stands(*items, ceiling=ceiling).items()}


def _stands(
    *items: Placement, ceiling: float | None = 2.5, notes: list[str] | None = None
) -> dict[str, ResolvedPose]:
    kept = [] if notes is None else notes
    room = RoomGeometry(0.0, ceiling)
    return Supports({item.name: item for item in items}, room, kept).resolve()


def test_floor_ceiling_and_given_heights() -> None:
    found = _heights(
        _item("low"), _item("lamp", on="ceiling", size=(0.4, 0.4, 0.3)), _item("free", z=1.25)
    )
    assert found == {"low": 0.0, "lamp": pytest.approx(2.2), "free": 1.25}


def test_towers_in_any_order() -> None:
    found = _heights(_item("top", on="middle"), _item("middle", on="low"), _item("low"))
    assert found == {"top": 1.0, "middle": 0.5, "low": 0.0}


def test_a_surface_is_the_highest_thing_below() -> None:
    found = _heights(
        _item("lamp", x=0.4, on="surface"),
        _item("table"),
        _item("shelf", x=0.5, size=(1, 1, 2)),
        _item("elsewhere", x=3.0, on="surface"),
    )
    assert found["lamp"] == 2.0
    assert found["elsewhere"] == 0.0


def test_a_surface_is_a_top_at_the_place_of_what_stands_on_the_floor() -> None:
    # The back of the chair is higher than the table, its seat below the lamp is not.
    seat, back = box((1, 1, 0.4), (0, 0, 0.2)), box((1, 0.1, 1.2), (0, 0.45, 0.6))
    asset = Asset("chair", ("chair",), lambda: Model({"seat": seat, "back": back}))
    chair = Placement("chair", asset, (1, 1, 1.2), 0.0, 0.0)
    found = _heights(
        _item("lamp", on="surface"),
        _item("table", size=(1, 1, 0.7)),
        chair,
        _item("hangs", z=1.5, size=(1, 1, 3)),
    )
    assert found["lamp"] == pytest.approx(0.7)


def test_outlines_turn_with_their_object() -> None:
    table = _item("table", size=(2.0, 0.4, 0.7), yaw=90.0)
    on, off = _item("on", y=0.9, on="surface"), _item("off", x=0.9, on="surface")
    assert _heights(table, on, off) == {"table": 0.0, "on": 0.7, "off": 0.0}


def test_places_are_found_in_the_objects_own_frame() -> None:
    table = _item("table", x=2.0, y=1.0, yaw=90.0)
    assert table.to_local(2.0, 1.4) == pytest.approx((0.4, 0.0))
    assert table.to_local(1.7, 1.0) == pytest.approx((0.0, 0.3))


def test_what_stands_beside_its_support_is_noted() -> None:
    notes: list[str] = []
    items = [_item("table"), _item("lamp", x=5.0, on="table")]
    assert _stands(*items, notes=notes)["lamp"].z == 0.5
    assert "lamp is not above table" in notes[0]


def test_circles_and_unknown_supports_are_refused() -> None:
    with pytest.raises(DescriptionError, match="circle: a, b, a"):
        _heights(_item("a", on="b"), _item("b", on="a"))
    with pytest.raises(DescriptionError, match="'c', which is not an object"):
        _heights(_item("a", on="c"))
    with pytest.raises(StageError, match="no ceiling"):
        _heights(_item("a", on="ceiling"), ceiling=None)


def test_the_top_of_a_sphere() -> None:
    model = Model({"low": box((9, 9, 0.1)), "ball": sphere(1.0, segments=128)})
    for x, y in [(0.0, 0.0), (0.3, 0.4), (-0.5, 0.1)]:
        assert top_at(model, x, y) == pytest.approx(np.sqrt(1 - x * x - y * y), abs=2e-3)
    assert top_at(model, 2.0, 0.0) == pytest.approx(0.05)
    assert top_at(model, 5.0, 0.0) is None


def test_what_leans_lies_with_its_lowest_point_on_its_support() -> None:
    # A cube of 1 m that leans back by 45 degrees stands on its back edge.
    cube = _item("cube", size=(1.0, 1.0, 1.0), tilt=(-45.0, 0.0), on="low")
    found = _stands(_item("low"), cube, _item("on", size=(0.1, 0.1, 0.1), on="cube"))
    assert found["cube"].z == pytest.approx(0.5 + np.sqrt(0.125))
    assert found["cube"].tilt == (-45.0, 0.0)
    assert found["on"].z == pytest.approx(0.5 + np.sqrt(0.125) + np.sqrt(0.5))
    # Where its place is given, that is the middle of its base.
    assert _stands(_item("free", z=1.0, tilt=(30.0, 10.0)))["free"].z == 1.0
