"""Upright views, small pictures of what they see, and how good they are by these."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.pinhole import intrinsics, pixel_directions, rotations
from openrooms_usd.geometry.raycast import Caster
from openrooms_usd.geometry.sights import parts_of

Array = NDArray[np.float64]

NEAR: Final = 0.4  # what is nearer than this, in metres, blocks the view
BLOCKED: Final = 0.1  # largest fraction of pixels that may be blocked
OPEN: Final = 0.5  # largest fraction of pixels that may see nothing


@dataclass(frozen=True, eq=False)
class Views:
    """Upright camera poses.

    Attributes:
        eyes: (C, 3) metres.
        forwards: (C, 3) unit viewing directions.
    """

    eyes: Array
    forwards: Array

    def __len__(self) -> int:
        return len(self.eyes)

    def __getitem__(self, rows: NDArray[np.int64] | NDArray[np.bool_] | slice) -> "Views":
        return Views(self.eyes[rows], self.forwards[rows])

    def poses(self) -> Array:
        """(C, 4, 4) world_from_camera, OpenCV frame."""
        poses = np.tile(np.eye(4), (len(self), 1, 1))
        poses[:, :3, :3], poses[:, :3, 3] = rotations(self.forwards), self.eyes
        return poses


@dataclass(frozen=True, eq=False)
class Look:
    """Small pictures of what C views see, of H x W pixels.

    Attributes:
        views: The views.
        fov_degrees: Their horizontal field of view.
        depth: (C, H, W) planar depth, metres; 0 where nothing is seen.
        normals: (C, H, W, 3) towards the eye; 0 where nothing is seen.
        triangles: (C, H, W) rows of the caster's triangles; -1 where nothing is seen.
        places: (C, H, W, 3) what is seen, metres; the eye where nothing is.
    """

    views: Views
    fov_degrees: float
    depth: Array
    normals: Array
    triangles: NDArray[np.int32]
    places: Array

    @property
    def seen(self) -> NDArray[np.bool_]:
        """(C, H, W) whether anything is seen."""
        return self.triangles >= 0


Rating = Callable[[Look], Array]
"""(C,) how good views are, from a look at them."""


def rated(
    caster: Caster, views: Views, fov: float, resolution: tuple[int, int], rating: Rating
) -> tuple[Array, NDArray[np.int64]]:
    """Scores of views, and what is in them.

    Args:
        caster: The scene.
        views: C views.
        fov: Horizontal field of view, degrees.
        resolution: Width and height of the pictures that are cast; N pixels.
        rating: How good they are.

    Returns:
        (C,) scores, -inf for views that are blocked or empty; (C, N) the parts of the room in
        the pixels.
    """
    rows = [
        _rate(look_of(caster, views[start : start + 32], fov, *resolution), rating)
        for start in range(0, len(views), 32)
    ]
    pixels = resolution[0] * resolution[1]
    scores = np.concatenate([np.zeros(0), *(row[0] for row in rows)])
    parts = [np.zeros((0, pixels), dtype=np.int64), *(row[1] for row in rows)]
    return scores, np.concatenate(parts)


def _rate(look: Look, rating: Rating) -> tuple[Array, NDArray[np.int64]]:
    """Scores, -inf for views that are blocked or empty; and the parts of the room."""
    blocked = (look.seen & (look.depth < NEAR)).mean(axis=(1, 2)) > BLOCKED
    empty = (~look.seen).mean(axis=(1, 2)) > OPEN
    parts = parts_of(look.places, look.seen).reshape(len(look.views), -1)
    return np.where(blocked | empty, -np.inf, rating(look)), parts


def look_of(caster: Caster, views: Views, fov: float, width: int, height: int) -> Look:
    """What views see of a scene, through lenses so many degrees wide, in so many pixels."""
    rays = pixel_directions(intrinsics(fov, width, height), width, height).reshape(-1, 3)
    lengths = np.linalg.norm(rays, axis=1)
    directions = rays @ rotations(views.forwards).swapaxes(1, 2)
    origins = np.repeat(views.eyes, len(rays), axis=0)
    hits = caster.first_hit(origins, directions.reshape(-1, 3))
    shape = len(views), height, width
    seen = hits.hit.reshape(shape)
    distance = np.where(hits.hit, hits.distance, 0.0)
    depth = (distance.reshape(len(views), -1) / lengths).reshape(shape)
    normals = np.zeros((*shape, 3))
    normals[seen] = caster.normals_of(hits.triangle[hits.hit])
    # Towards the eye, whichever way the triangle is wound.
    away = np.einsum("chwi,chwi->chw", normals, directions.reshape(*shape, 3)) > 0
    normals[away] *= -1.0
    places = (origins + distance[:, None] * directions.reshape(-1, 3)).reshape(*shape, 3)
    return Look(views, fov, depth, normals, hits.triangle.reshape(shape), places)
