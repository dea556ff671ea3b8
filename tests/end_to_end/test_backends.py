"""Everything but noise is the same on every backend."""

from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.channels import WRITTEN
from tests import small
from tests.mitsuba.rendering import radiance, session_of


@pytest.mark.slow
@pytest.mark.usefixtures("vectorized")
def test_ground_truth_is_the_same(composed_demo: Path, show, fastest) -> None:
    # Of reflectance models, too: scalar ones have that of UsdPreviewSurface unless told otherwise.
    a, b = (
        show(composed_demo, name, options={"variant": name, "bsdf": "preview"}, samples=16)
        for name in (fastest, "scalar")
    )
    assert a.views == b.views
    assert a.manifest["renderer"] != b.manifest["renderer"]
    assert a.manifest["legend"] == b.manifest["legend"]
    for view in a.views:
        ours, theirs = a[view], b[view]
        assert set(ours) == set(WRITTEN)
        # Single precision may decide otherwise where a ray meets an edge.
        same = (ours["part"] == theirs["part"])[..., 0]
        assert same.mean() > 0.998
        for name in set(WRITTEN) - {"radiance"}:
            assert np.abs(ours[name] - theirs[name])[same].max() < 1e-6, (view, name)


@pytest.mark.slow
@pytest.mark.usefixtures("vectorized")
def test_radiance_is_alike(fastest: str) -> None:
    """Of what reflects as Lambert has it: else the scalar backend has Mitsuba's principled BSDF."""
    made = small.room(ior=1.0)
    made.light("Rect", "/Lamp", 200.0, at=(0.0, 0.0, 0.9), width=0.5, height=0.5)
    made.camera((0.8, -0.8, 0.0), (-0.5, 0.5, -0.4), fov=60.0)
    # Of noise that these samples leave at 3 % or less.
    bright = [
        float(radiance(session_of(made.stage, variant=name), samples=256).mean())
        for name in (fastest, "scalar")
    ]
    assert bright[0] == pytest.approx(bright[1], rel=0.1)
