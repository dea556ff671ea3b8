"""How far an outline is borne out by what was seen of its walls."""

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.rooms.outline import Outline
from openrooms_usd.scan.rooms.walls import Walls, profile

Array = NDArray[np.float64]


def shown_parts(outline: Outline, walls: Walls) -> Array:
    """(N,) the part of each wall that was seen."""
    corners = outline.corners()
    shown = np.zeros(len(outline))
    for i, (start, end) in enumerate(zip(corners, np.roll(corners, -1, axis=0), strict=True)):
        line = profile(walls, outline.normals[i], float(outline.offsets[i]))
        shown[i] = line.shown(start @ line.along, end @ line.along) / np.linalg.norm(end - start)
    return shown


def covered_lengths(outline: Outline, walls: Walls) -> Array:
    """(N,) along how many metres of each wall something stands that counts as wall."""
    corners = outline.corners()
    found = np.zeros(len(outline))
    for i, (start, end) in enumerate(zip(corners, np.roll(corners, -1, axis=0), strict=True)):
        line = profile(walls, outline.normals[i], float(outline.offsets[i]))
        found[i] = line.covered(start @ line.along, end @ line.along)
    return found


def distances(outline: Outline, walls: Walls) -> Array:
    """(P,) metres from each wall to its pieces, outwards."""
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
