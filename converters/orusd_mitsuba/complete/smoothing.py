"""Light that varies slowly over surfaces, taken from the samples of neighbouring pixels too.

What arrives indirectly changes from point to point no faster than what it comes from is far away.
So it is averaged over neighbours on the same surface, within a part of the harmonic mean of the
distances that the samples have met (the split-sphere model: Ward, Rubinstein, Clear 1988). What a
lobe mirrors is the same over what is small beside the lobe's footprint. All lights share the
weights, which know nothing of light: the average is linear. Wide averages are made of few taps,
level by level at doubled steps (a trous: Dammertz et al. 2010).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Floats
from orusd_mitsuba.complete.accumulator import GUIDES
from orusd_mitsuba.plugins.memory import aligned

# The standard deviation of the average, in parts of the harmonic mean distance.
_RADIUS_PER_DISTANCE: Final = 0.12
# Of lobes, in parts of what their footprint is there.
_RADIUS_PER_FOOTPRINT: Final = 0.2
# How far neighbours may be off the plane, in parts of that.
_HEIGHT_PER_RADIUS: Final = 0.5
# 1 - cos of the angle between normals at which neighbours count 1 / e; of a lobe of one radian,
# with the square of the width.
_TURN: Final = 0.0625
_TURN_OF_LOBE: Final = 0.02
# Where surfaces meet, distances go to 0: at least so many pixels.
_LEAST_RADIUS_PIXELS: Final = 2.0
# What is one flat surface: 1 - cos between normals, height over distance.
_FLAT_TURN: Final = 0.1
_FLAT_SLOPE: Final = 0.1
# What a pixel must have of surfaces.
_LEAST_COVERAGE: Final = 0.5
_KERNEL: Final = (1 / 16, 4 / 16, 6 / 16, 4 / 16, 1 / 16)
_TAPS: Final = tuple(
    (x - 2, y - 2, _KERNEL[x] * _KERNEL[y]) for y in range(5) for x in range(5) if (x, y) != (2, 2)
)
_CENTRE: Final = _KERNEL[2] ** 2
# The last level reaches over about a fifth of the picture.
_PIXELS_A_LEVEL: Final = 10
_MOST_LEVELS: Final = 8


@dataclass(frozen=True, eq=False)
class IrradianceGradient:
    """How slowly some light varies at the pixels of a picture.

    Attributes:
        coverage: (height, width) the part of a pixel that has such light.
        change: (height, width) per metre, one over the radius that averages may have.
        turn: (height, width) 1 - cos between normals at which neighbours count 1 / e.
        least_pixels: The least radius.
    """

    coverage: Floats
    change: Floats
    turn: Floats
    least_pixels: float

    @staticmethod
    def of_irradiance(guides: Floats) -> "IrradianceGradient":
        """Of what arrives indirectly."""
        nearness = guides[GUIDES.index("nearness")]
        coverage = nearness[..., 1]
        change = nearness[..., 0] / np.maximum(coverage, 1e-6) / _RADIUS_PER_DISTANCE
        turn = np.full_like(coverage, _TURN)
        return IrradianceGradient(coverage, change, turn, _LEAST_RADIUS_PIXELS)

    @staticmethod
    def of_lobes(guides: Floats) -> "IrradianceGradient":
        """Of what specular lobes mirror indirectly."""
        lobe = guides[GUIDES.index("lobe")]
        coverage = lobe[..., 2]
        width, change = (lobe[..., row] / np.maximum(coverage, 1e-6) for row in range(2))
        width = np.maximum(width, 1e-4)
        change = change / (_RADIUS_PER_FOOTPRINT * width)
        return IrradianceGradient(coverage, change, _TURN_OF_LOBE * width**2, 0.0)


def smoothed(planes: Iterable[Floats], guides: Floats, how: IrradianceGradient) -> list[Floats]:
    """Pictures of light, each averaged over neighbours by the same weights.

    Args:
        planes: (height, width, 3) each.
        guides: (6, height, width, 3) means over the same samples, `GUIDES`.
        how: What the weights are.
    """
    shape = guides.shape[1:]
    found = [[mi.Float(column) for column in _columns(plane)] for plane in planes]
    surfaces = _Surfaces(guides, how)
    levels = int(np.clip(np.log2(shape[1] / _PIXELS_A_LEVEL), 1, _MOST_LEVELS))
    for level in range(levels):
        taps = surfaces.taps(1 << level)
        found = [taps.average(colours) for colours in found]
    return [
        np.stack([np.asarray(colour.numpy()) for colour in colours], axis=-1).reshape(shape)
        for colours in found
    ]


class _Surfaces:
    """What the pixels of a picture see, as arrays of the active variant.

    Args:
        guides: See `smoothed`.
        how: See `smoothed`.
    """

    def __init__(self, guides: Floats, how: IrradianceGradient) -> None:
        _, self._height, self._width, _ = guides.shape
        normal, point, near = (guides[GUIDES.index(n)] for n in ("normal", "position", "nearness"))
        length = np.maximum(np.linalg.norm(normal, axis=-1), 1e-9)
        self._normal = mi.Vector3f(*_columns(normal / length[..., None]))
        self._point = mi.Point3f(*_columns(point / np.maximum(near[..., 1:2], 1e-6)))
        self._is_surface = mi.Float(_flat(how.coverage > _LEAST_COVERAGE))
        self._turn = mi.Float(_flat(1.0 / how.turn))
        self._pixel = dr.arange(mi.Int32, self._height * self._width)
        self._columns = dr.opaque(mi.Int32, self._width)
        self._rows = dr.opaque(mi.Int32, self._height)
        self._inverse = self._inverse_radius(mi.Float(_flat(how.change)), how.least_pixels)

    def taps(self, step: int) -> "_Taps":
        """The weights of neighbours so many pixels apart."""
        places, weights, total = [], [], mi.Float(_CENTRE)
        for x, y, kernel in _TAPS:
            place, there = self._neighbour(x, y, step)
            weight = kernel * self._alike(place, there)
            places.append(place)
            weights.append(weight)
            total += weight
        weights = [weight / total for weight in weights]
        centre = _CENTRE / total
        dr.eval(weights, centre)
        return _Taps(places, weights, centre)

    def _neighbour(self, x: int, y: int, step: int) -> tuple[Any, Any]:
        """Numbers of the pixels beside all, and whether there are such with a surface."""
        # As variables, not as parts of the compiled code: all levels and sizes share it.
        down, across = (dr.opaque(mi.Int32, steps * step) for steps in (y, x))
        row, column = self._pixel // self._columns + down, self._pixel % self._columns + across
        inside = (row >= 0) & (row < self._rows) & (column >= 0) & (column < self._columns)
        place = mi.UInt32(dr.select(inside, row * self._columns + column, 0))
        return place, inside

    def _alike(self, place: Any, inside: Any) -> Any:
        """How much alike what arrives at pixels and at their neighbours is, 0 to 1."""
        offset, turn, there = self._between(place, inside)
        inverse = 0.5 * (self._inverse + dr.gather(mi.Float, self._inverse, place, inside))
        height = dr.dot(offset, self._normal) * inverse / _HEIGHT_PER_RADIUS
        apart = dr.squared_norm(offset) * dr.square(inverse) + dr.square(height)
        stricter = dr.maximum(self._turn, dr.gather(mi.Float, self._turn, place, inside))
        return dr.select(there, dr.exp(-0.5 * apart - turn * stricter), 0.0)

    def _between(self, place: Any, inside: Any) -> tuple[Any, Any, Any]:
        """The way to other pixels' points, 1 - cos between normals, and where both are surfaces."""
        there = inside & (self._is_surface > 0.0)
        there &= dr.gather(mi.Float, self._is_surface, place, inside) > 0.0
        offset = dr.gather(mi.Point3f, self._point, place, there) - self._point
        normal = dr.gather(mi.Vector3f, self._normal, place, there)
        return offset, dr.maximum(0.0, 1.0 - dr.dot(normal, self._normal)), there

    def _inverse_radius(self, change: Any, least_pixels: float) -> Any:
        """Per metre, of the averages: told by few samples itself, so by those of neighbours too."""
        total, count, spacing = mi.Float(change), mi.Float(1.0), mi.Float(dr.inf)
        for x, y, _ in _TAPS:
            place, inside = self._neighbour(x, y, 1)
            offset, turn, there = self._between(place, inside)
            distance = dr.norm(offset)
            same = there & (turn < _FLAT_TURN)
            same &= dr.abs(dr.dot(offset, self._normal)) <= _FLAT_SLOPE * distance
            total += dr.select(same, dr.gather(mi.Float, change, place, same), 0.0)
            count += dr.select(same, 1.0, 0.0)
            if abs(x) + abs(y) == 1:
                spacing = dr.select(there, dr.minimum(spacing, distance), spacing)
        least = dr.opaque(mi.Float, least_pixels) * dr.maximum(spacing, 1e-6)
        found = dr.minimum(total / count, dr.rcp(dr.maximum(least, 1e-9)))
        dr.eval(found)
        return found


class _Taps:
    """Weighted neighbours of all pixels.

    Args:
        places: Numbers of pixels, for each tap.
        weights: Theirs.
        centre: That of the pixels themselves.
    """

    def __init__(self, places: list[Any], weights: list[Any], centre: Any) -> None:
        self._places, self._weights, self._centre = places, weights, centre

    def average(self, colours: list[Any]) -> list[Any]:
        """The weighted means of a picture's planes."""
        sums = [self._centre * colour for colour in colours]
        for place, weight in zip(self._places, self._weights, strict=True):
            for number, colour in enumerate(colours):
                sums[number] += weight * dr.gather(mi.Float, colour, place, weight > 0.0)
        dr.eval(sums)
        return sums


def _flat(plane: NDArray[Any]) -> Floats:
    return aligned(np.asarray(plane, dtype=np.float32))


def _columns(plane: NDArray[Any]) -> list[Floats]:
    return [_flat(plane[..., number]) for number in range(3)]
