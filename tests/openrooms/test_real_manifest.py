"""Lights as a real renderer writes them into a manifest: their lobes arrive in the dataset."""

import json
import pickle
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdLux

from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.rendering import render_stage
from openrooms_usd.rendering.datasets import DatasetOptions
from openrooms_usd.rendering.reading import read_render
from openrooms_usd.rendering.scene.lights import LobeName
from openrooms_usd.usd.light.lights import Portal, connect_portals, define_portal
from orusd_openrooms import OpenRoomsDataset
from orusd_openrooms.lights import LOBES, lights_of


@pytest.fixture(scope="module")
def rendered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A wall with a window, a sky of 100 nits behind it, on the backend that every machine has."""
    folder = tmp_path_factory.mktemp("real")
    stage = Usd.Stage.CreateNew(str(folder / "scene.usda"))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.Cube.Define(stage, "/World/Box").AddTranslateOp().Set((0.0, 0.0, -4.0))
    UsdGeom.Camera.Define(stage, "/World/left")
    dome = UsdLux.DomeLight_1.Define(stage, "/World/Sky")
    dome.CreateIntensityAttr(100.0)
    world = np.eye(4)
    world[:3, :3] = np.array([[-1, 0, 0], [0, 0, 1], [0, 1, 0]]).T
    world[:3, 3] = (0.0, 3.0, 0.0)
    portal = define_portal(stage, Portal("/World/Window", world, 1.2, 0.8))
    connect_portals(dome.GetPrim(), [portal.GetPrim()])
    stage.Save()
    render_stage(
        folder / "scene.usda",
        folder / "out",
        RenderSettings(
            channels=["radiance", "instance"],
            options={"variant": "scalar"},
            resolution=(8, 6),
            samples=1,
        ),
    )
    return folder / "out"


def test_lobes_are_those_that_the_renderer_fitted(rendered: Path) -> None:
    written = json.loads((rendered / "manifest.json").read_text())["lights"]
    fits = next(light["gaussians"] for light in written if light["kind"] == "opening")
    (window,) = (light for light in lights_of(read_render(rendered)) if light.is_window)
    assert fits and window.lobes.keys() == {fit["name"] for fit in fits} <= LOBES.keys()
    for fit in fits:
        lobe = window.lobes[fit["name"]]
        np.testing.assert_allclose(lobe.intensity, fit["amplitude"])
        np.testing.assert_allclose(lobe.axis, fit["axis"], atol=1e-9)
        assert lobe.sharpness == fit["sharpness"] > 0.0
    # Together they are the sky.
    assert sum(lobe.intensity for lobe in window.lobes.values()) == pytest.approx(100.0, rel=0.01)


def test_the_files_of_a_window_have_its_lobes(rendered: Path, tmp_path: Path) -> None:
    OpenRoomsDataset().write([read_render(rendered)], tmp_path, DatasetOptions(layout="merged"))
    (path,) = (tmp_path / "main_xml/scene0000_00/light_1").glob("lightSrc[0-9].dat")
    found = pickle.loads(path.read_bytes())
    assert (
        found["lamb"] > 0.0
        and found["intensity"].any()
        and found["intensityGrd"].any() != (found["intensitySky"].any())
    )
    assert found["loss"] == 0.0  # the render has no light without occlusion to compare with


def test_every_lobe_of_a_fit_has_its_place_in_the_files() -> None:
    assert (*LOBES,) == get_args(LobeName)
