"""Radiance by Mitsuba's own path integrator, for backends that would call Python a sample."""

from typing import Any, Final

import mitsuba as mi
import numpy as np

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.errors import RenderError
from openrooms_usd.rendering import RenderRequest
from openrooms_usd.usd.cameras import EQUIRECTANGULAR, PinholeCamera
from orusd_mitsuba.plugins.build import load_sensor
from orusd_mitsuba.plugins.sensors import describe_sensor
from orusd_mitsuba.transport.strips import most_samples, strips

# Paths in flight at once; each takes some 200 bytes of memory.
_PATHS_IN_FLIGHT: Final = 1 << 22


class BuiltinIntegrator:
    """Renders batches of samples of a camera, in strips where a whole one takes too much memory.

    Args:
        built: The scene.
        camera: The camera.
        request: Size, samples and bounces.
        origin: (3,) the point of the world that is Mitsuba's origin.
        panes: Whether the scene has clear panes among its shapes.

    Attributes:
        planes: 1, the radiance.
        size: Height and width.
        most: Samples a pixel that a batch of the whole picture may have without being cut.
        broken: (height, width) bool, pixels in which a batch gave no number.
    """

    def __init__(
        self,
        built: Any,
        camera: PinholeCamera,
        request: RenderRequest,
        origin: Array,
        *,
        panes: bool = False,
    ) -> None:
        if camera.projection == EQUIRECTANGULAR:
            raise RenderError(
                "scalar variants of Mitsuba cannot render panoramas",
                place=request.camera,
                remedy="use a vectorized variant, such as llvm",
            )
        self._built, self._camera, self._origin = built, camera, origin
        self.planes, self.size = 1, (request.height, request.width)
        self.most = max(1, _PATHS_IN_FLIGHT // (request.width * request.height))
        # The one of media lets light samples, too, go straight through panes.
        kind = "volpath" if panes else "path"
        self._integrator = mi.load_dict({"type": kind, "max_depth": request.bounces + 1})
        self.broken = np.zeros((request.height, request.width), dtype=bool)

    def __call__(self, samples: int, seed: int) -> Floats:
        """Render one batch of the whole picture: (1, height, width, 3)."""
        cut = enumerate(self.strips(samples))
        return np.concatenate([self.strip(rows, samples, seed + i) for i, rows in cut], axis=1)

    def strips(self, samples: int) -> list[slice]:
        """Rows to render at once; see `Integrator`."""
        return strips(self.size, self.planes, samples, _PATHS_IN_FLIGHT)

    def most_in(self, rows: slice) -> int:
        """Samples of each pixel that one batch of a strip may have."""
        return most_samples(rows, self.size[1], _PATHS_IN_FLIGHT)

    def strip(self, rows: slice, samples: int, seed: int) -> Floats:
        """Render one batch of some rows: (1, rows, width, 3)."""
        height, width = self.size
        band = rows.start, rows.stop - rows.start
        described = describe_sensor(self._camera, width, height, self._origin, band)
        pixels = mi.render(
            self._built,
            sensor=load_sensor(described, {"type": "independent"}),
            integrator=self._integrator,
            spp=samples,
            seed=seed & 0xFFFFFFFF,
        ).numpy()
        finite = np.isfinite(pixels)
        self.broken[rows] |= ~finite.all(axis=2)
        return np.where(finite, pixels, np.float32(0.0))[None]
