"""The transfer function against its standard, branch by branch; luminance by its weights."""

import numpy as np
import pytest

from openrooms_usd.colorimetry import linear_from_srgb, luminance, srgb_from_linear


def decoded(code: float) -> float:
    """IEC 61966-2-1 from the display's side: code value to light."""
    return code / 12.92 if code <= 0.04045 else ((code + 0.055) / 1.055) ** 2.4


def test_decoding_is_what_the_standard_says() -> None:
    codes = np.concatenate([np.linspace(-0.1, 1.5, 1601), [0.04045, np.nextafter(0.04045, 1)]])
    assert linear_from_srgb(codes) == pytest.approx([decoded(code) for code in codes], rel=1e-14)


def test_encoding_undoes_decoding_and_clips() -> None:
    x = np.linspace(0, 1, 1001)
    assert [decoded(code) for code in srgb_from_linear(x)] == pytest.approx(x.tolist(), abs=1e-6)
    assert srgb_from_linear(np.array([-1.0, 2.0])).tolist() == [0, pytest.approx(1)]


def test_pictures_stay_as_narrow_as_they_came_and_keep_what_is_no_number() -> None:
    for change in (srgb_from_linear, linear_from_srgb):
        found = change(np.array([0.0, 0.5, np.nan], np.float32))
        assert found.dtype == np.float32 and np.isnan(found).tolist() == [False, False, True]


def test_luminance_of_white_is_one_and_is_found_in_double_precision() -> None:
    assert luminance((1.0, 1.0, 1.0)) == pytest.approx(1.0, rel=1e-15)
    assert luminance(np.eye(3, dtype=np.float32)).tolist() == [0.2126, 0.7152, 0.0722]
