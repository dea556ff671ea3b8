"""Where people stand with a camera: in corners, in doorways and at walls, holding it level.

Interiors are photographed at chest or eye height with a level camera, so that verticals are
vertical, from where most of the room is before the lens; a wall that is nearly faced is faced
squarely.
"""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.curves import signed_area
from openrooms_usd.geometry.floorplan import inside, room_centre
from openrooms_usd.geometry.looks import Views
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.geometry.views import sample_views

# Degrees above the horizon: a little down, so that it lies above the picture's middle.
PITCH_DEG: Final = (-10.0, -2.0)
# How far from the room's centre people aim, and how far from one of its subjects; degrees to
# either side.
_YAW_DEG: Final = 40.0
_BESIDE_SUBJECT_DEG: Final = 15.0
# Of the candidates, those that aim at one subject.
_AT_SUBJECTS_SHARE: Final = 0.5
# A wall that is faced within so many degrees is faced squarely.
_SQUARE_DEG: Final = 12.0
# Between a camera in a corner and both of its walls, or one in a doorway and the door; metres.
_FROM_CORNER_M: Final = (0.3, 0.8)
# Shares of the candidates by where they stand.
_IN_CORNERS_SHARE: Final = 0.4
_IN_DOORWAYS_SHARE: Final = 0.15
_ALONG_WALLS_SHARE: Final = 0.45


def photographers_views(
    polygon: ArrayLike,
    floor: float,
    count: int,
    rng: np.random.Generator,
    *,
    doorways: Array,
    subjects: Array | None = None,
    height: tuple[float, float] = (1.2, 1.6),
    distance: tuple[float, float] = (0.3, 1.5),
) -> Views:
    """Level views from corners, doorways and walls into the room; none outside the polygon.

    Args:
        polygon: (P, 2) corners of the floor, metres, either way round.
        floor: Height of the floor, metres.
        count: How many to draw; those that fall outside the polygon are left out.
        rng: Draws them.
        doorways: (K, 2 or 3) openings in which people may stand, metres.
        subjects: (S, 2 or 3) the middles of what the room is photographed for, metres.
        height: Range of heights above the floor, metres.
        distance: Range of distances of the others from their wall, metres.

    Raises:
        InputError: The polygon has no sides.
    """
    outline = np.asarray(polygon, dtype=np.float64)
    along_walls = sample_views(outline, floor, count, rng, height=height, distance=distance)
    plan = np.concatenate(
        [
            _in_corners(outline, rng, round(_IN_CORNERS_SHARE * count)),
            _in_doorways(outline, rng, doorways, round(_IN_DOORWAYS_SHARE * count)),
            along_walls.eyes[: round(_ALONG_WALLS_SHARE * count), :2],
        ]
    )
    plan = plan[inside(outline, plan)]
    eyes = np.column_stack([plan, floor + rng.uniform(*height, len(plan))])
    yaw = _squared(_aimed(plan, rng, room_centre(outline), subjects), outline)
    rise = np.radians(rng.uniform(*PITCH_DEG, len(plan)))
    level = np.cos(rise)
    return Views(eyes, np.column_stack([level * np.cos(yaw), level * np.sin(yaw), np.sin(rise)]))


def _in_corners(outline: Array, rng: np.random.Generator, count: int) -> Array:
    """(count, 2) points in the corners, as far from either wall."""
    sides = np.roll(outline, -1, axis=0) - outline
    inward = np.stack([-sides[:, 1], sides[:, 0]], axis=1) * np.sign(signed_area(outline))
    inward /= np.maximum(np.linalg.norm(inward, axis=1, keepdims=True), 1e-12)
    # Of the walls that meet in each corner.
    both = inward + np.roll(inward, 1, axis=0)
    row = np.arange(count) % len(outline)
    return np.asarray(outline[row] + rng.uniform(*_FROM_CORNER_M, (count, 1)) * both[row])


def _in_doorways(outline: Array, rng: np.random.Generator, doorways: Array, count: int) -> Array:
    """(count, 2) points a step into the room from its openings; none where it has none."""
    if not len(doorways):
        return np.zeros((0, 2))
    doors = doorways[np.arange(count) % len(doorways), :2]
    ahead = unit(room_centre(outline) - doors)
    return np.asarray(doors + rng.uniform(*_FROM_CORNER_M, (count, 1)) * ahead)


def _aimed(plan: Array, rng: np.random.Generator, centre: Array, subjects: Array | None) -> Array:
    """(C,) directions in plan, radians: about the room's centre, or about one of its subjects."""
    target, spread = np.tile(centre, (len(plan), 1)), np.full(len(plan), _YAW_DEG)
    if subjects is not None and len(subjects):
        at = np.flatnonzero(rng.random(len(plan)) < _AT_SUBJECTS_SHARE)
        target[at] = subjects[np.arange(len(at)) % len(subjects), :2]
        spread[at] = _BESIDE_SUBJECT_DEG
    x, y = (target - plan).T
    return np.asarray(np.arctan2(y, x) + np.radians(spread * rng.uniform(-1.0, 1.0, len(plan))))


def _squared(yaw: Array, outline: Array) -> Array:
    """Directions, with those that nearly face a wall turned to face it."""
    sides = np.roll(outline, -1, axis=0) - outline
    walls = np.arctan2(sides[:, 1], sides[:, 0])
    faces = np.concatenate([walls + 0.5 * np.pi, walls - 0.5 * np.pi])
    off = (faces - yaw[:, None] + np.pi) % (2.0 * np.pi) - np.pi
    nearest = off[np.arange(len(yaw)), np.abs(off).argmin(axis=1)]
    return np.asarray(yaw + np.where(np.abs(nearest) < np.radians(_SQUARE_DEG), nearest, 0.0))
