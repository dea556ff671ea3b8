"""What a denoiser is guided by: base colour and normal, averaged over whole pixels and the lens.

The channels of these names tell of pixels' centres. Where threads or stripes are as fine as pixels,
centres see a pattern that is not there (moire), and a denoiser copies it into the picture.
"""

from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.arrays import Floats
from openrooms_usd.usd.cameras import PinholeCamera
from orusd_mitsuba.complete.meeting import CompleteScene, meet
from orusd_mitsuba.plugins.openrooms_bsdf import view_of
from orusd_mitsuba.transport.bands import Band, BandedIntegrator
from orusd_mitsuba.transport.lattice import FirstDimensions

# Rays of a pixel. The standard error of a pattern of black and white is then about 2 %, less than
# that of light among as many samples; a ray costs a small part of a path.
SAMPLES: Final = 32
# Sets the seeds of pixels apart from those of rays.
_SHIFT_SALT: Final = 0x5EED5EED


class GuideIntegrator(BandedIntegrator):
    """Renders base colour and unit shading normal of what a camera's rays are stopped by.

    Args:
        scene: What it sees.
        camera: The pinhole or lens.
        width: Pixels.
        height: Pixels.
    """

    def __init__(
        self, scene: CompleteScene, camera: PinholeCamera, width: int, height: int
    ) -> None:
        self._scene = scene
        super().__init__(camera, width, height, scene.origin, planes=2)

    def _band(self, band: Band) -> Floats:
        sampler = band.sampler()
        pixels = band.paths // band.samples
        numbers = FirstDimensions(band.samples, band.paths, band.sampler(_SHIFT_SALT, pixels))
        ray = band.ray(numbers.pixel, numbers.light)
        crossed = dr.opaque(mi.UInt32, self._scene.index.elsewhere)
        found = meet(self._scene, sampler, ray, crossed, mi.Bool(True), _unlit, mirrors=False)
        si = found.si
        hit = si.is_valid()
        matter = self._scene.matter(si, hit)
        normal = si.to_world(view_of(si, matter.relief).frame.n)
        looks = [
            dr.select(hit, value, 0.0) for part in (matter.base_color, normal) for value in part
        ]
        means = band.means(dr.concat([mi.Float(value) for value in looks]))
        return np.ascontiguousarray(np.moveaxis(means, 1, 3))


def _unlit(met: Any, ray: Any, light: Any, radiance: Any, turned: Any, active: Any) -> None:
    """Of what emits nothing is counted."""
