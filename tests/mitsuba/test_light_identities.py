"""What the channels of one view say of each other: every sum, part and share, as users get them.

Sums are exact, since all is of one pass. What the pass gives is then compared with passes that
share neither code for what they add up nor random numbers: `PathIntegrator`, `DirectIntegrator`,
and Mitsuba's own integrator on the processor alone.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.hemisphere import irradiance, irradiance_bound, untiled
from tests.mitsuba.rendering import Pictures, of_lights, pictures, session_of
from tests.mitsuba.rooms import LAMPS, WINDOW, furnished
from tests.mitsuba.statistics import assert_alike

SEEDS, OTHERS = range(12), range(100, 112)
RECEIVED = ("irradiance", "irradiance_direct", "irradiance_indirect", "irradiance_i")
STRAIGHT = ("direct_i", "unoccluded_i", "visibility_i")
SENT = ("radiance", "emission", "direct", "indirect", "radiance_i")
WHOLE = (*SENT, "diffuse", "specular", *RECEIVED, *STRAIGHT)
# Where cameras look closely: past the panel's board, the edge of the sun's patch, a wall, the box.
TARGETS = [(-0.3, 0.0, -1.0), (0.1, -0.1, -1.0), (-1.0, 0.1, -0.2), (0.35, 0.1, -0.5)]


@pytest.fixture(scope="module")
def session(vectorized: str) -> Any:
    made = furnished(ior=1.5)
    for number, target in enumerate(TARGETS):
        made.camera((-0.6, -0.9, 0.2), target, path=f"/Near_{number}", fov=0.5)
    return session_of(made.stage, bsdf="openrooms")


@pytest.fixture(scope="module")
def found(session: Any) -> Pictures:
    return pictures(session, WHOLE, SEEDS)


@pytest.fixture(scope="module")
def straight(session: Any) -> Pictures:
    return pictures(session, STRAIGHT, OTHERS)


@pytest.mark.parametrize(
    ("whole", "parts"),
    [
        ("radiance", ("radiance_i",)),
        ("radiance", ("emission", "direct", "indirect")),
        ("radiance", ("emission", "diffuse", "specular")),
        ("irradiance", ("irradiance_i",)),
        ("irradiance", ("irradiance_direct", "irradiance_indirect")),
        ("irradiance_direct", ("direct_i",)),
    ],
)
def test_parts_add_up_exactly(found: Pictures, whole: str, parts: tuple[str, ...]) -> None:
    each = [p for n in parts for p in (of_lights(found, n) if n.endswith("_i") else [found[n]])]
    assert all(part.min() >= 0.0 for part in each)
    np.testing.assert_allclose(np.sum(each, axis=0), found[whole], rtol=2e-5, atol=1e-6)


def test_every_light_and_kind_brings_something_and_nothing_comes_from_elsewhere(
    session: Any, found: Pictures
) -> None:
    assert [light.kind for light in session.lights] == ["lamp", "lamp", "opening", "elsewhere"]
    for channel in ("radiance_i", "irradiance_i", "direct_i"):
        *lights, elsewhere = of_lights(found, channel)
        assert all(light.mean() > 0.1 for light in lights)
        # A ray in some 10^5 slips through where walls meet.
        assert (elsewhere > 0.0).mean() < 1e-3
    assert found["specular"].mean() > 0.01 * found["diffuse"].mean()


@pytest.mark.parametrize("light", range(3))
def test_straight_light_is_that_of_its_own_pass(
    found: Pictures, straight: Pictures, light: int
) -> None:
    for name in ("direct", "unoccluded"):
        assert_alike(found[f"{name}_{light}"], straight[f"{name}_{light}"], name)
    # A ratio, biased by what falls with the samples.
    seen, alone = (passes[f"visibility_{light}"].mean(axis=0) for passes in (found, straight))
    assert np.abs(seen - alone).mean() < 0.02


@pytest.mark.parametrize("of", ["found", "straight"])
def test_visibility_is_a_share_of_what_is_not_hidden(
    request: pytest.FixtureRequest, of: str
) -> None:
    passes = request.getfixturevalue(of)
    parts = zip(*(of_lights(passes, name) for name in STRAIGHT), strict=True)
    for direct, unoccluded, visibility in parts:
        assert visibility.min() >= 0.0 and visibility.max() <= 1.0
        assert (direct <= unoccluded * (1.0 + 1e-6)).all()
        assert not visibility[unoccluded == 0.0].any()
    for hidden in of_lights(passes, "visibility_i")[:3]:
        # Every light is seen by some pixels, hidden from others, and between for some.
        assert ((hidden > 0.1) & (hidden < 0.9)).mean() > 0.01 < (hidden > 0.99).mean()


@pytest.mark.slow
def test_the_picture_is_that_of_paths(session: Any, found: Pictures) -> None:
    """By kind and by light; the edge of the sun's patch asks for many."""
    more = pictures(session, WHOLE, range(12, 24))
    for name, paths in pictures(session, SENT, range(100, 136)).items():
        assert_alike(np.concatenate([found[name], more[name]]), paths, name)


@pytest.fixture(scope="module")
def by_path(vectorized: str) -> Callable[..., Array]:
    """Radiance by Mitsuba's own integrator, on the processor alone, of some of the lights."""

    def rendered(lit_by: tuple[str, ...]) -> Array:
        one = session_of(furnished(lit_by).stage, variant="scalar", bsdf="preview")
        return pictures(one, ("radiance",), OTHERS, samples=32)["radiance"]

    return rendered


@pytest.mark.slow
def test_the_scalar_backend_sees_the_same_picture(by_path: Callable[..., Array]) -> None:
    ours = session_of(furnished().stage, bsdf="preview")
    parts = of_lights(pictures(ours, ("radiance_i",), SEEDS), "radiance_i")
    assert_alike(np.sum(parts, axis=0), by_path((*LAMPS, WINDOW)))
    for light, image in zip(ours.lights, parts, strict=True):
        if light.kind != "elsewhere":
            assert_alike(image, by_path((light.path,)), light.path)


@pytest.mark.slow
def test_of_exactly_lambertian_surfaces_irradiance_tells_the_picture(vectorized: str) -> None:
    """White: pi (direct + indirect) = irradiance, though one follows the materials' BSDFs."""
    looks = {"base_color": (1.0, 1.0, 1.0), "roughness": 1.0, "ior": 1.0}
    made = session_of(furnished(LAMPS, **looks).stage)
    sent = pictures(made, ("direct", "indirect"), SEEDS, bounces=3)
    got = pictures(made, RECEIVED[:3], OTHERS, bounces=3)
    for kind in ("direct", "indirect"):
        assert_alike(np.pi * sent[kind], got[f"irradiance_{kind}"], kind)


@pytest.mark.parametrize(
    ("number", "method"),
    [
        (0, "reference"),
        *(pytest.param(n, "reference", marks=pytest.mark.slow) for n in (1, 2, 3)),
        *(pytest.param(n, "cache", marks=pytest.mark.slow) for n in (0, 1, 2, 3)),
    ],
)
def test_cells_times_cosine_are_irradiance(session: Any, number: int, method: str) -> None:
    """Within what light may be off that is uneven in a cell, which horizon cells dominate."""
    how = {"camera": f"/Near_{number}", "width": 4, "height": 3, "samples": 64, "grid": (4, 3)}
    cells_of = ("environment", "environment_direct")
    grids = pictures(session, cells_of, range(6), method=method, **how)
    pixels = pictures(session, ("irradiance", "irradiance_direct"), range(6), **how)
    for name in ("", "_direct"):
        cells = np.stack([untiled(g) for g in grids[f"environment{name}"].astype(np.float32)])
        ours = irradiance(cells).mean(axis=(1, 2))
        theirs = pixels[f"irradiance{name}"].mean(axis=(1, 2))
        bound = irradiance_bound(cells.mean(axis=0)).mean(axis=(0, 1))
        spread = np.sqrt((ours.var(axis=0, ddof=1) + theirs.var(axis=0, ddof=1)) / 6)
        off = np.abs(ours.mean(axis=0) - theirs.mean(axis=0))
        share = 0.01 if method == "cache" else 0.0
        assert (off <= bound + 4.0 * spread + share * theirs.mean(axis=0)).all(), name
        # They say something: the bound is small beside what is bounded, and so is the noise.
        assert (bound + 4.0 * spread < 0.2 * ours.mean(axis=0)).all()
