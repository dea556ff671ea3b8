"""How much of an outline's walls was scanned, and the residuals of their surfels."""

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.rooms.outline import Outline
from openrooms_usd.scan.rooms.walls import Walls, profile

Array = NDArray[np.float64]


def seen_shares(outline: Outline, walls: Walls) -> Array:
    """(N,) the part of each wall with vertical surfels."""
    corners = outline.corners()
    seen = np.zeros(len(outline))
    for i, (start, end) in enumerate(zip(corners, np.roll(corners, -1, axis=0), strict=True)):
        line = profile(walls, outline.normals[i], float(outline.offsets[i]))
        seen[i] = line.seen_length(start @ line.along, end @ line.along) / np.linalg.norm(
            end - start
        )
    return seen


def covered_lengths(outline: Outline, walls: Walls) -> Array:
    """(N,) metres of each wall with surfels that count as wall."""
    corners = outline.corners()
    found = np.zeros(len(outline))
    for i, (start, end) in enumerate(zip(corners, np.roll(corners, -1, axis=0), strict=True)):
        line = profile(walls, outline.normals[i], float(outline.offsets[i]))
        found[i] = line.covered(start @ line.along, end @ line.along)
    return found


def residuals(outline: Outline, walls: Walls) -> Array:
    """(P,) signed distances of surfels to their walls, outwards, metres."""
    starts = outline.corners()
    ends = np.roll(starts, -1, axis=0)
    found = []
    for normal, offset, start, end in zip(
        outline.normals, outline.offsets, starts, ends, strict=True
    ):
        along = np.array([-normal[1], normal[0]])
        place, across = walls.points @ along, walls.points @ normal - offset
        on = (place > start @ along) & (place < end @ along) & (np.abs(across) < walls.reach)
        found.append(across[on])
    return np.concatenate(found)
