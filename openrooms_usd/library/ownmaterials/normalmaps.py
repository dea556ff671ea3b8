"""What a normal map holds: whether it is one, how it is stored, and where its green points.

A relief h(s, t) has the normal (-dh/ds, -dh/dt, 1), normalized, in the OpenGL convention; in that
of DirectX the second number has the other sign. A map that does not say its convention is measured:
against the heights that lie beside it, else by itself. The slopes p = dh/ds and q = dh/dt of a
relief obey dp/dt = dq/ds, and with q of the wrong sign dp/dt = -dq/ds (integrability; Frankot and
Chellappa 1988).
"""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.usd.shading.surfaces import NORMAL_BIAS, NORMAL_SCALE
from openrooms_usd.usd.shading.textures import picture_facts, read_texture

Green = Literal["up", "down"]
Four = tuple[float, float, float, float]

# Pictures with more values are not read for this: their names are believed.
_MOST_VALUES: Final = 3 * 4096**2
# The least correlation that is evidence rather than noise and compression.
_MIN_CORRELATION: Final = 0.1
# Steeper slopes come from damaged texels.
_MAX_SLOPE: Final = 20.0
_ASSUMED: Final = "its name says neither OpenGL nor DirectX; OpenGL is assumed"
# Floating point pictures may hold the normals themselves.
_AS_IT_IS: Final[tuple[Four, Four]] = ((1.0, 1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 0.0))


@dataclass(frozen=True)
class Relief:
    """How the normals of a picture are read: ``stored * scale + bias`` is OpenGL's, in -1..1.

    Attributes:
        scale: Factor of r, g, b, a.
        bias: Offset of r, g, b, a.
        losses: What was assumed or measured, in words.
    """

    scale: Four
    bias: Four
    losses: tuple[str, ...] = ()


def read_relief(file: str, stated: Green | None, heights: str | None = None) -> Relief | str:
    """How a normal map is read.

    Args:
        file: The picture.
        stated: Where its green points along t, if its name says.
        heights: A picture of the same relief's heights, if there is one.

    Returns:
        Scale and bias, or the reason why the picture is not a normal map.

    Raises:
        InputError: It cannot be read.
    """
    facts = picture_facts(file)
    if facts.channels < 3:
        return "a grey-scale picture holds heights, not normals"
    if facts.width * facts.height * facts.channels > _MOST_VALUES:
        return Relief(*_stored(stated or "up", False), () if stated else (_ASSUMED,))
    pixels = _finite(read_texture(file)[..., :3])
    if pixels.shape[:2] != (1, 1) and np.ptp(pixels, axis=2).max() < 1e-3:
        return "all its pixels are grey: it holds heights, not normals"
    signed = facts.is_float and bool(pixels.min() < -0.01)
    if stated:
        return Relief(*_stored(stated, signed))
    green, loss = _measured(pixels if signed else pixels * 2.0 - 1.0, heights)
    return Relief(*_stored(green, signed), (loss,))


def _finite(values: Floats) -> Array:
    with np.errstate(invalid="ignore"):
        return np.nan_to_num(values.astype(np.float64))


def _measured(normals: Array, heights: str | None) -> tuple[Green, str]:
    """Where green points by what the pixels say, and how it is known."""
    evidence = height_agreement(normals, heights) if heights else 0.0
    source = "its displacement map"
    if abs(evidence) < _MIN_CORRELATION:
        evidence, source = green_agreement(normals), "its slopes"
    if abs(evidence) < _MIN_CORRELATION:
        return "up", _ASSUMED
    if evidence > 0.0:
        return "up", f"its name says neither OpenGL nor DirectX; {source} shows that it is OpenGL's"
    return "down", f"its name says neither OpenGL nor DirectX; {source} shows that it is DirectX's"


def _stored(green: Green, signed: bool) -> tuple[Four, Four]:
    """Scale and bias; a green that points down is turned by its sign, the file stays."""
    scale, bias = _AS_IT_IS if signed else (NORMAL_SCALE, NORMAL_BIAS)
    if green == "up":
        return scale, bias
    return (scale[0], -scale[1], scale[2], 1.0), (bias[0], 0.0 - bias[1], bias[2], 0.0)


def height_agreement(normals: Array, heights: str) -> float:
    """How well green agrees with the slope of a picture of heights, -dh/dt.

    Args:
        normals: (H, W, 3) in -1..1, the first row at the top.
        heights: The picture; one of another resolution says nothing.

    Returns:
        Their correlation: positive for OpenGL, negative for DirectX.

    Raises:
        InputError: The picture cannot be read.
    """
    facts = picture_facts(heights)
    if (facts.height, facts.width) != normals.shape[:2] or facts.height < 3:
        return 0.0
    values = _finite(read_texture(heights)[..., 0])
    # Rows run against t.
    return _correlation(normals[1:-1, :, 1], values[2:] - values[:-2])


def green_agreement(normals: Array) -> float:
    """How well normals obey integrability with green along +t.

    Args:
        normals: (H, W, 3) in -1..1, the first row at the top.

    Returns:
        The correlation of dp/dt with dq/ds: positive for OpenGL, negative for DirectX, near 0 where
        the map is flat or has only grooves along the axes.
    """
    if min(normals.shape[:2]) < 3:
        return 0.0
    up = np.maximum(normals[..., 2], 1e-3)
    p, q = (np.clip(-normals[..., k] / up, -_MAX_SLOPE, _MAX_SLOPE) for k in (0, 1))
    return _correlation(p[:-2, 1:-1] - p[2:, 1:-1], q[1:-1, 2:] - q[1:-1, :-2])


def _correlation(a: Array, b: Array) -> float:
    norm = float(np.sqrt((a**2).sum() * (b**2).sum()))
    return float((a * b).sum()) / norm if norm > 1e-9 else 0.0
