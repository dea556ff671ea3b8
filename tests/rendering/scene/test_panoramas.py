"""Panoramas: every direction where it belongs, the depth of each the distance."""

from collections.abc import Callable

import numpy as np
import pytest
from pxr import Usd

from openrooms_usd.geometry.pinhole import intrinsics, look_at, panorama_intrinsics
from openrooms_usd.rendering import RenderRequest
from openrooms_usd.rendering.context import RenderContext as OpenedStage
from openrooms_usd.usd.cameras import EQUIRECTANGULAR, PinholeCamera
from tests import small

WIDTH, HEIGHT = 48, 24
POSE = look_at((0.3, -0.2, 0.1), (1.3, -0.2, 0.1))
CAMERA = PinholeCamera(panorama_intrinsics(WIDTH, HEIGHT), POSE, projection=EQUIRECTANGULAR)
EXACT = ("depth", "distance", "position", "normal", "instance", "valid")


def test_directions_are_those_of_a_map() -> None:
    found = CAMERA.directions(WIDTH, HEIGHT)
    np.testing.assert_allclose(np.linalg.norm(found, axis=-1), 1.0)
    # Written again as longitude and latitude, from the left edge and from the top.
    longitude = np.arctan2(found[..., 0], found[..., 2])
    latitude = -np.arcsin(found[..., 1])
    wanted = (np.arange(WIDTH) + 0.5) / WIDTH * 2 * np.pi - np.pi
    np.testing.assert_allclose(longitude, np.broadcast_to(wanted, found.shape[:2]), atol=1e-12)
    wanted = np.pi / 2 - (np.arange(HEIGHT) + 0.5) / HEIGHT * np.pi
    np.testing.assert_allclose(latitude, np.broadcast_to(wanted[:, None], found.shape[:2]))
    # Each pixel stands for so much of the sphere: all of it together.
    solid = np.cos(latitude) * (2 * np.pi / WIDTH) * (np.pi / HEIGHT)
    assert solid.sum() == pytest.approx(4 * np.pi, rel=1e-3)


@pytest.fixture
def inside(open_stage: Callable[[Usd.Stage], OpenedStage]) -> OpenedStage:
    """A closed box of 4 m about the origin."""
    made = small.Stage()
    made.box("/Room", 4.0, inside=True)
    return open_stage(made.stage)


def test_depth_is_the_distance_to_the_walls_all_round(inside: OpenedStage) -> None:
    request = RenderRequest("/Camera", EXACT, WIDTH, HEIGHT, samples=1)
    view = inside.picture(CAMERA, request)
    assert view.projection == EQUIRECTANGULAR
    pixels = {name: image.pixels.astype(np.float64) for name, image in view.images.items()}
    assert pixels["valid"].all()
    rays = CAMERA.directions(WIDTH, HEIGHT) @ POSE[:3, :3].T
    eye = POSE[:3, 3]
    # Slabs: the first of the planes x, y, z = +-2 that a ray leaves by.
    leaves = np.where(rays > 0, 2.0 - eye, -2.0 - eye) / np.where(rays == 0, 1e-30, rays)
    wanted = leaves.min(axis=-1)
    np.testing.assert_allclose(pixels["distance"][..., 0], wanted, rtol=1e-6)
    np.testing.assert_array_equal(pixels["depth"], pixels["distance"])
    np.testing.assert_allclose(pixels["position"], eye + wanted[..., None] * rays, atol=1e-5)
    axis = leaves.argmin(axis=-1)
    towards, along = (
        np.take_along_axis(vectors, axis[..., None], axis=-1)
        for vectors in (pixels["normal"], rays)
    )
    np.testing.assert_allclose(towards, -np.sign(along))


def test_a_pinhole_sees_what_the_panorama_has_there(inside: OpenedStage) -> None:
    K = intrinsics(60.0, 9, 9)
    request = RenderRequest("/Camera", ("position",), 9, 9, samples=1)
    seen = inside.picture(PinholeCamera(K, POSE), request).images["position"].pixels
    fine = PinholeCamera(panorama_intrinsics(720, 360), POSE, projection=EQUIRECTANGULAR)
    asked = RenderRequest("/Camera", ("position",), 720, 360, samples=1)
    found = inside.picture(fine, asked).images["position"].pixels
    x, y, z = np.moveaxis((seen - POSE[:3, 3]) @ POSE[:3, :3], -1, 0)
    column = (np.arctan2(x, z) / (2 * np.pi) + 0.5) * 720
    row = (np.arctan2(y, np.hypot(x, z)) / np.pi + 0.5) * 360
    np.testing.assert_allclose(found[row.astype(int), column.astype(int)], seen, atol=0.03)
