"""Pictures of a camera, each split by the number of scatterings and by light."""

from collections.abc import Callable
from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.usd.cameras import PinholeCamera
from orusd_mitsuba.build import load_sensor
from orusd_mitsuba.pictures import Array
from orusd_mitsuba.sensors import describe_sensor
from orusd_mitsuba.sources import Filing
from orusd_mitsuba.spread import FirstNumbers
from orusd_mitsuba.transport import KINDS, Ledger, trace

# Floats that one pass may file, 4 bytes each, and paths that may be in flight.
_ENTRIES: Final = 1 << 27
_PATHS: Final = 1 << 21
# Sets the seeds of pixels apart from those of paths.
_SHIFTED: Final = 0x5EED5EED


class LightFilm:
    """Renders passes of a camera: what was scattered never, once and more often, then every light.

    Args:
        built: The Mitsuba scene.
        filing: Its lights.
        camera: The pinhole or lens.
        width: Pixels.
        height: Pixels.
        origin: (3,) the point of the world that is Mitsuba's origin.
        depth: At most this many segments of a path.
        by_light: Whether to split by light too.
        first: See `orusd_mitsuba.transport.trace`.

    Attributes:
        planes: How many pictures a pass gives.
        size: Height and width.
        most: Samples a pixel that one pass may take at most.
        broken: (height, width) bool, pixels in which a pass gave no number.
    """

    def __init__(
        self,
        built: Any,
        filing: Filing,
        camera: PinholeCamera,
        width: int,
        height: int,
        origin: Array,
        depth: int,
        *,
        by_light: bool = True,
        first: Callable[[Any], Any] | None = None,
    ) -> None:
        self._built, self._filing = built, filing
        self._width, self._height = width, height
        self._depth, self._first = depth, first
        self._lights = filing.count if by_light else None
        self._camera, self._origin = camera, origin
        self.planes = len(KINDS) + (self._lights or 0)
        self.size = height, width
        # Where one sample of all pixels is too much, the picture is made in bands of rows.
        self._rows = max(1, min(height, self._fitting // width))
        self.most = max(1, self._fitting // (width * self._rows))
        self.broken = np.zeros((height, width), dtype=bool)

    @property
    def _fitting(self) -> int:
        """Paths that one pass may follow."""
        return min(_PATHS, _ENTRIES // (3 * self.planes))

    def __call__(self, samples: int, seed: int) -> NDArray[np.float32]:
        """Render one pass; equal seeds give equal bits.

        Returns:
            (planes, height, width, 3).
        """
        tops = range(0, self._height, self._rows)
        bands = [self._band(top, samples, (seed + i) & 0xFFFFFFFF) for i, top in enumerate(tops)]
        pixels = np.concatenate(bands, axis=1)
        finite = np.isfinite(pixels)
        self.broken |= ~finite.all(axis=(0, 3))
        return np.where(finite, pixels, np.float32(0.0))

    def _band(self, top: int, samples: int, seed: int) -> NDArray[np.float32]:
        rows = min(self._rows, self._height - top)
        paths = self._width * rows * samples
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, paths)
        shifts = mi.load_dict({"type": "independent"})
        shifts.seed(seed ^ _SHIFTED, paths // samples)
        numbers = FirstNumbers(samples, paths, shifts)
        pixel = dr.arange(mi.UInt32, paths) // samples
        corner = mi.Point2f(mi.Float(pixel % self._width), mi.Float(pixel // self._width))
        at = (corner + numbers.pixel) / mi.Point2f(self._width, rows)
        description = describe_sensor(
            self._camera, self._width, self._height, self._origin, (top, rows)
        )
        sensor = load_sensor(description, {"type": "independent"})
        ray, _ = sensor.sample_ray(0.0, 0.5, at, sampler.next_2d())
        ledger = Ledger(paths, self._lights)
        trace(
            self._built, self._filing, sampler, ray, ledger, self._depth, self._first,
            numbers=numbers,
        )  # fmt: skip
        wanted = [ledger.kinds] if ledger.lights is None else [ledger.kinds, ledger.lights]
        return np.concatenate([_image(entries, samples, rows, self._width) for entries in wanted])


def _image(entries: Any, samples: int, rows: int, width: int) -> NDArray[np.float32]:
    sums = dr.block_sum(entries, samples)
    planes = sums.numpy().reshape(-1, 3, rows, width) / np.float32(samples)
    return np.ascontiguousarray(np.moveaxis(planes, 1, 3))
