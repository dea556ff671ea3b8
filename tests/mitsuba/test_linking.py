"""Lamps that light some surfaces and leave others dark."""

import math
from typing import Any

import numpy as np
import pytest
from pxr import Sdf, UsdLux

from openrooms_usd.rendering import RenderRequest
from openrooms_usd.rendering.scene.translate import translate
from tests import small
from tests.mitsuba.rendering import session_of

RADIUS, HEIGHT, NITS = 0.05, 2.0, 1e4
# What falls on a point below one of the lamps.
LUX = NITS * math.pi * RADIUS**2 / (RADIUS**2 + HEIGHT**2)


def stage() -> Any:
    """Two white sheets that share a material, under two lamps in one place."""
    made = small.Stage()
    made.material("/White", base_color=(1.0, 1.0, 1.0))
    for name, low in (("Left", -0.01), ("Right", 0.0)):
        corners = [(low, -0.02, 0), (low + 0.01, -0.02, 0), (low + 0.01, 0.02, 0), (low, 0.02, 0)]
        made.quad(f"/{name}", corners, material="/White")
    made.camera((0, -0.3, 0.3), (0, 0, 0), fov=1.0, aspect=2.0)
    for name in ("One", "Other"):
        made.light(
            "Disk",
            f"/{name}",
            NITS,
            at=(0.0, 0.0, HEIGHT if name == "One" else HEIGHT + 1e-3),
            radius=RADIUS,
        )
    link = UsdLux.LightAPI(made.stage.GetPrimAtPath("/One")).GetLightLinkCollectionAPI()
    link.CreateIncludeRootAttr(False)
    link.IncludePath(Sdf.Path("/Right"))
    # The upper one would be in the shadow of the lower.
    made.stage.GetPrimAtPath("/Other").SetActive(False)
    return made.stage


def halves(picture: np.ndarray) -> list[float]:
    """What the sheets have in their middles."""
    columns = picture[..., 1].mean(axis=0)
    quarter = len(columns) // 4
    return [
        float(columns[quarter - 1 : quarter + 1].mean()),
        float(columns[-quarter - 1 : 1 - quarter].mean()),
    ]


def view(made: Any, *names: str, **how: Any) -> dict[str, np.ndarray]:
    session = session_of(made)
    request = RenderRequest("/Camera", names, 16, 8, samples=16, bounces=3, **how)
    return {name: image.pixels for name, image in session.render(request).images.items()}


def test_paths_leave_out_what_a_lamp_does_not_light(lit: Any) -> None:
    seen = view(stage(), "radiance")
    assert halves(np.pi * seen["radiance"]) == pytest.approx([0.0, LUX], rel=0.02, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["reference", "cache"])
def test_all_passes_leave_it_out(lit: Any, method: str) -> None:
    made = stage()
    straight = view(made, "direct_i", "unoccluded_i")
    whole = view(made, "radiance", "irradiance", "direct_i", "unoccluded_i", method=method)
    found = [of[name] for of in (straight, whole) for name in ("direct_0", "unoccluded_0")]
    for picture in (*found, whole["irradiance"], np.pi * whole["radiance"]):
        assert halves(picture) == pytest.approx([0.0, LUX], rel=0.02, abs=1e-9)


def test_surfaces_are_told_apart_by_the_lamps_that_light_them() -> None:
    scene = translate(stage())
    unlit = {patch.unlit_by: len(patch.triangles) for patch in scene.patches if not patch.lamp}
    assert unlit == {("/One",): 2, (): 2}
    assert [*scene.report.losses()] == []


def test_what_knows_no_links_says_so() -> None:
    made = stage()
    session = session_of(made, variant="scalar")
    session.render(RenderRequest("/Camera", ("radiance",), 2, 2, samples=1))
    assert [*session.report.losses()] == [("/One", "approximated", "it lights everything equally")]


@pytest.mark.parametrize(("diffuse", "specular"), [(0.25, 1.0), (1.0, 0.25)])
def test_multipliers_count_on_matte_surfaces_and_on_metals(
    lit: Any, diffuse: float, specular: float
) -> None:
    made = stage()
    link = UsdLux.LightAPI(made.GetPrimAtPath("/One"))
    link.GetLightLinkCollectionAPI().GetIncludeRootAttr().Set(True)
    metal = small.Stage.of(made)
    metal.material("/Metal", base_color=(0.5, 0.5, 0.5), metallic=1.0, roughness=1.0)
    metal.bind(made.GetPrimAtPath("/Right"), "/Metal")
    plain = halves(view(made, "radiance")["radiance"])
    link.CreateDiffuseAttr(diffuse)
    link.CreateSpecularAttr(specular)
    found = halves(view(made, "radiance")["radiance"])
    assert found == pytest.approx([plain[0] * diffuse, plain[1] * specular], rel=1e-4)
    report = translate(made).report
    assert any("all but metals" in reason for _, _, reason in report.losses())
