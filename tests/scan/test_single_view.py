"""One look into a corner of a room: what it shows is kept, and the room reaches to the camera."""

import numpy as np
import pytest
import shapely

from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.reconstruction import find_rooms
from openrooms_usd.scan.rooms.layout import LayoutOptions
from openrooms_usd.scan.rooms.occupancy import free_along_rays

# The corner is the origin; the camera stands five metres before one wall and looks at it.
SENSOR_ORIGIN = np.array([3.0, 5.0, 1.4])


def view() -> Cloud:
    """What a camera with 60 degrees sees of a floor and two walls, looking along -Y."""
    random = np.random.default_rng(3)
    a, b = random.random((2, 60_000))
    nothing = np.zeros_like(a)
    points = np.concatenate(
        [
            np.stack([6 * a, 5 * b, nothing], axis=1),
            np.stack([6 * a, nothing, 2.6 * b], axis=1),
            np.stack([nothing, 5 * a, 2.6 * b], axis=1),
        ]
    )
    right, forward, up = (
        (points - SENSOR_ORIGIN)[:, 0],
        -(points - SENSOR_ORIGIN)[:, 1],
        (points - SENSOR_ORIGIN)[:, 2],
    )
    half = np.tan(np.radians(30.0))
    seen = (np.abs(right) < half * forward) & (np.abs(up) < 0.75 * half * forward)
    return Cloud(
        points[seen] + random.normal(0, 0.004, (seen.sum(), 3)), sensor_origins=SENSOR_ORIGIN[None]
    )


@pytest.mark.slow
def test_the_room_reaches_to_the_camera() -> None:
    found = find_rooms(view(), LayoutOptions(partial=True))
    (room,) = found.rooms
    corners = room.moved(found.level.scan_from_level).corners
    plan = shapely.Polygon(corners[:, :2])
    assert plan.contains(shapely.Point(SENSOR_ORIGIN[:2]))
    # The wall that was seen is where it is, and is not guessed; those beside the camera are.
    sides = shapely.LineString([(1.0, 0.0), (5.0, 0.0)])
    assert plan.exterior.buffer(0.03).contains(sides)
    assert 0 < len(room.guessed) < len(corners)


def test_it_is_refused_where_a_whole_room_is_expected() -> None:
    with pytest.raises(InputError, match="too little"):
        find_rooms(view())


def test_what_lies_before_the_camera_is_space() -> None:
    origin = np.array([[0.0, 0.0]])
    seen = free_along_rays(np.array([[2.0, 1.0]]), origin, np.array([-0.5, -0.5]), (60, 40))
    x, y = np.meshgrid(*(0.05 * (np.arange(n) + 0.5) - 0.5 for n in seen.shape), indexing="ij")
    line = shapely.LineString([(0.0, 0.0), (2.0, 1.0)])
    away = shapely.distance(line, shapely.points(x[seen], y[seen]))
    # Pixels that the line passes, from end to end, and no others.
    assert away.max() < 0.05 * np.sqrt(0.5) + 1e-9
    assert shapely.MultiPoint(np.stack([x[seen], y[seen]], axis=1)).buffer(0.05).covers(line)
