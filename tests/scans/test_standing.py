"""Scans that are turned to every axis and written in every unit: never nonsense without a word."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.capture import read_capture
from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.reconstruction import without_rooms
from openrooms_usd.scan.rooms.verticals import Vertical
from orusd_scans.plainscan import Standing, find_standing, upright
from orusd_scans.scanaxes import UNITS, Asked, find_unit, unit_named
from tests.scan.scanned_rooms import RoomScan

Real = Callable[[str], Path]

WAYS = [
    np.array(way, float)
    for way in ((0, 0, 1), (0, 0, -1), (0, 1, 0), (0, -1, 0), (1, 0, 0), (-1, 0, 0))
]
Z = WAYS[0]
SCALES = (0.001, 0.01, 0.3048, 1.0, 1 / 0.3048, 1 / 0.0254, 100.0, 1000.0)
THINGS = (
    (0.3, 0.2, 1.6, 0.8, 0.0, 0.75),
    (2.2, 1.4, 0.9, 0.9, 0.0, 0.45),
    (4.3, 0.5, 0.6, 1.9, 0.0, 1.8),
    (0.2, 2.9, 2.0, 0.9, 0.0, 0.5),
    (3.0, 2.6, 1.2, 0.7, 0.7, 0.74),
)


@pytest.fixture(scope="module")
def room() -> Cloud:
    """A furnished room of 5 by 4 by 2.5 metres, Z up, without labels."""
    scan = RoomScan(((0, 0), (5, 0), (5, 4), (0, 4)), boxes=THINGS, spacing=0.05)
    return Cloud(scan.cloud().points)


def turned(cloud: Cloud, way: np.ndarray, scale: float = 1.0) -> Cloud:
    return Cloud(scale * cloud.points @ upright(way), label=cloud.label)


def stands(cloud: Cloud, up: str | None = None, unit: str = "auto") -> Standing:
    said = np.array([float(word) for word in (up or "0,0,1").split(",")])
    asked = Asked(said, up is not None, unit_named(unit, Path("s")))
    return find_standing(cloud, asked, Path("s"))


def outcome(cloud: Cloud, way: np.ndarray, scale: float) -> str:
    """What becomes of a Z-up scan in metres that is turned and scaled."""
    try:
        found = stands(turned(cloud, way, scale))
    except InputError as error:
        assert "--up" in error.remedy or "--unit" in error.remedy
        return "refused"
    right = found.up @ way > np.cos(np.deg2rad(14)) and found.unit * scale == pytest.approx(1.0)
    return ("right" if right else "wrong") + (", told" if found.notes else "")


@pytest.mark.parametrize("way", WAYS[2:], ids=str)
def test_a_room_on_its_side_is_put_upright_and_that_is_said(room: Cloud, way: np.ndarray) -> None:
    found = stands(turned(room, way))
    np.testing.assert_array_equal(found.up, way)
    assert "taken for up" in found.notes[0]
    assert "--up" in found.notes[0]
    assert found.settled == {"up": ",".join(f"{value:g}" for value in way)}


def test_what_stands_as_files_do_goes_without_a_word(room: Cloud) -> None:
    found = stands(room)
    assert (found.up == Z).all()
    assert (found.unit, dict(found.settled), found.notes) == (1.0, {}, ())


def test_sizes_that_are_told_are_of_the_vertical_that_was_weighed() -> None:
    as_said = Vertical(Z, 0.0, 5.0, 2.6, (2.6, 6.0))
    other = Vertical(WAYS[4], 1.9, 5.0, 2.6, (2.6, 5.0))
    asked = Asked(Z, True, unit_named("ft", Path("s")))
    with pytest.raises(InputError, match=r"in feet the scan would be 1\.8 m wide") as caught:
        find_unit((other, as_said), asked, Path("s"), [])
    assert caught.value.remedy.startswith("`--unit m` would make it 6 m wide")


def ball(count: int, center: tuple[float, float, float] = (2.0, 2.0, 1.1)) -> np.ndarray:
    """A target of 7 cm that was scanned finely."""
    way = np.random.default_rng(3).normal(size=(count, 3))
    return np.asarray(center) + 0.035 * way / np.linalg.norm(way, axis=1, keepdims=True)


# What is there beside a room, by the number of its points.
DENSE: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "zeros": lambda points: np.zeros_like(points),
    "ten times the zeros": lambda points: np.zeros((10 * len(points), 3)),
    "one point repeated": lambda points: np.tile(points[7], (len(points), 1)),
    "a target": lambda points: ball(len(points)),
    "a target of ten times the points": lambda points: ball(10 * len(points)),
    "three targets": lambda p: np.concatenate([ball(len(p), (x, 1, 1)) for x in (1.0, 2.0, 4.0)]),
    "a floor scanned four times": lambda points: np.concatenate(
        [points[points[:, 2] < 0.05] + [0, 0, 0.0005 * i] for i in range(4)]
    ),
    "strays": lambda points: points[::2000] * 1000.0,
    "a stray that is damaged": lambda points: points[:1] * 1e37,
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", DENSE)
def test_evidence_is_of_area_and_not_of_points(room: Cloud, name: str) -> None:
    """Half of the points, and more, in one place change nothing."""
    points = np.concatenate([DENSE[name](room.points), room.points])
    found = stands(turned(Cloud(points), WAYS[2], 1000.0))
    np.testing.assert_array_equal(found.up, WAYS[2])
    assert found.unit == 0.001


@pytest.mark.parametrize("name", ["yup_half_zero", "yup_one_point_repeated"])
def test_files_half_of_whose_points_are_one(real: Real, name: str) -> None:
    read = read_capture("scan", real(f"faults/zero_points/{name}.ply"))
    assert "0,1,0 is taken for up" in " ".join(read.notes)
    sizes = np.ptp(np.percentile(np.unique(read.cloud.points, axis=0), (1, 99), axis=0), axis=0)
    np.testing.assert_allclose(np.sort(sizes), [2.7, 4.0, 5.0], atol=0.1)


def test_an_origin_is_that_of_the_room_and_not_of_repeated_zeros(
    room: Cloud, tmp_path: Path
) -> None:
    far = room.points + np.array([500_000.0, 5_400_000.0, 100.0])
    np.savez(tmp_path / "a.npz", points=np.concatenate([np.zeros_like(far), far]))
    capture = read_capture("scan", tmp_path / "a.npz")
    assert np.abs(np.median(capture.cloud.points, axis=0)).max() < 10.0


def test_a_room_upside_down_is_never_silent(room: Cloud) -> None:
    assert outcome(room, WAYS[1], 1.0) != "wrong"


@pytest.mark.parametrize("unit", ["mm", "cm", "in", "ft", "km"])
def test_other_units_are_found_or_asked_for(room: Cloud, unit: str) -> None:
    assert outcome(room, Z, 1.0 / UNITS[unit]) in ("right, told", "refused")


def strays(room: np.ndarray) -> np.ndarray:
    """One point in a hundred anywhere, up to 300 metres away."""
    rng = np.random.default_rng(0)
    away = rng.normal(size=(len(room) // 100, 3))
    away *= 300.0 * rng.random((len(away), 1)) / np.linalg.norm(away, axis=1, keepdims=True)
    return room.mean(axis=0) + away


def street(room: np.ndarray) -> np.ndarray:
    """The ground and a house 30 metres away, as a laser sees them through a window."""
    rng = np.random.default_rng(0)
    a, b = rng.random((2, len(room) // 25))
    ground = np.column_stack([20.0 * a - 8.0, 8.0 + 20.0 * b**2, np.full(len(a), -0.5)])
    return np.concatenate(
        [ground, np.column_stack([60.0 * a - 28.0, np.full(len(a), 30.0), 12 * b])]
    )


def target(room: np.ndarray) -> np.ndarray:
    """Half of all points on a ball of 14 centimetres."""
    around = np.random.default_rng(0).normal(size=room.shape)
    return 0.07 * around / np.linalg.norm(around, axis=1, keepdims=True) + (3.0, 2.0, 1.2)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("unit", ["m", "mm", "cm", "ft"])
@pytest.mark.parametrize("outside", [strays, street, target])
def test_what_lies_outside_changes_nothing(room: Cloud, outside: Callable, unit: str) -> None:
    seen = np.concatenate([room.points, outside(room.points)])
    assert outcome(Cloud(seen), Z, 1.0 / UNITS[unit]) == ("right" if unit == "m" else "right, told")


def test_the_floor_is_that_of_the_room_and_not_the_street(room: Cloud) -> None:
    seen = Cloud(np.concatenate([room.points, street(room.points)]))
    assert without_rooms(seen).level.point[2] == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize(
    ("width", "depth", "height"), [(28, 15, 9), (60, 30, 12), (30, 2, 2.6), (80, 60, 15)]
)
def test_metres_are_believed_of_what_may_be_so_large(
    width: float, depth: float, height: float
) -> None:
    corners = ((0, 0), (width, 0), (width, depth), (0, depth))
    hall = RoomScan(corners, height=height, spacing=np.sqrt(width * depth) / 130).cloud()
    found = stands(Cloud(hall.points))
    assert found.unit == 1.0
    assert (found.up == Z).all()


def test_a_unit_that_was_said_is_believed_of_what_is_no_usual_room() -> None:
    top = np.random.default_rng(0).random((6000, 3)) * (1200.0, 800.0, 2.0)
    assert stands(Cloud(top), unit="mm").unit == 0.001
    assert stands(Cloud(0.001 * top)).unit == 1.0


@pytest.mark.parametrize("scale", [0.01, 0.3048])
def test_a_unit_that_nobody_has_is_asked_for_in_metres(room: Cloud, scale: float) -> None:
    with pytest.raises(InputError, match="no usual unit") as caught:
        stands(turned(room, Z, scale))
    assert float(caught.value.remedy.split("--unit ")[1].split("`")[0]) * scale == pytest.approx(
        1.0, rel=0.1
    )


def test_metres_that_are_called_millimetres_are_a_room_of_four_millimetres(room: Cloud) -> None:
    with pytest.raises(InputError, match=r"would be .* mm wide and 2\.5 mm high") as caught:
        stands(room, unit="mm")
    assert "--unit m`" in caught.value.remedy


@pytest.mark.parametrize("up", ["0,1,0", "1,0,0", "0,0,-1", "0,-1,0", "0,0.7,0.7"])
def test_a_wrong_up_is_told(room: Cloud, up: str) -> None:
    try:
        found = stands(room, up=up)
    except InputError as error:
        assert "--up 0,0,1" in error.remedy
    else:
        assert "--up 0,0,1" in " ".join(found.notes)


def test_labels_tell_the_floor(room: Cloud) -> None:
    bare = RoomScan(((0, 0), (2.5, 0), (2.5, 2.5), (0, 2.5)), spacing=0.04).cloud()
    for way in WAYS:
        np.testing.assert_array_equal(stands(turned(bare, way)).up, way)


def test_a_cube_is_never_silent() -> None:
    bare = Cloud(RoomScan(((0, 0), (2.5, 0), (2.5, 2.5), (0, 2.5)), spacing=0.04).cloud().points)
    assert all(outcome(bare, way, 1.0) != "wrong" for way in WAYS[1:])


CAPTURES = {
    "real_dev/data/arkit_lounge/textured.obj": (0, 1, 0),
    "real_dev/data/laser_offset/scan.ply": (0, 0, 1),
    "real_dev/data/scannet_0002_00/scan.ply": (0, 0, 1),
    "real_dev/data/scannet_0000_00/scene0000_00_vh_clean_2.ply": (0, 0, 1),
    "pcl_room_scan/room_scan1.pcd": (0, 0, 1),
}


@pytest.mark.one_in(2, rest="long")
@pytest.mark.slow
@pytest.mark.parametrize("name", CAPTURES)
def test_a_real_scan_on_every_side_and_in_every_unit(real: Real, name: str) -> None:
    read = read_capture("scan", real(name))
    up = np.linalg.inv(read.source_from_world)[:3, :3] @ CAPTURES[name]
    assert up @ Z > 0.99
    scan = Cloud(read.cloud.points - np.median(read.cloud.points, axis=0))
    for way in WAYS[1:]:
        assert outcome(scan, way, 1.0) != "wrong"
    for scale in SCALES:
        assert outcome(scan, Z, scale) != "wrong"


@pytest.mark.slow
def test_a_capture_that_lies_on_its_side(real: Real) -> None:
    lounge = read_capture("scan", real("real_dev/data/arkit_lounge/textured.obj"))
    assert lounge.settled == {"up": "0,1,0"}
    assert any("0,1,0 is taken for up" in note for note in lounge.notes)
    fragment = real("real_dev/data/rgbd_fragment/cloud_bin_2.ply")
    with pytest.raises(InputError, match="up direction is not clear") as caught:
        read_capture("scan", fragment)
    assert "--up" in caught.value.remedy
    assert "partial: true" in caught.value.remedy
    assert read_capture("scan", fragment, {"up": "0,-1,0"}).settled == {}
