"""Everything that the library makes has coordinates in metres, within stated bounds."""

import numpy as np
import pytest

from openrooms_usd.furniture import CATEGORIES, make
from openrooms_usd.geometry.uvquality import uv_quality
from tests.furniture.pieces import piece


@pytest.mark.one_in(3)
@pytest.mark.parametrize("category", CATEGORIES)
def test_texture_coordinates_of_furniture_are_metric_and_hardly_stretched(category: str) -> None:
    spec = CATEGORIES[category]
    for style in spec.styles:
        # In its category's usual size, where the style is for such sizes.
        suits = spec.styles[style].suits(spec.size)
        rng = np.random.default_rng(0)
        made = make(category, spec.size, style, rng) if suits else piece(category, style)
        for name, mesh in made.parts.items():
            quality = uv_quality(mesh)
            assert quality.finite and quality.folded < 1e-6, (style, name)
            assert 0.7 < quality.density < 1.4, (style, name, quality)
            assert quality.stretch < 1.6, (style, name, quality)
