"""A sensible view of a scene that comes without a camera."""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.looks import Views
from openrooms_usd.geometry.pinhole import rotations
from openrooms_usd.geometry.raycast import Caster
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.geometry.views import FIRST_LOOK, clear, rate_views, sphere_directions

FOV_DEG: Final = 60.0  # degrees, horizontal
FRAME_MARGIN: Final = 1.05  # room around what is framed from outside

# From the front right, above.
_FROM: Final = np.array([0.55, -1.0, 0.6])

# A point is in a room where this much of what is around it shows it its front.
_ENCLOSED_SHARE: Final = 0.7
_EYE_LEVEL: Final = 1.5  # metres above the floor
_PITCH_DEG: Final = -12.0  # degrees: people look slightly down


def framing_view(points: ArrayLike, caster: Caster, aspect: float) -> Views:
    """One view of the whole: from inside where the scene is a closed room, else from outside.

    Args:
        points: (N, 3) of what is to be seen, metres.
        caster: The scene.
        aspect: Width over height of the picture, of field of view `FOV_DEG`.
    """
    places = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    low, high = (
        (places.min(axis=0), places.max(axis=0)) if len(places) else (-np.ones(3), np.ones(3))
    )
    eyes = _room_points(low, high, caster)
    if len(eyes):
        views = _around(eyes)
        rated = rate_views(caster, views, FOV_DEG, FIRST_LOOK)
        if np.isfinite(rated.max()):
            best = int(rated.argmax())
            return views[best : best + 1]
    return _outside(low, high, aspect)


def _room_points(low: Array, high: Array, caster: Caster) -> Array:
    """(C, 3) points at eye level from which nearly everything around is a front face."""
    steps = np.linspace(0.0, 1.0, 9)[1:-1]
    level = low[2] + min(_EYE_LEVEL, 0.6 * (high[2] - low[2]))
    plan = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    eyes = np.column_stack([low[:2] + plan * (high - low)[:2], np.full(len(plan), level)])
    around = sphere_directions(128)
    directions = np.tile(around, (len(eyes), 1))
    hits = caster.first_hit(np.repeat(eyes, len(around), axis=0), directions)
    if not hits.hit.any():
        return eyes[:0]
    facing = np.einsum("ij,ij->i", caster.normals_of(hits.triangle), directions) < 0
    enclosed = (hits.hit & facing).reshape(len(eyes), -1).mean(axis=1) >= _ENCLOSED_SHARE
    return np.asarray(eyes[enclosed & clear(caster, eyes)])


def _around(eyes: Array) -> Views:
    """Sixteen directions from each eye, slightly downwards."""
    yaw = np.tile(np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False), len(eyes))
    pitch = np.radians(_PITCH_DEG)
    forwards = np.stack([np.cos(yaw), np.sin(yaw), np.full(len(yaw), np.tan(pitch))], axis=1)
    return Views(np.repeat(eyes, 16, axis=0), unit(forwards))


def _outside(low: Array, high: Array, aspect: float) -> Views:
    """The bounding box from the front and above, as near as it fits the picture."""
    back = _FROM / np.linalg.norm(_FROM)
    centre, half = (low + high) / 2.0, np.maximum((high - low) / 2.0, 1e-3)
    signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
    corners = (signs * half) @ rotations(-back)[0]
    tangent = np.tan(np.radians(FOV_DEG) / 2.0) * np.array([1.0, 1.0 / aspect]) / FRAME_MARGIN
    needed = np.abs(corners[:, :2]) / tangent - corners[:, 2:]
    return Views((centre + back * needed.max())[None], -back[None])
