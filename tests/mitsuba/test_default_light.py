"""A stage without lights stands in a light whose irradiance is known in closed form."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Sdf, UsdGeom, UsdLux

from openrooms_usd import names
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.exporters import convert_stage
from openrooms_usd.rendering import render_stage
from openrooms_usd.rendering.scene.translate import BRIGHTEST_FROM, EXPOSURE, TOLD, translate
from openrooms_usd.usd.light.lights import define_mesh_light
from tests import small
from tests.mitsuba.rendering import radiance, session_of
from tests.small import square

NORMALS = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1), (1, 2, 3)]


def facing(normal: Any, **options: Any) -> Any:
    """A small white Lambertian square that faces somewhere, and a camera that faces it."""
    made = small.Stage(**options)
    n = np.array(normal) / np.linalg.norm(normal)
    u = np.cross(n, (0.0, 0.0, 1.0) if abs(n[2]) < 0.9 else (1.0, 0.0, 0.0))
    u /= np.linalg.norm(u)
    v = np.cross(n, u)
    material = made.material("/White", base_color=(1.0, 1.0, 1.0))
    made.quad("/Square", [-u - v, u - v, u + v, -u + v], material=material)
    made.camera(3.0 * n, (0, 0, 0), up=u, fov=10.0)
    return made


@pytest.mark.parametrize("normal", NORMALS)
def test_irradiance_is_that_of_its_closed_form(open_stage: Any, normal: Any) -> None:
    made = facing(normal)
    found = radiance(open_stage(made.stage), width=8, height=8, samples=256, bounces=1).mean(
        axis=(0, 1)
    )
    c = float(np.array(normal) / np.linalg.norm(normal) @ BRIGHTEST_FROM)
    # Of 1/4 + 9/16 (1 + c)^2 by spherical harmonics: A0 = pi, A1 = 2 pi / 3, A2 = pi / 4.
    expected = 1.0 + 0.75 * c + (0.75 / 16.0) * (3.0 * c * c - 1.0)
    assert found == pytest.approx([expected] * 3, rel=0.02)


def test_it_comes_from_above_whatever_axis_is_up() -> None:
    """What stands in a stage that is Y up is lit as the same that is Z up."""
    seen = []
    for up in "YZ":
        made = small.Stage(up=up)
        made.box("/Box", 1.0, material=made.material("/White", base_color=(1.0, 1.0, 1.0)))
        opened = session_of(made.stage)
        seen.append(radiance(opened, camera=None, width=16, height=12, samples=256))
    assert np.abs(seen[0] - seen[1]).mean() < 0.02 * seen[0].mean()


def test_it_is_told_and_can_be_left_away() -> None:
    made = facing((0, 0, 1))
    assert ("/", "approximated", TOLD) in session_of(made.stage).report.rows
    dark = session_of(made.stage, default_light=False)
    assert not radiance(dark, width=4, height=4, samples=4).any()
    assert TOLD not in {reason for _, _, reason in dark.report.rows}


def test_who_says_how_a_stage_is_lit_is_heeded() -> None:
    """A light that is off, invisible or inactive, or no kind that is read; our own empty lights."""

    def scene(change: Any) -> Any:
        made = facing((0, 0, 1))
        change(made)
        return translate(made.stage, default_light=True)

    def invisible(made: Any) -> None:
        light = made.light("Sphere", "/Light", 1.0)
        light.CreateVisibilityAttr(UsdGeom.Tokens.invisible)

    def off(made: Any) -> None:
        UsdLux.DistantLight.Define(made.stage, "/Light").CreateIntensityAttr(0.0)

    def ours(made: Any) -> None:
        UsdGeom.Scope.Define(made.stage, names.LIGHTS)

    def inside(made: Any) -> None:
        UsdLux.SphereLight.Define(made.stage, "/_class_Lamp/Light")
        made.stage.GetPrimAtPath("/_class_Lamp").SetSpecifier(Sdf.SpecifierClass)
        lamp = made.stage.DefinePrim("/Lamp")
        lamp.GetReferences().AddInternalReference("/_class_Lamp")
        lamp.SetInstanceable(True)

    for change in (invisible, off, ours, inside):
        found = scene(change)
        assert found.exposure is None, change.__name__
        assert TOLD not in {reason for _, _, reason in found.report.rows}


def test_what_merely_glows_lights_nothing() -> None:
    """A screen of a model is not meant to light a scene; what is brighter than white is."""
    glowing = facing((0, 0, 1))
    glowing.quad(
        "/Screen",
        square((2.5, 0.5, 0), 0.5),
        material=glowing.material("/Glow", emissive=(1.0, 1.0, 1.0)),
    )
    assert translate(glowing.stage, default_light=True).exposure == EXPOSURE
    define_mesh_light(glowing.stage.GetPrimAtPath("/Screen"), nits=5.0)
    assert translate(glowing.stage, default_light=True).environment is None
    bright = facing((0, 0, 1))
    bright.quad(
        "/Panel",
        square((2.5, 0.5, 0), 0.5),
        material=bright.material("/Glow", emissive=(17.0, 12.0, 4.0)),
    )
    assert translate(bright.stage, default_light=True).environment is None


def test_pictures_have_its_exposure_and_files_its_words(tmp_path: Path) -> None:
    made = facing((0, 0, 1), path=tmp_path / "stage.usda")
    made.stage.Save()
    asked = RenderSettings(resolution=(16, 12), samples=4)
    lit = render_stage(tmp_path / "stage.usda", tmp_path / "lit", asked)
    assert any(row["reason"] == TOLD for row in lit.manifest["report"]["losses"])
    view = lit.manifest["views"]["Camera"]
    assert view["exposure"] == EXPOSURE
    dark = render_stage(
        tmp_path / "stage.usda", tmp_path / "dark", asked.replace(default_light=False)
    )
    assert dark.manifest["views"]["Camera"]["channels"]["radiance"]["samples"] == 4
    assert not any(row["reason"] == TOLD for row in dark.manifest["report"]["losses"])


def test_exported_scenes_have_it_too(tmp_path: Path) -> None:
    import mitsuba as mi

    made = facing((0, 0, 1), path=tmp_path / "stage.usda")
    made.stage.Save()
    convert_stage(tmp_path / "stage.usda", tmp_path / "out/scene.xml")
    loaded = mi.load_file(str(tmp_path / "out/scene.xml"))
    assert loaded.environment() is not None
    picture = np.asarray(mi.render(loaded, spp=64))
    middle = picture[picture.shape[0] // 2, picture.shape[1] // 2]
    c = float(BRIGHTEST_FROM[2])
    assert middle == pytest.approx([1 + 0.75 * c + 0.75 / 16 * (3 * c * c - 1)] * 3, rel=0.1)
    assert math.isfinite(picture.sum())
