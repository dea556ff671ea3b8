"""Rooms that are boxes with boxes in them, seen by closed forms, and photographs of them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.appearance.motions import motion
from openrooms_usd.appearance.views import Geometry, Photograph, Seen, Size
from openrooms_usd.arrays import Array
from openrooms_usd.geometry.pinhole import intrinsics, pixel_directions, rotations
from openrooms_usd.geometry.rotations import pose

SIZE = (240, 180)
K = intrinsics(75.0, *SIZE)
ROOM = ((0.0, 0.0, 0.0), (4.4, 3.6, 2.5))
FURNITURE = (
    ((1.6, 1.2, 0.0), (2.6, 1.9, 0.7)),
    ((0.0, 2.6, 0.0), (0.5, 3.6, 1.9)),
    ((3.6, 0.3, 0.0), (4.4, 1.1, 1.2)),
)
COLORS = np.random.default_rng(5).integers(30, 226, (40, 3))

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def box_room(room: Box = ROOM, furniture: Sequence[Box] = FURNITURE) -> Geometry:
    """What cameras inside a box see: its walls, and boxes in it."""

    def seen(K: Array, world_from_camera: Array, size: Size) -> Seen:
        rays = pixel_directions(K, *size) @ world_from_camera[:3, :3].T
        eye = world_from_camera[:3, 3]
        rays = np.where(np.abs(rays) < 1e-12, 1e-12, rays)
        # From inside, the wall is where the last slab ends; from outside where the last begins.
        depth, axis = _slabs(room, eye, rays, leave=True)
        side = 2 * axis + (np.take_along_axis(rays, axis[..., None], -1)[..., 0] > 0)
        part = 1 + side
        for number, box in enumerate(furniture):
            near, face = _slabs(box, eye, rays, leave=False)
            far, _ = _slabs(box, eye, rays, leave=True)
            first = (near > 0) & (near < far) & (near < depth)
            depth, axis = np.where(first, near, depth), np.where(first, face, axis)
            part = np.where(first, 7 + 3 * number + face, part)
        normal = -np.sign(rays) * (axis[..., None] == np.arange(3))
        return Seen(depth, normal, part)

    return seen


def _slabs(box: Box, eye: Array, rays: Array, *, leave: bool) -> tuple[Array, NDArray[np.int64]]:
    low, high = ((np.array(corner) - eye) / rays for corner in box)
    times = np.maximum(low, high) if leave else np.minimum(low, high)
    axis = times.argmin(-1) if leave else times.argmax(-1)
    return np.take_along_axis(times, axis[..., None], -1)[..., 0], axis


def cameras(count: int, room: Box = ROOM) -> list[Array]:
    """(4, 4) poses on a circle in a room, each looking across it and a little down."""
    middle = 0.5 * (np.array(room[0]) + room[1])
    found = []
    for angle in 0.3 + 2.0 * np.pi * np.arange(count) / count:
        out = np.array([np.cos(angle), np.sin(angle), 0.0])
        eye = middle + 0.9 * out + (0.0, 0.0, 0.2)
        found.append(pose(rotations([(-out + (0.0, 0.0, -0.35)).tolist()])[0], eye))
    return found


def photographs(
    geometry: Geometry, poses: Sequence[Array], *, depth: bool, room: Box = ROOM
) -> list[Photograph]:
    """Pictures in which each surface has one colour, with depth maps or without."""
    taken = []
    for one in poses:
        seen = geometry(K, one, SIZE)
        pixels = COLORS[seen.part].astype(np.uint8)
        taken.append(Photograph(pixels, K, one, seen.depth if depth else None))
    return taken


def noisy(poses: Sequence[Array], seed: int = 3) -> list[Array]:
    """Poses that are 2 cm and 1 degree off."""
    random = np.random.default_rng(seed)
    found = []
    for one in poses:
        shift, turn = (v / np.linalg.norm(v) for v in random.normal(size=(2, 3)))
        off = np.concatenate([0.02 * shift, np.radians(1.0) * turn])
        found.append(motion(off, one[:3, 3]) @ one)
    return found
