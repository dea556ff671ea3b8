"""Rays through a thin lens, and of panoramas."""

from typing import Any

import drjit as dr
import mitsuba as mi

from openrooms_usd.arrays import Array
from openrooms_usd.usd.cameras import PinholeCamera
from orusd_mitsuba.plugins.sensors import FAR_CLIP_METRES


class ThinLens:
    """Bends rays that a pinhole sends: all that meet its plane of focus at a point.

    Args:
        camera: One with a lens.
        origin: (3,) the point of the world that is Mitsuba's origin.
    """

    def __init__(self, camera: PinholeCamera, origin: Array) -> None:
        pose = camera.world_from_camera
        self._right, self._down, self._forward = (
            mi.Vector3f(axis) for axis in pose[:3, :3].T.tolist()
        )
        self._eye = mi.Point3f((pose[:3, 3] - origin).tolist())
        self._radius = mi.Float(camera.lens_radius)
        self._focus = mi.Float(camera.focus_distance)
        near, far = camera.clipping
        self._near, self._far = mi.Float(near), mi.Float(min(far, FAR_CLIP_METRES))
        # As variables, not as parts of the compiled code.
        dr.make_opaque(self._right, self._down, self._forward)
        dr.make_opaque(self._eye, self._radius, self._focus, self._near, self._far)

    def bent(self, ray: Any, sample: Any) -> Any:
        """Rays through the lens.

        Args:
            ray: Through its middle.
            sample: Where on the lens each goes through, in [0, 1)^2.
        """
        sharp = self._eye + ray.d * (self._focus / dr.dot(ray.d, self._forward))
        at = mi.warp.square_to_uniform_disk_concentric(sample) * self._radius
        found: Any = mi.Ray3f(ray)
        found.o = self._eye + self._right * at.x + self._down * at.y
        found.d = dr.normalize(sharp - found.o)
        # What has depth 1 along each ray.
        ahead = found.d / dr.dot(found.d, self._forward)
        found.o = found.o + ahead * self._near
        found.maxt = dr.norm(ahead) * (self._far - self._near)
        return found


class Panorama:
    """Turns rays into those of an equirectangular picture.

    Args:
        camera: One with that projection.
        origin: (3,) the point of the world that is Mitsuba's origin.
    """

    def __init__(self, camera: PinholeCamera, origin: Array) -> None:
        pose, K = camera.world_from_camera, camera.K
        self._right, self._down, self._forward = (
            mi.Vector3f(axis) for axis in pose[:3, :3].T.tolist()
        )
        self._eye = mi.Point3f((pose[:3, 3] - origin).tolist())
        self._middle = mi.Point2f(K[:2, 2].tolist())
        self._scale = mi.Vector2f([float(1.0 / K[0, 0]), float(1.0 / K[1, 1])])
        # As variables, not as parts of the compiled code.
        dr.make_opaque(self._right, self._down, self._forward)
        dr.make_opaque(self._eye, self._middle, self._scale)

    def turned(self, ray: Any, place: Any) -> Any:
        """Rays through places of the picture.

        Args:
            ray: As many, of any direction.
            place: In pixels, from the top left corner.
        """
        angle = (place - self._middle) * self._scale
        (sin_x, cos_x), (sin_y, cos_y) = dr.sincos(angle.x), dr.sincos(angle.y)
        found = mi.Ray3f(ray)
        found.o = self._eye
        found.d = dr.normalize(
            self._right * (cos_y * sin_x) + self._down * sin_y + self._forward * (cos_y * cos_x)
        )
        return found
