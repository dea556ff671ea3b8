"""What pictures of the surroundings bring, however small they are and however far they range.

Beside light by Mitsuba stands an integral over the hemisphere of the picture as USD has it:
bilinear between the centres of its pixels, clamped at the poles.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import UsdLux

from openrooms_usd.arrays import Array
from tests import small
from tests.mitsuba.rendering import radiance
from tests.pictures import save_picture

# Directions of the integral, from pole to pole and around.
ROWS, COLUMNS = 720, 1440


def seen(pixels: Array, directions: Array) -> Array:
    """(N, 3) a latitude-longitude picture along unit directions, +Y its upper edge."""
    height, width = pixels.shape[:2]
    x, y, z = directions.T
    column = (np.arctan2(x, -z) / (2.0 * np.pi) % 1.0) * width - 0.5
    row = np.arccos(np.clip(y, -1.0, 1.0)) / np.pi * height - 0.5
    left, top = np.floor(column).astype(int), np.floor(row).astype(int)
    across, down = (column - left)[:, None], (row - top)[:, None]

    def at(i: Any, j: Any) -> Array:
        return np.asarray(pixels[np.clip(i, 0, height - 1), j % width])

    upper = at(top, left) * (1 - across) + at(top, left + 1) * across
    lower = at(top + 1, left) * (1 - across) + at(top + 1, left + 1) * across
    return np.asarray(upper * (1 - down) + lower * down)


def irradiance(pixels: Array, normal: Array) -> Array:
    """(3,) lux on a plane."""
    theta = np.pi * (np.arange(ROWS) + 0.5) / ROWS
    phi = 2.0 * np.pi * (np.arange(COLUMNS) + 0.5) / COLUMNS
    t, p = (grid.ravel() for grid in np.meshgrid(theta, phi, indexing="ij"))
    ways = np.stack([np.sin(t) * np.sin(p), np.cos(t), -np.sin(t) * np.cos(p)], axis=1)
    weights = np.sin(t) * np.maximum(ways @ normal, 0.0) * (np.pi / ROWS) * (2 * np.pi / COLUMNS)
    return np.asarray(weights @ seen(pixels, ways))


def pictures() -> dict[str, Array]:
    random = np.random.default_rng(4)
    some: dict[str, Array] = {
        f"{h}x{w}": random.uniform(0.2, 1.0, (h, w, 3)) for h, w in ((1, 1), (1, 2), (2, 2), (4, 8))
    }
    some["seven decades"] = 10.0 ** random.uniform(-3.0, 4.0, (64, 128, 1)) * np.ones(3)
    hot = random.uniform(0.2, 1.0, (16, 32, 3))
    hot[3, 11] = 1e5
    some["a hot pixel"] = hot
    pole = random.uniform(0.2, 1.0, (32, 64, 3))
    pole[0] = 1e3
    some["a hot pole"] = pole
    return some


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", pictures())
def test_they_bring_what_they_hold(open_stage: Any, tmp_path: Path, name: str) -> None:
    pixels = pictures()[name].astype(np.float32)
    made = small.Stage(up="Y")
    dome = UsdLux.DomeLight.Define(made.stage, "/Sky")
    dome.CreateTextureFileAttr(save_picture(tmp_path / "sky.exr", pixels))
    dome.CreateTextureFormatAttr("latlong")
    normal = np.array([2.0, 3.0, 1.0]) / np.sqrt(14.0)
    side = np.cross(normal, (0.0, 1.0, 0.0)) / np.linalg.norm(np.cross(normal, (0.0, 1.0, 0.0)))
    other = np.cross(normal, side)
    square = [a * side + b * other for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    made.quad("/Square", square, material=made.material("/White", base_color=(1.0,) * 3))
    made.camera(3.0 * normal, (0, 0, 0), up=other, fov=10.0)
    found = radiance(open_stage(made.stage), width=16, height=16, samples=256, bounces=1)
    expected = irradiance(pixels.astype(np.float64), normal) / np.pi
    assert found.mean(axis=(0, 1)) == pytest.approx(expected, rel=0.015)
