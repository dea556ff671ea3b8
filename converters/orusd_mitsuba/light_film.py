"""Pictures of a camera, each split by the number of scatterings and by light."""

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.render.scene.pictures import Array
from openrooms_usd.usd.cameras import PinholeCamera
from orusd_mitsuba.bands import Band, BandedFilm
from orusd_mitsuba.sources import Filing
from orusd_mitsuba.spread import FirstNumbers
from orusd_mitsuba.transport import KINDS, Ledger, trace

# Sets the seeds of pixels apart from those of paths.
_SHIFTED: Final = 0x5EED5EED


class LightFilm(BandedFilm):
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
        self._depth, self._first = depth, first
        self._lights = filing.count if by_light else None
        planes = len(KINDS) + (self._lights or 0)
        super().__init__(camera, width, height, origin, planes)

    def _band(self, band: Band) -> NDArray[np.float32]:
        sampler = band.sampler()
        pixels = band.paths // band.samples
        numbers = FirstNumbers(band.samples, band.paths, band.sampler(_SHIFTED, pixels))
        ray = band.ray(numbers.pixel, sampler.next_2d())
        ledger = Ledger(band.paths, self._lights)
        trace(
            self._built, self._filing, sampler, ray, ledger, self._depth, self._first,
            numbers=numbers,
        )  # fmt: skip
        wanted = [ledger.kinds] if ledger.lights is None else [ledger.kinds, ledger.lights]
        means = np.concatenate([band.means(entries) for entries in wanted])
        return np.ascontiguousarray(np.moveaxis(means, 1, 3))
