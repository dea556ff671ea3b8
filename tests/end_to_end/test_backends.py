"""Everything but noise is the same on every backend."""

from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.channels import WRITTEN


@pytest.mark.slow
@pytest.mark.usefixtures("vectorized")
def test_ground_truth_is_the_same_and_radiance_alike(composed_demo: Path, show, fastest) -> None:
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
        # The pictures' means, of noise that 16 samples leave at 3 % or less. The scalar backend has
        # Mitsuba's principled BSDF, whose diffuse lobe gives back a fifth more in white rooms.
        bright = [float(image["radiance"].mean()) for image in (ours, theirs)]
        assert 0.75 * bright[1] < bright[0] < 1.05 * bright[1]
