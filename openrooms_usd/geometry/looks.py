"""Upright views, small pictures of them, what of a room these show, and how good they are."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.geometry.pinhole import intrinsics, pixel_directions, rotations
from openrooms_usd.geometry.raycast import Caster

NEAR: Final = 0.4  # what is nearer than this, in metres, blocks the view
BLOCKED: Final = 0.1  # largest fraction of pixels that may be blocked
OPEN: Final = 0.5  # largest fraction of pixels that may see nothing

NOTHING: Final = -1
"""The number of the part that a pixel sees which sees nothing."""

# Sides of the parts that a room is counted in, metres: a chair is one or two of them.
_PART_M: Final = 0.5
# Numbers of parts along each axis: rooms of a kilometre.
_PARTS: Final = 1 << 20
# What may be before a place that still counts as seen, metres: leaves, frames, curtains.
_BEFORE_M: Final = 0.3
# The middle part of a picture in which a place counts as seen.
_WELL_INSIDE_SHARE: Final = 0.9


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

    def __getitem__(self, rows: Ints | Mask | slice) -> "Views":
        return Views(self.eyes[rows], self.forwards[rows])

    def poses(self) -> Array:
        """(C, 4, 4) world_from_camera, OpenCV frame."""
        poses = np.tile(np.eye(4), (len(self), 1, 1))
        poses[:, :3, :3], poses[:, :3, 3] = rotations(self.forwards), self.eyes
        return poses


@dataclass(frozen=True, eq=False)
class ViewThumbnails:
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
    def seen(self) -> Mask:
        """(C, H, W) whether anything is seen."""
        return self.triangles >= 0


Rating = Callable[[ViewThumbnails], Array]
"""(C,) how good views are, from a look at them."""


def rated(
    caster: Caster, views: Views, fov: float, resolution: tuple[int, int], rating: Rating
) -> tuple[Array, Ints]:
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


def _rate(look: ViewThumbnails, rating: Rating) -> tuple[Array, Ints]:
    """Scores, -inf for views that are blocked or empty; and the parts of the room."""
    blocked = (look.seen & (look.depth < NEAR)).mean(axis=(1, 2)) > BLOCKED
    empty = (~look.seen).mean(axis=(1, 2)) > OPEN
    parts = parts_of(look.places, look.seen).reshape(len(look.views), -1)
    return np.where(blocked | empty, -np.inf, rating(look)), parts


def look_of(caster: Caster, views: Views, fov: float, width: int, height: int) -> ViewThumbnails:
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
    return ViewThumbnails(views, fov, depth, normals, hits.triangle.reshape(shape), places)


@dataclass(frozen=True, eq=False)
class Sights:
    """What each of C views sees.

    Attributes:
        parts: (C, P) which parts of the room.
        places: (C, K) which places.
    """

    parts: Mask
    places: Mask

    def __getitem__(self, rows: Ints) -> "Sights":
        return Sights(self.parts[rows], self.places[rows])

    def news(self, known: Ints) -> Array:
        """(C,) how much of the room a view shows that some others do not.

        The share of all parts that are new in it, and as much for the places, where there are any.

        Args:
            known: Rows of the others.
        """
        shares = []
        for seen in (self.parts, self.places):
            new = seen & ~seen[known].any(axis=0)
            shares.append(new.sum(axis=1) / max(int(seen.any(axis=0).sum()), 1))
        return np.asarray(shares[0] + shares[1])


def parts_of(points: Array, seen: Mask) -> Ints:
    """(...) the numbers of the parts that points (..., 3) lie in; `NOTHING` where not seen."""
    x, y, z = np.moveaxis(np.floor(points / _PART_M).astype(np.int64) + _PARTS // 2, -1, 0)
    return np.where(seen, (x * _PARTS + y) * _PARTS + z, NOTHING)


def sights_of(parts: Ints, places: Mask) -> Sights:
    """What views see, from the parts (C, N) in their pixels and the places (C, K) in them."""
    known, rows = np.unique(parts, return_inverse=True)
    seen = np.zeros((len(parts), len(known)), dtype=np.bool_)
    seen[np.arange(len(parts))[:, None], rows.reshape(parts.shape)] = True
    return Sights(seen[:, known != NOTHING], places)


def visible(
    caster: Caster,
    eyes: Array,
    forwards: Array,
    places: Array,
    *,
    fov_degrees: float,
    aspect: float,
) -> Mask:
    """(C, K) which places are in which pictures, with nothing far before them.

    Args:
        caster: The scene.
        eyes: (C, 3) metres.
        forwards: (C, 3) unit viewing directions of upright cameras.
        places: (K, 3) metres.
        fov_degrees: Horizontal field of view.
        aspect: Width over height of the pictures.
    """
    rays = places - eyes[:, None]
    distance = np.linalg.norm(rays, axis=-1)
    x, y, z = np.moveaxis(rays @ rotations(forwards), -1, 0)
    half = np.tan(np.radians(0.5 * fov_degrees)) * _WELL_INSIDE_SHARE
    inside = (z > 0.0) & (np.abs(x) < half * z) & (np.abs(y) < half / aspect * z)
    view, place = np.nonzero(inside)
    far = distance[view, place]
    hits = caster.first_hit(eyes[view], rays[view, place] / far[:, None])
    inside[view, place] = ~hits.hit | (hits.distance > far - _BEFORE_M)
    return np.asarray(inside)
