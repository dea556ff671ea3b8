"""The depth of points: what stands in front hides what is behind; planted errors come out."""

import numpy as np
import pytest

from openrooms_usd.comparison.scandepth import depth_error, scan_depth, spacing

K = np.array([[200.0, 0.0, 80.0], [0.0, 200.0, 60.0], [0.0, 0.0, 1.0]])
SIZE = 160, 120


def plane(depth: float, half: float, slope: float = 0.0) -> np.ndarray:
    """Random points of a square before the camera, one for 4 cm2."""
    count = int((2.0 * half / 0.02) ** 2)
    x, y = np.random.default_rng(5).uniform(-half, half, (2, count))
    return np.column_stack([x, y, depth + slope * x])


def test_a_plane_has_its_depth_everywhere() -> None:
    kept, apart = spacing(plane(2.0, 2.0))
    depth = scan_depth(kept, apart, K, np.eye(4), SIZE)
    assert (depth > 0.0).mean() > 0.95
    np.testing.assert_allclose(depth[depth > 0.0], 2.0, atol=1e-9)


def test_a_tilted_plane_has_its_depth_on_average() -> None:
    kept, apart = spacing(plane(2.5, 2.5, slope=0.5))
    depth = scan_depth(kept, apart, K, np.eye(4), SIZE)
    columns = (np.arange(160) + 0.5 - 80.0) / 200.0
    true = np.tile(2.5 / (1.0 - 0.5 * columns), (120, 1))
    known = depth > 0.0
    assert abs(np.median(depth[known] - true[known])) < 0.01


def test_nothing_shines_through() -> None:
    near, far = plane(1.0, 0.2), plane(3.0, 3.0)
    apart = spacing(near)[1]
    depth = scan_depth(np.concatenate([far, near]), apart, K, np.eye(4), SIZE)
    middle = depth[40:80, 50:110]
    assert (middle[middle > 0.0] < 1.01).all()
    corner = depth[:10, :20]
    np.testing.assert_allclose(corner[corner > 0.0], 3.0, atol=1e-9)
    assert (middle > 0.0).mean() > 0.95
    assert (corner > 0.0).any()


def test_what_is_behind_the_camera_is_not_seen() -> None:
    assert not scan_depth(plane(-2.0, 2.0), 0.02, K, np.eye(4), SIZE).any()


def test_a_camera_elsewhere_sees_it_from_there() -> None:
    moved = np.eye(4)
    moved[2, 3] = -1.0
    depth = scan_depth(plane(2.0, 3.0), 0.02, K, moved, SIZE)
    np.testing.assert_allclose(depth[depth > 0.0], 3.0, atol=1e-9)


def test_a_planted_error_comes_out() -> None:
    scanned = np.full((10, 10), 2.0)
    scanned[0] = 0.0
    rendered = np.full((10, 10), 2.25)
    rendered[5:] = 2.05
    error = depth_error(rendered, scanned)
    assert error is not None
    assert error.right == pytest.approx(50 / 90)
    assert error.median == error.bias == pytest.approx(0.05)
    assert error.seen == pytest.approx(0.9)


def test_without_common_pixels_there_is_no_error() -> None:
    assert depth_error(np.zeros((4, 4)), np.ones((4, 4))) is None
