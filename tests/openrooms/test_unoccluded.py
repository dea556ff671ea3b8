"""The light of an opening's lobes without occlusion, against closed forms and brute force."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.rendering.datasets import DatasetOptions
from openrooms_usd.rendering.reading import read_render
from orusd_openrooms import OpenRoomsDataset, lightfiles
from orusd_openrooms.lightfiles import approximate
from orusd_openrooms.lights import Light, Lobe, lights_of
from orusd_openrooms.readers import read_light

ONE = np.ones(3)


def window(lobe: Lobe, size: tuple[float, float, float] = (2.0, 1.0, 0.0)) -> Light:
    """Around (0, 3, 0); x is its width, z its height, outwards is +y."""
    center, axes = np.array([0.0, 3.0, 0.0]), np.array([[-1.0, 0, 0], [0, 0, 1], [0, 1, 0]])
    return Light(1, True, True, center, axes, np.array(size), np.zeros(3), {"sky": lobe})


def at(light: Light, point: list[float], normal: list[float], camera: np.ndarray) -> np.ndarray:
    points = np.array([[camera[:3, :3] @ point + camera[:3, 3]]], np.float32)
    normals = np.array([[camera[:3, :3] @ normal]], np.float32)
    return approximate(light, camera, points, normals)[0, 0]


def lambert(light: Light, point: np.ndarray, normal: np.ndarray) -> float:
    """Irradiance by a rectangle of radiance 1, all above the horizon: the contour sum."""
    x, y, _ = 0.5 * light.size
    square = np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]])
    corners = light.center + square @ light.axes.T
    rays = (corners - point) / np.linalg.norm(corners - point, axis=1, keepdims=True)
    total = 0.0
    for a, b in zip(rays, np.roll(rays, -1, axis=0), strict=True):
        turn = np.cross(a, b)
        total += np.arccos(a @ b) * (turn @ normal) / np.linalg.norm(turn)
    return abs(0.5 * total)


def camera(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    matrix = np.eye(4)
    matrix[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    matrix[:3, 3] = rng.normal(size=3)
    return matrix


def test_one_rectangle_for_two_windows_would_move_the_sun() -> None:
    """Why openings are not merged: half a metre of wall between two windows a metre wide."""
    x, y = np.meshgrid(np.linspace(-2.5, 2.5, 100), np.linspace(-1.5, 2.8, 86))
    floor = np.stack([x, y, np.zeros_like(x)], axis=-1).astype(np.float32)
    up = np.broadcast_to(np.array([0.0, 0.0, 1.0], np.float32), floor.shape)

    def falls(center: float, width: float, lobe: Lobe) -> np.ndarray:
        light = window(lobe, (width, 1.2, 0.0))
        return approximate(replace(light, center=[center, 3.0, 1.5]), np.eye(4), floor, up)

    for axis, sharpness, expected in (([0.0, 0.6, 0.8], 2.0, 0.05), ([0.3, 0.8, 0.7], 5e4, 0.39)):
        lobe = Lobe(np.array(axis) / np.linalg.norm(axis), sharpness, ONE)
        two = falls(-0.75, 1.0, lobe) + falls(0.75, 1.0, lobe)
        one = falls(0.0, 2.5, replace(lobe, intensity=ONE * 2.0 / 2.5))
        assert np.abs(one - two).sum() / two.sum() == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize("seed", range(4))
def test_even_light_is_lamberts_sum(seed: int) -> None:
    rng = np.random.default_rng(seed)
    light = window(Lobe(np.array([0.0, 1.0, 0.0]), 0.0, np.array([1.0, 2.0, 4.0])))
    point = rng.uniform([-1, -1, -0.5], [1, 1, 0.5])
    normal = np.array([0.0, 1.0, 0.0])
    expected = lambert(light, point, normal) * np.array([1.0, 2.0, 4.0])
    np.testing.assert_allclose(at(light, point, normal, camera(seed)), expected, rtol=2e-3)


def test_a_sharp_lobe_shines_where_its_beam_falls() -> None:
    sun = np.array([0.0, 0.8, 0.6])
    light = window(Lobe(sun, 4000.0, ONE))
    flux = 2 * np.pi / 4000.0  # lux at a right angle to the beam
    floor = [0.0, 0.0, 1.0]
    inside = [0.0, 3.0 - 0.8, -0.6]
    np.testing.assert_allclose(at(light, inside, floor, camera(1)), 0.6 * flux * ONE, rtol=2e-3)
    assert (at(light, [0.0, 0.0, -0.6], floor, camera(1)) == 0).all()
    assert (at(light, inside, [0.0, 0.0, -1.0], camera(1)) == 0).all()


def test_both_ways_to_integrate_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    light = window(Lobe(np.array([0.1, 0.98, 0.15]), 1.0, ONE), (3.0, 3.0, 0.0))
    found = []
    for limit in (0.0, 100.0):
        monkeypatch.setattr(lightfiles, "_SHARP_LOBE", limit)
        found.append(at(light, [0.2, 1.0, -0.3], [0.0, 0.6, 0.8], camera(2)))
    np.testing.assert_allclose(found[0], found[1], rtol=0.03)


def test_what_is_off_is_dark() -> None:
    lit = window(Lobe(np.array([0.0, 1.0, 0.0]), 0.0, ONE))
    dark = Light(**{**vars(lit), "on": False})
    assert (at(dark, [0, 0, 0], [0, 1, 0], np.eye(4)) == 0).all()


def test_no_surface_gets_no_light() -> None:
    light = window(Lobe(np.array([0.0, 1.0, 0.0]), 0.0, ONE))
    assert (at(light, [0, 0, 0], [0, 0, 0], np.eye(4)) == 0).all()


def test_the_file_of_a_window_with_an_even_sky(day: Path, tmp_path: Path) -> None:
    """From depth, intrinsics and pose to the file: the floor of the synthetic room."""
    manifest = json.loads((day / "manifest.json").read_text())
    sky = {"name": "sky", "axis": [0, 1, 0], "sharpness": 0.0, "amplitude": [100.0, 200.0, 300.0]}
    for light in manifest["lights"]:
        light["gaussians"] = [sky]
    (day / "manifest.json").write_text(json.dumps(manifest))
    scene = read_render(day)
    OpenRoomsDataset().write([scene], tmp_path / "data", DatasetOptions(layout="merged"))
    found = read_light(tmp_path / "data/main_xml/scene0000_00/light_1/imDSNoOccluApprox1.hdr")
    view, (_, window) = scene.views["view_0"], lights_of(scene)
    floor = view.pixels["instance"][..., 0].reshape(12, 4, 16, 4) == 1
    rows, columns = np.nonzero(floor.all(axis=(1, 3)))
    assert len(rows) > 20
    camera, K = view.world_from_camera, view.K
    for row, column in zip(rows, columns, strict=True):
        ray = camera[:3, :3] @ np.linalg.inv(K) @ [4 * column + 2, 4 * row + 2, 1]
        point = camera[:3, 3] - ray * camera[2, 3] / ray[2]
        expected = lambert(window, point, np.array([0.0, 0.0, 1.0])) * np.array([100, 200, 300])
        np.testing.assert_allclose(found[row, column], expected, rtol=0.04)
