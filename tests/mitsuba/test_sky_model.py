"""Our evaluation of the Hosek-Wilkie model against Mitsuba's own, which is another program."""

import math
import sys

import numpy as np
import pytest

from openrooms_usd.library.surroundings.sky import hosek_wilkie
from orusd_mitsuba import variants

# What Mitsuba's plugin multiplies the authors' coefficients by, and what makes them nits.
MITSUBA = 1.0 / 106.7502593994140625
NITS = 683.0


@pytest.mark.parametrize("turbidity", [1.0, 2.3, 6.0, 10.0])
@pytest.mark.parametrize("elevation", [5.0, 33.0, 80.0])
def test_it_is_the_sky_of_mitsuba(turbidity: float, elevation: float) -> None:
    variants.choose("auto")
    import mitsuba as mi

    before = mi.variant()
    mi.set_variant("scalar_rgb")
    try:
        h, a = math.radians(elevation), math.radians(20.0)
        sun = np.array([math.cos(h) * math.cos(a), math.cos(h) * math.sin(a), math.sin(h)])
        albedo = np.array([0.1, 0.3, 0.7])
        sky = mi.load_dict(
            {
                "type": "sunsky",
                "sun_direction": mi.ScalarVector3f(*sun.tolist()),
                "turbidity": turbidity,
                "albedo": {"type": "rgb", "value": albedo.tolist()},
                "sun_scale": 0.0,
            }
        )
        rng = np.random.default_rng(4)
        way = rng.normal(size=(60, 3))
        way[:, 2] = np.abs(way[:, 2]) + 0.01
        way /= np.linalg.norm(way, axis=1, keepdims=True)
        theirs = []
        for direction in way.tolist():
            si = mi.SurfaceInteraction3f()
            si.wi = -mi.ScalarVector3f(*direction)
            theirs.append(np.array(sky.eval(si)))
    finally:
        if before:
            mi.set_variant(before)
    ours = hosek_wilkie(way[None], sun, turbidity, albedo)[0] / NITS * MITSUBA
    np.testing.assert_allclose(ours, np.maximum(theirs, 0.0), rtol=2e-3, atol=1e-5)


def test_composing_a_sky_needs_no_renderer() -> None:
    import subprocess

    script = (
        "import sys; from openrooms_usd.library.surroundings.sky import Air, daylight\n"
        "from openrooms_usd.library.surroundings.sunlight import SunPosition\n"
        "daylight(SunPosition(0, 40, 40, 1), Air(), height=16)\n"
        "assert not {'mitsuba', 'drjit'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
