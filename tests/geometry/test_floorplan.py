"""Floor polygons against shapely."""

import numpy as np
import pytest
import shapely

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.floorplan import inside, room_centre, wall_distance

L_SHAPE = np.array([[0.0, 0], [6, 0], [6, 1.5], [1.5, 1.5], [1.5, 6], [0, 6]])


SLANTED = np.array([[0.0, 1], [3, 0], [6, 2], [4, 3], [5, 6], [2, 4], [1, 5]])


@pytest.mark.parametrize("corners", [L_SHAPE, L_SHAPE[::-1], SLANTED])
@pytest.mark.parametrize("offset", [0.0, 1.0e5])
def test_inside_and_distance_agree_with_shapely(corners: Array, offset: float) -> None:
    polygon = corners + offset
    points = np.random.default_rng(0).uniform(-1, 7, (500, 2)) + offset
    shape = shapely.Polygon(polygon)
    expected = shapely.contains_xy(shape, points[:, 0], points[:, 1])
    np.testing.assert_array_equal(inside(polygon, points), expected)
    distances = shapely.distance(shape.exterior, shapely.points(points))
    np.testing.assert_allclose(wall_distance(polygon, points), distances, atol=1e-9)


def test_the_centre_of_a_convex_room_is_its_centroid() -> None:
    polygon = np.array([[0.0, 0], [4, 0], [5, 2], [3, 4], [0, 3]]) + 1.0e6
    centroid = shapely.Polygon(polygon - 1.0e6).centroid
    np.testing.assert_allclose(room_centre(polygon) - 1.0e6, [centroid.x, centroid.y], atol=1e-6)
    np.testing.assert_allclose(room_centre(polygon[::-1]), room_centre(polygon))


def test_the_centre_of_a_bent_room_is_in_it() -> None:
    shape = shapely.Polygon(L_SHAPE)
    assert not shape.contains(shape.centroid)
    centre = room_centre(L_SHAPE)
    assert shape.exterior.distance(shapely.Point(centre)) > 0.6
    assert shape.contains(shapely.Point(centre))
