"""Shadows from depth alone, against the geometry of a plate before a wall."""

from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.rendering.datasets import DatasetOptions
from openrooms_usd.rendering.reading import RenderedScene
from orusd_openrooms import OpenRoomsDataset
from orusd_openrooms.lightfiles import depth_shadow
from orusd_openrooms.lights import Light

ROWS, COLUMNS = 48, 64
K = np.array([[70.0, 0.0, 32.0], [0.0, 70.0, 24.0], [0.0, 0.0, 1.0]])
WALL, PLATE = 3.0, 2.0
SHOWN = np.zeros((ROWS, COLUMNS), bool)


def window(center: tuple[float, float, float], side: float) -> Light:
    """A square that lies like the picture."""
    size = np.array([side, side, 0.0])
    return Light(0, True, True, np.array(center), np.eye(3), size, np.ones(3), {})


def lamp(center: tuple[float, float, float], side: float) -> Light:
    return Light(1, False, True, np.array(center), np.eye(3), np.full(3, side), np.ones(3), {})


def points(depth: np.ndarray) -> np.ndarray:
    """Right, up, backward of the middles of pixels."""
    columns, rows = np.meshgrid(np.arange(COLUMNS) + 0.5, np.arange(ROWS) + 0.5)
    rays = np.stack([columns, rows, np.ones_like(rows)], axis=-1) @ np.linalg.inv(K).T
    return rays * depth[..., None] * [1.0, -1.0, -1.0]


def before_a_wall() -> tuple[np.ndarray, np.ndarray]:
    """A plate that hides the middle of a wall, and where it is."""
    plate = np.zeros((ROWS, COLUMNS), bool)
    plate[16:32, 20:36] = True
    return np.where(plate, PLATE, WALL), plate


def eroded(area: np.ndarray, by: int = 2) -> np.ndarray:
    """Without what is nearer than so many pixels to other areas, or to the picture's edge."""
    kept = np.zeros_like(area)
    inner = [
        area[by + y : ROWS - by + y, by + x : COLUMNS - by + x]
        for y in range(-by, by + 1)
        for x in range(-by, by + 1)
    ]
    kept[by:-by, by:-by] = np.logical_and.reduce(inner)
    return kept


@pytest.mark.parametrize("light", [window((1.5, 0.4, -0.5), 0.002), lamp((1.5, 0.4, -0.5), 0.002)])
def test_a_small_light_throws_the_shadow_of_what_is_before_the_wall(light: Light) -> None:
    depth, plate = before_a_wall()
    share = depth_shadow(light, np.eye(4), points(depth), K, SHOWN)
    places = points(depth)
    # Where the way from the wall to the light passes the plane of the plate.
    way = light.center - places
    with np.errstate(divide="ignore", invalid="ignore"):
        at = places + way * ((-PLATE - places[..., 2]) / way[..., 2])[..., None]
        pixel = (at * [1.0, -1.0, -1.0]) @ K.T
        column, row = pixel[..., 0] / PLATE, pixel[..., 1] / PLATE
    barred = ~plate & (column > 20) & (column < 36) & (row > 16) & (row < 32)
    # Within a pixel of the plate's edge, and on the seam behind it, nothing is said.
    wall, shadow = eroded(~plate & ~barred), eroded(barred & ~plate)
    assert shadow.sum() > 50 and wall.sum() > 500
    np.testing.assert_allclose(share[shadow], 0.0, atol=1e-9)
    np.testing.assert_allclose(share[wall], 1.0, atol=1e-9)
    np.testing.assert_allclose(share[eroded(plate)], 1.0, atol=1e-9)


def test_half_of_a_wide_light_is_half() -> None:
    """Beside the edge of a plate that hides half of a window, by symmetry."""
    depth = np.full((ROWS, COLUMNS), WALL)
    depth[:, :32] = PLATE
    light = window((0.0, 0.0, 1.0), 2.0)
    share = depth_shadow(light, np.eye(4), points(depth), K, SHOWN)
    places = points(depth)
    for column in (34, 38, 44, 52):
        x = float(places[24, column, 0])
        # The plane of the plate is a quarter of the way to the window; its edge is at x = -1/70.
        edge = (-1.0 / 70.0 - 0.75 * x) * 4.0
        wanted = np.clip((1.0 - edge) / 2.0, 0.0, 1.0)
        assert share[8:40, column].mean() == pytest.approx(wanted, abs=0.03)


def test_what_lies_behind_a_surface_is_dark_and_what_is_not_joined_is_unknown() -> None:
    depth, _ = before_a_wall()
    behind = window((0.0, 0.0, -5.0), 1.0)
    share = depth_shadow(behind, np.eye(4), points(depth), K, SHOWN)
    assert share.max() == 0.0
    # The seam between plate and wall, the picture's edges, and what has no surface.
    assert (share[16:32, 19] < 0.0).any() and (share[0] < 0.0).all()
    depth[:, 50:] = 0.0
    share = depth_shadow(behind, np.eye(4), points(depth), K, SHOWN)
    assert (share[:, 52:] == -1.0).all()


def test_a_window_that_is_seen_casts_no_shadow_and_is_known() -> None:
    depth, plate = before_a_wall()
    light = window((1.5, 0.4, -0.5), 0.002)
    share = depth_shadow(light, np.eye(4), points(depth), K, plate)
    free = depth_shadow(light, np.eye(4), points(np.where(plate, 0.0, WALL)), K, SHOWN)
    np.testing.assert_array_equal(share[~plate], free[~plate])
    np.testing.assert_array_equal(share[plate], np.minimum(free[plate] + 1.0, 1.0))


def test_its_files_are_as_the_loader_takes_them(render: RenderedScene, tmp_path: Path) -> None:
    OpenRoomsDataset().write([render], tmp_path / "a", DatasetOptions(layout="merged"))
    OpenRoomsDataset().write([render], tmp_path / "b", DatasetOptions())
    for number in (0, 1):
        name = f"light_1/depthShadow{number}.npy"
        merged = tmp_path / "a/main_xml/scene0000_00" / name
        share = np.load(merged).squeeze()
        assert share.shape == (12, 16) and share.dtype == np.float32
        assert share.min() >= -1.0 and share.max() <= 1.0
        split = tmp_path / "b/LightSource/main_xml/scene0000_00" / name
        assert split.read_bytes() == merged.read_bytes()
