"""The files of a light: boxes by their corners, sources as the loaders join them, shadows."""

import itertools
import json
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.rendering.datasets import DatasetOptions
from openrooms_usd.rendering.reading import RenderedScene, read_render
from orusd_openrooms import OpenRoomsDataset
from orusd_openrooms.lights import (
    Light,
    Lobe,
    box,
    camera_from_world,
    lights_of,
    single_source,
    source,
    spread,
)
from orusd_openrooms.readers import read_bytes, read_light, read_light_box
from tests.openrooms.synthetic import GAUSSIANS, LAMP, RADIANCE, WINDOW, random_pose


@pytest.fixture(scope="module")
def folder(render: RenderedScene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("lights") / "data"
    OpenRoomsDataset().write([render], root, DatasetOptions(layout="merged"))
    return root / "main_xml/scene0000_00"


def corners(center: np.ndarray, axes: np.ndarray, size: np.ndarray) -> np.ndarray:
    """(8, 3), sorted so that boxes can be compared whatever their axes are called."""
    signs = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
    points = center + (signs * size) @ axes.T
    return points[np.lexsort(np.round(points, 6).T)]


def random_light(rng: np.random.Generator) -> Light:
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return Light(0, False, True, rng.normal(size=3), axes, rng.random(3) + 0.1, np.ones(3), {})


@pytest.mark.parametrize("seed", range(30))
def test_a_box_is_the_same_solid_in_the_cameras_frame(seed: int) -> None:
    rng = np.random.default_rng(seed)
    light, world_from_camera = random_light(rng), random_pose(rng)
    found = box(light, camera_from_world(world_from_camera), np.zeros((4, 4), bool))["box3D"]
    axes = np.stack([found[f"{name}Axis"] for name in "xyz"], axis=1)
    size = np.array([found[f"{name}Len"] for name in "xyz"])
    right_up_backward = world_from_camera[:3, :3] * [1.0, -1.0, -1.0]
    world = corners(light.center, light.axes, light.size) - world_from_camera[:3, 3]
    expected = world @ right_up_backward
    expected = expected[np.lexsort(np.round(expected, 6).T)]
    np.testing.assert_allclose(corners(found["center"], axes, size), expected, atol=1e-9)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert found["zAxis"] @ found["center"] <= 0  # towards the camera
    upright = np.array([0.0, 0.0, 1.0]) @ right_up_backward
    assert found["yAxis"] @ upright == pytest.approx(np.abs(light.axes[2]).max())
    assert found["xLen"] >= found["zLen"]


def test_a_window_in_front_of_the_camera(folder: Path, render: RenderedScene) -> None:
    found = read_light_box(folder / f"light_1/box{WINDOW}.dat")
    assert found["isWindow"] is True
    three = found["box3D"]
    assert (three["xLen"], three["yLen"], three["zLen"]) == (1.2, 1.4, 0.0)
    assert three["center"][2] < -3.5 and three["zAxis"][2] > 0.9  # backward is towards the camera
    seen = render.views["view_0"].lights["mask"][WINDOW][..., 0] > 0
    rows, columns = np.nonzero(seen)
    assert found["box2D"] == {
        "x1": columns.min(),
        "x2": columns.max(),
        "y1": rows.min(),
        "y2": rows.max(),
    }
    assert (folder / f"light_1/box{WINDOW}.json").is_file()


def test_what_is_not_seen_has_no_box_in_the_picture() -> None:
    rng = np.random.default_rng(0)
    found = box(random_light(rng), np.eye(4), np.zeros((4, 4), bool))
    assert found["box2D"] == {"x1": None, "x2": None, "y1": None, "y2": None}


def loaded(path: str) -> Any:
    return pickle.loads(Path(path).read_bytes())


def test_the_loaders_join_every_light(folder: Path) -> None:
    """IndoorLightEditing: names from the masks', reshapes, and 22 numbers for a window."""
    names = sorted(map(str, (folder / "light_1").glob("mask*.png")))
    assert [Path(name).name for name in names] == ["mask0.png", "mask1.png"]
    for name in names:
        parameters = loaded(name.replace("mask", "box").replace(".png", ".dat"))
        src = loaded(name.replace("mask", "lightSrc").replace(".png", ".dat"))
        again = loaded(name.replace("mask", "lightSrcNoOcclu").replace(".png", ".dat"))
        assert again.keys() == src.keys()
        three = parameters["box3D"]
        assert three["center"].reshape(3).shape == (3,)
        axes = [(three[f"{a}Axis"] * three[f"{a}Len"]).reshape(3) for a in "xyz"]
        assert np.concatenate([a.reshape(1, 3) for a in axes], axis=0).shape == (3, 3)
        assert np.sum(src["intensity"] * 0.5) > 0
        if parameters["isWindow"]:
            joined = np.concatenate(
                [
                    src["intensity"] * 0.5,
                    src["axis"],
                    np.array(src["lamb"]).reshape(1),
                    src["intensitySky"] * 0.5,
                    src["axisSky"],
                    np.array(src["lambSky"]).reshape(1),
                    src["intensityGrd"] * 0.5,
                    src["axisGrd"],
                    np.array(src["lambGrd"]).reshape(1),
                    np.zeros(1, dtype=np.float32),
                ],
                axis=0,
            )
            assert joined.shape == (22,)
            approximate = name.replace("mask", "imDSNoOccluApprox").replace("png", "hdr")
            true = name.replace("mask", "imDSNoOcclu").replace(".png", ".rgbe")
            off = np.abs(read_light(Path(approximate)) - read_light(Path(true))).mean()
            # The loaders add it up beside their own mean absolute errors of shadings.
            assert src["loss"] / src["scale"] == pytest.approx(off, rel=0.01) and off > 0.0
        for stem in ("imDS", "imDSNoOcclu"):
            light = read_light(Path(name.replace("mask", stem).replace(".png", ".rgbe")))
            assert light.shape == (12, 16, 3)
        assert read_bytes(Path(name.replace("mask", "imShadow"))).shape == (12, 16, 3)
        assert read_bytes(Path(name)).shape == (48, 64, 3)


def test_a_lamp_gives_its_radiance_and_a_window_its_lobes(render: RenderedScene) -> None:
    lamp, window = lights_of(render)
    camera = camera_from_world(render.views["view_0"].world_from_camera)
    np.testing.assert_array_equal(source(lamp, camera)["intensity"], RADIANCE)
    found = source(window, camera)
    for gaussian, ending in zip(GAUSSIANS, ("", "Sky", "Grd"), strict=True):
        np.testing.assert_array_equal(found[f"intensity{ending}"], gaussian.amplitude)
        assert found[f"lamb{ending}"] == gaussian.sharpness
        world = camera[:3, :3].T @ found[f"axis{ending}"]
        np.testing.assert_allclose(world, gaussian.axis, atol=1e-12)


def opening(lobes: dict[str, Lobe]) -> Light:
    return Light(0, True, True, np.zeros(3), np.eye(3), np.ones(3), np.zeros(3), lobes)


def test_without_a_sun_another_lobe_comes_first() -> None:
    """The loaders take a window for off where the first lobe has no intensity."""
    sky = Lobe(np.array([0.0, 0.0, 1.0]), 2.0, np.array([5.0, 6.0, 7.0]))
    ground = Lobe(np.array([0.0, 0.0, -1.0]), 1.0, np.ones(3))
    found = source(opening({"sky": sky, "ground": ground}), np.eye(4))
    np.testing.assert_array_equal(found["intensity"], sky.intensity)
    assert not found["intensitySky"].any() and found["intensityGrd"].all()


def test_an_opening_without_a_fit_is_even(day: Path, tmp_path: Path) -> None:
    manifest = json.loads((day / "manifest.json").read_text())
    for light in manifest["lights"]:
        light["gaussians"] = []
    (day / "manifest.json").write_text(json.dumps(manifest))
    window = lights_of(read_render(day))[1]
    for made in (source, single_source):
        found = made(window, np.eye(4))
        np.testing.assert_allclose(found["intensity"], [500.0, 600.0, 700.0])
        assert found["lamb"] == 0.0


def test_what_is_off_has_no_intensity(render: RenderedScene) -> None:
    for light in lights_of(render):
        dark = Light(**{**vars(light), "on": False})
        for made in (source, single_source):
            found = made(dark, np.eye(4))
            assert all(not np.any(v) for name, v in found.items() if name.startswith("intensity"))


@pytest.mark.parametrize("sharpness", [0.0, 1e-7, 0.3, 5.0, 800.0])
def test_the_spread_of_a_lobe_is_its_integral(sharpness: float) -> None:
    edges = np.concatenate([[0.0], np.geomspace(1e-6, 2.0, 20_000)])
    middle, width = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges)
    integral = 2 * np.pi * (np.exp(-sharpness * middle) * width).sum()
    assert spread(sharpness) == pytest.approx(integral, rel=1e-4)


def test_one_lobe_keeps_the_flux_and_the_mean_direction() -> None:
    axis = np.array([0.6, 0.0, 0.8])
    lobe = Lobe(axis, 40.0, np.array([3.0, 2.0, 1.0]))
    found = single_source(opening({"sun": lobe}), np.eye(4))
    np.testing.assert_allclose(found["axis"], axis, atol=1e-9)
    np.testing.assert_allclose(
        found["intensity"] * spread(found["lamb"][0]), lobe.intensity * spread(40.0), rtol=1e-9
    )
    assert found["lamb"][0] == pytest.approx(40.0, rel=0.05)


def outside(lobe: Lobe, count: int = 400) -> np.ndarray:
    """(3,) what a lobe sends from z > 0, by plain integration over heights and turns."""
    heights = (np.arange(count) + 0.5) / count
    turns = 2.0 * np.pi * (np.arange(2 * count) + 0.5) / (2 * count)
    flat = np.sqrt(1.0 - heights**2)[:, None]
    cosine = lobe.axis[2] * heights[:, None] + flat * (
        lobe.axis[0] * np.cos(turns) + lobe.axis[1] * np.sin(turns)
    )
    solid = 2.0 * np.pi / (2 * count * count)
    return lobe.intensity * np.exp(lobe.sharpness * (cosine - 1.0)).sum() * solid


def test_what_a_fit_has_inside_of_the_room_counts_for_nothing() -> None:
    """Fits use the tails of lobes that point into the room, where nothing is looked at."""
    sky = Lobe(np.array([0.0, 0.8, 0.6]), 2.0, np.array([90.0, 110.0, 150.0]))
    inner = Lobe(np.array([0.6, 0.0, -0.8]), 8.0, np.array([3e4, 7e4, 2e4]))
    light = opening({"sky": sky, "ground": inner})
    found = single_source(light, np.eye(4))
    joined = Lobe(found["axis"], float(found["lamb"][0]), found["intensity"])
    np.testing.assert_allclose(outside(joined), outside(sky) + outside(inner), rtol=5e-3)
    assert joined.axis[2] > 0.0
    # A lamp of that flux would outshine the sky, of which little is left outside.
    assert outside(inner).sum() < 0.05 * (inner.intensity * spread(8.0)).sum()
    first = source(opening({"sky": sky, "ground": replace(inner, sharpness=90.0)}), np.eye(4))
    np.testing.assert_array_equal(first["intensity"], sky.intensity)


@pytest.mark.parametrize("number", [LAMP, WINDOW])
def test_shadows_times_free_light_is_the_light(
    folder: Path, number: int, render: RenderedScene
) -> None:
    lights = render.views["view_0"].lights
    weights = np.array([0.2126, 0.7152, 0.0722])
    shadow = read_bytes(folder / f"light_1/imShadow{number}.png")[..., 0] / 255.0
    free = read_light(folder / f"light_1/imDSNoOcclu{number}.rgbe")
    light = read_light(folder / f"light_1/imDS{number}.rgbe")
    np.testing.assert_allclose(shadow * (free @ weights), light @ weights, rtol=0.02)
    blocks = lights["direct"][number].reshape(12, 4, 16, 4, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(light, blocks, rtol=0.05)
