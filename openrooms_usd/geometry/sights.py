"""What views see of a room: which parts of it, and which places that somebody wants to see."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.pinhole import rotations
from openrooms_usd.geometry.raycast import Caster

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

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
class Sights:
    """What each of C views sees.

    Attributes:
        parts: (C, P) which parts of the room.
        places: (C, K) which places.
    """

    parts: Flags
    places: Flags

    def __getitem__(self, rows: NDArray[np.int64]) -> "Sights":
        return Sights(self.parts[rows], self.places[rows])

    def news(self, known: NDArray[np.int64]) -> Array:
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


def parts_of(points: Array, seen: Flags) -> NDArray[np.int64]:
    """(...) the numbers of the parts that points (..., 3) lie in; `NOTHING` where not seen."""
    x, y, z = np.moveaxis(np.floor(points / _PART_M).astype(np.int64) + _PARTS // 2, -1, 0)
    return np.where(seen, (x * _PARTS + y) * _PARTS + z, NOTHING)


def sights_of(parts: NDArray[np.int64], places: Flags) -> Sights:
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
) -> Flags:
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
