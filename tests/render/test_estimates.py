"""How far pictures are from the truth."""

import numpy as np
import pytest

from openrooms_usd.render.estimates import relative_mse, robust_error


def test_errors_against_a_reference_are_those_of_the_conventions():
    """Two pixels of one component, reference 1 and 3: M = 2, so scales are 1.04 and 9.04."""
    reference = np.array([[[1.0], [3.0]]])
    picture = np.array([[[1.5], [11.0]]])
    near, far = 0.25 / 1.04, 64.0 / 9.04
    assert relative_mse(picture, reference) == pytest.approx((near + far) / 2)
    assert robust_error(picture, reference) == pytest.approx((near + 1.0) / 2)


def test_a_pixel_costs_the_robust_error_its_share_at_most():
    reference = np.ones((10, 10, 3))
    spiked = reference.copy()
    spiked[0, 0] = 1e9
    assert robust_error(spiked, reference) == pytest.approx(0.01)
    assert relative_mse(spiked, reference) > 1e15


def test_errors_do_not_depend_on_the_unit_and_a_dark_component_has_none():
    rng = np.random.default_rng(0)
    reference, picture = rng.random((2, 6, 8, 3))
    reference[..., 2] = 0.0
    for figure in (relative_mse, robust_error):
        assert figure(1000.0 * picture, 1000.0 * reference) == pytest.approx(
            figure(picture, reference)
        )
        lit = figure(picture[..., :2], reference[..., :2])
        assert figure(picture, reference) == pytest.approx(lit * 2 / 3)
        assert figure(reference, reference) == 0.0
