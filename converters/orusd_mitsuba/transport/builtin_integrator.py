"""Radiance by Mitsuba's own path integrator, for backends that would call Python a sample."""

from typing import Any, Final

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.render import RenderRequest
from openrooms_usd.usd.cameras import PinholeCamera
from orusd_mitsuba.plugins.build import load_sensor
from orusd_mitsuba.plugins.sensors import describe_sensor

# Paths in flight at once; each takes some 200 bytes of memory.
_PATHS_IN_FLIGHT: Final = 1 << 22


class BuiltinIntegrator:
    """Renders batches of samples of a camera, in bands where a whole one takes too much memory.

    Attributes:
        planes: 1, the radiance.
        size: Height and width.
        most: Samples a pixel that one batch may have at most.
        broken: (height, width) bool, pixels in which a batch gave no number.
    """

    def __init__(
        self, built: Any, camera: PinholeCamera, request: RenderRequest, origin: NDArray[np.float64]
    ) -> None:
        self._built = built
        self.planes, self.size = 1, (request.height, request.width)
        self.most = max(1, _PATHS_IN_FLIGHT // (request.width * request.height))
        self._integrator = mi.load_dict({"type": "path", "max_depth": request.bounces + 1})
        rows = max(1, _PATHS_IN_FLIGHT // request.width)
        self._bands = [
            load_sensor(
                describe_sensor(
                    camera,
                    request.width,
                    request.height,
                    origin,
                    (top, min(rows, request.height - top)),
                ),
                {"type": "independent"},
            )
            for top in range(0, request.height, rows)
        ]
        self.broken = np.zeros((request.height, request.width), dtype=bool)

    def __call__(self, samples: int, seed: int) -> NDArray[np.float32]:
        """Render one batch: (1, height, width, 3)."""
        bands = [
            mi.render(
                self._built,
                sensor=sensor,
                integrator=self._integrator,
                spp=samples,
                seed=(seed + number) & 0xFFFFFFFF,
            ).numpy()
            for number, sensor in enumerate(self._bands)
        ]
        pixels = np.concatenate(bands)
        finite = np.isfinite(pixels)
        self.broken |= ~finite.all(axis=2)
        return np.where(finite, pixels, np.float32(0.0))[None]
