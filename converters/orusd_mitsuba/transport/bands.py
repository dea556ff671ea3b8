"""Integrators that work in bands of rows, where one sample of all pixels is too much at once.

Instead of the whole picture they render pixels from anywhere in it, side by side in one row.
"""

from abc import ABC, abstractmethod
from copy import copy
from typing import Any, Final, Self

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.usd.cameras import EQUIRECTANGULAR, PinholeCamera
from orusd_mitsuba.plugins.build import load_sensor
from orusd_mitsuba.plugins.lenses import Panorama, ThinLens
from orusd_mitsuba.plugins.memory import aligned
from orusd_mitsuba.plugins.sensors import describe_sensor, has_lens, pinhole
from orusd_mitsuba.transport.strips import most_samples, strips

# Sums that one batch may keep, 4 bytes each, and paths that may be in flight.
_MOST_SUMS: Final = 1 << 26
_PATHS_IN_FLIGHT: Final = 1 << 21


class Band:
    """Some rows of a picture, with all samples of one batch.

    Attributes:
        where: Which.
        top: The first.
        rows: How many.
        samples: Of each pixel.
        seed: Of its random numbers.
        paths: One for each sample of each pixel, those of a pixel in a row.
    """

    def __init__(
        self, integrator: "BandedIntegrator", where: slice, samples: int, seed: int
    ) -> None:
        self._integrator, self.where, self.top = integrator, where, where.start
        self.samples, self.seed = samples, seed
        self.width = integrator.size[1]
        self.rows = where.stop - where.start
        self.paths = self.width * self.rows * samples

    def sampler(self, salt: int = 0, count: int | None = None) -> Any:
        """Independent random numbers for each path, or for as many as are asked for."""
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(self.seed ^ salt, self.paths if count is None else count)
        return sampler

    def ray(self, within: Any, lens: Any) -> Any:
        """Rays of the camera.

        Args:
            within: Where in its pixel each begins, in [0, 1)^2.
            lens: Where on the lens.
        """
        # As variables, not as parts of the compiled code: bands of all sizes share it.
        pixel = dr.arange(mi.UInt32, self.paths) // dr.opaque(mi.UInt32, self.samples)
        width, rows = self.width, (self.top, self.rows)
        numbers = self._integrator.pixels
        if numbers is None:
            # Looked up as well, so that sparse pixels need no code of their own.
            numbers = np.arange(width * self.rows, dtype=np.uint32)
        else:
            # They stand in a row, but lie anywhere in the picture.
            width, rows = self._integrator.width, (0, self._integrator.height)
        pixel = dr.gather(mi.UInt32, mi.UInt32(aligned(numbers)), pixel)
        across = dr.opaque(mi.UInt32, width)
        corner = mi.Point2f(mi.Float(pixel % across), mi.Float(pixel // across))
        step = mi.Vector2f(*(dr.opaque(mi.Float, 1.0 / side) for side in (width, rows[1])))
        at = (corner + within) * step
        described = self._integrator.sensor(rows)
        sensor = load_sensor(described, {"type": "independent"})
        ray = sensor.sample_ray(0.0, 0.5, at, lens)[0]
        if (panorama := self._integrator.panorama()) is not None:
            top = dr.opaque(mi.Float, float(rows[0]))
            return panorama.turned(ray, corner + within + mi.Vector2f(0.0, top))
        bending = self._integrator.lens()
        return ray if bending is None else bending.bent(ray, lens)

    def means(self, entries: Any) -> Floats:
        """(N, 3, rows, width) means over the samples of N times three entries a path."""
        sums = dr.block_sum(entries, self.samples).numpy()
        return np.asarray(sums.reshape(-1, 3, self.rows, self.width) / np.float32(self.samples))


class BandedIntegrator(ABC):
    """Renders batches of samples of a camera.

    Args:
        camera: The pinhole or lens.
        width: Pixels.
        height: Pixels.
        origin: (3,) the point of the world that is Mitsuba's origin.
        planes: How many pictures a batch gives.

    Attributes:
        planes: How many pictures a batch gives.
        width: Of the camera's picture.
        height: Of the camera's picture.
        size: Height and width of what is rendered of it: all, or a row of pixels.
        pixels: Numbers of these, row by row of the picture; None where it is all.
        capacity: Samples, of all pixels together, that one batch may have.
        most: Samples a pixel that a batch of the whole picture may have without being cut.
        broken: (height, width) bool, pixels in which a batch gave no number.
    """

    def __init__(
        self, camera: PinholeCamera, width: int, height: int, origin: Array, planes: int
    ) -> None:
        self._camera, self._origin = camera, origin
        self.planes, self.width, self.height = planes, width, height
        self.pixels: NDArray[np.uint32] | None = None
        self._fit(height, width)

    def sparse(self, pixels: NDArray[np.uint32]) -> Self:
        """The same for some pixels of the picture alone: what it gives is one row of them.

        Args:
            pixels: Their numbers, row by row of the picture.
        """
        found = copy(self)
        found.pixels = pixels
        found._fit(1, len(pixels))
        return found

    def _fit(self, height: int, width: int) -> None:
        """Set the size of what is rendered, and what of it fits into memory."""
        self.size = height, width
        self.capacity = min(_PATHS_IN_FLIGHT, _MOST_SUMS // (3 * self.planes))
        self.most = max(1, self.capacity // (width * height))
        self.broken = np.zeros((height, width), dtype=bool)

    def sensor(self, band: tuple[int, int]) -> dict[str, Any]:
        """The camera's part of the scene for some rows: the first, and how many."""
        camera = pinhole(self._camera)
        return describe_sensor(camera, self.width, self.height, self._origin, band)

    def lens(self) -> ThinLens | None:
        """What bends the camera's rays; None where all is in focus."""
        return ThinLens(self._camera, self._origin) if has_lens(self._camera) else None

    def panorama(self) -> Panorama | None:
        """What turns the camera's rays; None for all that Mitsuba has a sensor for."""
        if self._camera.projection != EQUIRECTANGULAR:
            return None
        return Panorama(self._camera, self._origin)

    def __call__(self, samples: int, seed: int) -> Floats:
        """Render one batch of the whole picture; equal seeds give equal bits.

        Returns:
            (planes, height, width, 3) means over the samples.
        """
        cut = enumerate(self.strips(samples))
        return np.concatenate([self.strip(rows, samples, seed + i) for i, rows in cut], axis=1)

    def strips(self, samples: int) -> list[slice]:
        """Rows to render at once; see `Integrator`."""
        return strips(self.size, self.planes, samples, self.capacity)

    def most_in(self, rows: slice) -> int:
        """Samples of each pixel that one batch of a strip may have."""
        return most_samples(rows, self.size[1], self.capacity)

    def strip(self, rows: slice, samples: int, seed: int) -> Floats:
        """Render one batch of some rows; equal seeds give equal bits.

        Returns:
            (planes, rows, width, 3) means over the samples.
        """
        pixels = self._band(Band(self, rows, samples, seed & 0xFFFFFFFF))
        finite = np.isfinite(pixels)
        if finite.all():
            return pixels
        self.broken[rows] |= ~finite.all(axis=(0, 3))
        return np.where(finite, pixels, np.float32(0.0))

    @abstractmethod
    def _band(self, band: Band) -> Floats:
        """(planes, rows, width, 3) means over the samples of a band."""
