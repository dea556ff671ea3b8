"""Reading somebody's panorama: refused with a reason unless it can light a scene."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.library.environments import horizontal_illuminance
from openrooms_usd.usd.textures import color_space, read_texture

_LARGEST: Final = float(np.finfo(np.float32).max)


def read_panorama(path: str) -> NDArray[np.float32]:
    """Read a latitude-longitude picture with linear pixels, such as HDR or EXR.

    Args:
        path: The picture.

    Returns:
        (H, 2 H, 3) finite, not negative.

    Raises:
        InputError: It cannot be read, is encoded for a display, has another shape, or a pixel is no
            radiance.
    """
    if color_space(path) == "sRGB":
        raise InputError(
            "8 bits a colour are made for displays and hold no radiance",
            place=path,
            remedy="give an HDR or EXR picture, with linear pixels",
        )
    pixels = read_texture(path)
    height, width, channels = pixels.shape
    if width != 2 * height:
        raise InputError(
            f"{width} x {height} pixels are no latitude-longitude picture",
            place=path,
            remedy="give a panorama that is twice as wide as high",
        )
    if channels < 3:
        pixels = np.repeat(pixels[..., :1], 3, axis=2)
    pixels = np.ascontiguousarray(pixels[..., :3])
    _check_pixels(pixels, path)
    return pixels


def scaled_to_nits(
    pixels: NDArray[np.float32], path: str, *, illuminance: float | None, scale: float | None
) -> NDArray[np.float32]:
    """Bring a panorama to nits.

    Args:
        pixels: (H, 2 H, 3) of `read_panorama`.
        path: Where it is from, for messages.
        illuminance: Horizontal illuminance that it shall give, lux.
        scale: Nits for one unit of its pixels, when no illuminance is given; 1 by default.

    Raises:
        InputError: It is black where the illuminance comes from, or becomes too bright to store.
    """
    factor = 1.0 if scale is None else scale
    if illuminance is not None:
        given = horizontal_illuminance(pixels)
        if given <= 0.0:
            raise InputError(
                "its upper half is black: no factor gives an illuminance",
                place=path,
                remedy="remove illuminance, or give another picture",
            )
        factor = illuminance / given
    brightest = float(pixels.max()) * factor
    if brightest > _LARGEST:
        raise InputError(
            f"its brightest pixel would have {brightest:.3g} nits, more than a float can hold",
            place=path,
            remedy="lower scale or illuminance",
        )
    return np.asarray(pixels * np.float64(factor), dtype=np.float32)


def _check_pixels(pixels: NDArray[np.float32], path: str) -> None:
    bad = ~np.isfinite(pixels) | (pixels < 0.0)
    if bad.any():
        row, column, channel = (int(i[0]) for i in np.nonzero(bad))
        raise InputError(
            f"pixel ({column}, {row}) has {'RGB'[channel]} = {pixels[row, column, channel]}, which "
            f"is no radiance ({int(bad.any(axis=-1).sum())} such pixels)",
            place=path,
            remedy="mend the picture: radiance is finite and not negative",
        )
