"""How good views are as photographs of a room: its main things whole, deep, nothing in the way.

Each rule is a share between 0 and 1 that a look at the view gives; the score is their product, so
that one bad fault is enough to come last. `focus_distance` says where such a picture is sharp.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.geometry.looks import Rating, Views, ViewThumbnails, look_of
from openrooms_usd.geometry.pinhole import rotations
from openrooms_usd.geometry.raycast import RayCaster

NO_SUBJECT: Final = -1
"""The subject of triangles of small things, and of what is neither that nor `BARE`."""
BARE: Final = -2
"""The subject of triangles of walls and ceilings: there is nothing to look at."""

# What a view without any subject is worth: rooms without furniture are photographed, too.
_BARE_WORTH: Final = 0.1
# One sofa makes a better picture than six frames: worth grows with this power of weights.
_MAIN_POWER: Final = 1.6
_SHOWN_POWER: Final = 1.5
# How much a subject that is cut loses: its share in the picture to this power.
_WHOLE_POWER: Final = 2.0
# The part of the picture in which a thing counts as whole: it shall not touch the frame.
_FRAME_SHARE: Final = 0.98
# The width of the picture that a subject shall fill for each unit of its weight, and at most.
_WIDTH_SHARE: Final = 0.12
_MAX_WIDTH_SHARE: Final = 0.5
# In front of what counts as seen, metres: its own cushions and blankets.
_BEFORE_M: Final = 0.05
# Nearer than this, metres, things are too large before the lens: a lamp on a desk, the saddle of a
# bicycle. Pictures lose a factor e for each such share of their pixels.
_CLOSE_M: Final = 0.95
_CLOSE_SHARE: Final = 0.03
_FOREGROUND_M: Final = 1.2
_FOREGROUND_SHARE: Final = 0.25
# What stands into the upper part of the picture in less than this share of its median depth stands
# before the rest: a table's edge may be below, a shelf's side may not be beside.
_BEFORE_REST_SHARE: Final = 0.5
_UPPER_SHARE: Final = 0.6
_IN_THE_WAY_SHARE: Final = 0.05
# Of the floor, of the ceiling, of all walls and the ceiling, and of one wall or back of a cupboard:
# more is too much.
_FLOOR_SHARE: Final = 0.35
_CEILING_SHARE: Final = 0.03
_BARE_SHARE: Final = 0.3
_FLAT_SHARE: Final = 0.3
_TOO_MUCH_SHARE: Final = 0.12
_TOO_BARE_SHARE: Final = 0.35
# Steeper than this, a normal is that of a floor.
_LEVEL_COSINE: Final = 0.8
# A picture is full when its subjects fill this share of it, where those of less weight than a main
# one count as much less. Pictures lose a factor e for each such
# share of the frame's edge that cuts through one, by the subject's weight.
_FULL_SHARE: Final = 0.25
_MAIN_WEIGHT: Final = 2.0
_LEAST_FULL: Final = 0.2
_CUT_SHARE: Final = 1.2
# A picture is deep when its median depth is this share of the room's diagonal in plan.
_DEEP_SHARE: Final = 0.3
# A camera stands where people can when at most so much stands on the floor below it, metres.
_FOOTING_M: Final = 0.2
_NO_FOOTING_WORTH: Final = 0.4

_RESOLUTION: Final = (80, 60)
# The middle of a picture, out of its width and height.
_MIDDLE_SHARE: Final = 0.25
# Anything that fills less of a picture is not a subject.
_LEAST_SUBJECT_SHARE: Final = 0.01


@dataclass(frozen=True, eq=False)
class Subjects:
    """What a room is photographed for.

    Attributes:
        points: (K, P, 3) points on the surface of each, metres.
        weights: (K,) how much each matters.
        of_triangle: (M,) the subject of each of the caster's triangles, or `NO_SUBJECT`, or `BARE`.
    """

    points: Array
    weights: Array
    of_triangle: NDArray[np.int32]


def photographic_rating(
    caster: RayCaster, subjects: Subjects, *, floor: float, diagonal: float
) -> Rating:
    """How good views are as photographs.

    Args:
        caster: The room with all that stands in it.
        subjects: What is worth being seen.
        floor: Height of the floor, metres.
        diagonal: Of the room in plan, metres.
    """

    def rating(look: ViewThumbnails) -> Array:
        return np.asarray(
            _visible_shares(caster, subjects, look)
            * _full(subjects, look)
            * _uncluttered(look)
            * _not_bare(subjects, look)
            * np.sqrt(np.clip(_median_depth(look) / (_DEEP_SHARE * diagonal), 0.05, 1.0))
            * np.where(_has_footing(caster, look, floor), 1.0, _NO_FOOTING_WORTH)
        )

    return rating


def _visible_shares(caster: RayCaster, subjects: Subjects, look: ViewThumbnails) -> Array:
    """(C,) how much of the subjects is whole and unhidden in each picture, by their weights."""
    if not subjects.weights.sum() > 0.0:
        return np.ones(len(look.views))
    worth = subjects.weights**_MAIN_POWER
    worth /= worth.sum()
    eyes, axes = look.views.eyes, rotations(look.views.forwards)
    rays = subjects.points[None] - eyes[:, None, None]  # (C, K, P, 3)
    x, y, z = np.moveaxis(np.einsum("ckpi,cij->ckpj", rays, axes), -1, 0)
    rows, columns = look.depth.shape[1:]
    half = np.tan(np.radians(0.5 * look.fov_degrees)) * _FRAME_SHARE
    within = (z > 0.0) & (np.abs(x) < half * z) & (np.abs(y) < half * rows / columns * z)
    view, subject, _ = at = np.nonzero(within)
    distance = np.linalg.norm(rays[at], axis=1)
    hits = caster.first_hit(eyes[view], rays[at] / np.maximum(distance, 1e-9)[:, None])
    # Its own front hides nothing of a thing.
    own = hits.hit & (subjects.of_triangle[hits.triangle] == subject)
    seen = np.zeros_like(within)
    seen[at] = own | ~hits.hit | (hits.distance > distance - _BEFORE_M)
    whole = within.mean(axis=2) ** _WHOLE_POWER
    open_share = seen.sum(axis=2) / np.maximum(within.sum(axis=2), 1)
    across = np.where(within, x / np.where(within, z, 1.0), np.nan)
    width = _extent(across) / (2.0 * half)
    wanted = np.minimum(_WIDTH_SHARE * subjects.weights, _MAX_WIDTH_SHARE)
    large = np.sqrt(np.clip(width / np.maximum(wanted, 1e-9), 0.0, 1.0))
    return np.asarray((_BARE_WORTH + (whole * open_share**2 * large) @ worth) ** _SHOWN_POWER)


def _extent(values: Array) -> Array:
    """(...) from the least to the greatest of (..., P), those that are not numbers left out."""
    known = np.isfinite(values)
    high = np.where(known, values, -np.inf).max(axis=-1)
    low = np.where(known, values, np.inf).min(axis=-1)
    return np.where(known.any(axis=-1), high - low, 0.0)


def _full(subjects: Subjects, look: ViewThumbnails) -> Array:
    """(C,) much of the picture shows subjects, and its frame cuts through few of them."""
    subject = np.where(look.seen, subjects.of_triangle[look.triangles], NO_SUBJECT)
    # The last weights are those of `BARE` and `NO_SUBJECT`.
    weights = np.append(subjects.weights, [0.0, 0.0])
    filled = np.minimum(weights[subject] / _MAIN_WEIGHT, 1.0).mean(axis=(1, 2))
    edge = np.concatenate(
        [subject[:, 0], subject[:, -1], subject[:, :, 0], subject[:, :, -1]], axis=1
    )
    cut = weights[edge].mean(axis=1)
    full = np.sqrt(np.clip(filled / _FULL_SHARE, _LEAST_FULL, 1.0))
    return np.asarray(full * np.exp(-cut / _CUT_SHARE))


def _uncluttered(look: ViewThumbnails) -> Array:
    """(C,) little of the picture is taken by what is right before the lens."""
    close = (look.seen & (look.depth < _CLOSE_M)).mean(axis=(1, 2))
    foreground = (look.seen & (look.depth < _FOREGROUND_M)).mean(axis=(1, 2))
    upper = slice(round(_UPPER_SHARE * look.depth.shape[1]))
    before = look.depth < _BEFORE_REST_SHARE * _median_depth(look)[:, None, None]
    in_the_way = (look.seen & before)[:, upper].mean(axis=(1, 2))
    return np.asarray(
        np.exp(
            -close / _CLOSE_SHARE - foreground / _FOREGROUND_SHARE - in_the_way / _IN_THE_WAY_SHARE
        )
    )


def _not_bare(subjects: Subjects, look: ViewThumbnails) -> Array:
    """(C,) neither floor, walls and ceiling nor one upright plane fill the picture."""
    bare = (look.seen & (subjects.of_triangle[look.triangles] == BARE)).mean(axis=(1, 2))
    floor = (look.normals[..., 2] > _LEVEL_COSINE).mean(axis=(1, 2))
    ceiling = (look.normals[..., 2] < -_LEVEL_COSINE).mean(axis=(1, 2))
    return np.asarray(
        _bearable(floor, _FLOOR_SHARE)
        * _bearable(ceiling, _CEILING_SHARE)
        * _bearable(bare, _BARE_SHARE, _TOO_BARE_SHARE)
        * _bearable(_largest_plane(look), _FLAT_SHARE)
    )


def _bearable(share: Array, most: float, step: float = _TOO_MUCH_SHARE) -> Array:
    return np.asarray(np.exp(-np.clip((share - most) / step, 0.0, None)))


def _largest_plane(look: ViewThumbnails) -> Array:
    """(C,) the share of the pixels that see one and the same upright plane."""
    upright = look.seen & (np.abs(look.normals[..., 2]) < 1.0 - _LEVEL_COSINE)
    turn = np.round(np.arctan2(look.normals[..., 1], look.normals[..., 0]) / np.radians(15.0))
    away = np.round(np.einsum("chwi,chwi->chw", look.normals, look.places) / 0.1)
    key = np.where(upright, turn * 1e6 + away, np.nan).reshape(len(look.views), -1)
    # Of numbers in order, equal ones are runs.
    ordered = np.sort(key, axis=1)
    new = np.ones(ordered.shape, dtype=np.bool_)
    new[:, 1:] = ordered[:, 1:] != ordered[:, :-1]
    start = np.maximum.accumulate(np.where(new, np.arange(ordered.shape[1]), 0), axis=1)
    runs = np.where(np.isnan(ordered), 0, np.arange(ordered.shape[1]) - start + 1)
    return np.asarray(runs.max(axis=1) / ordered.shape[1])


def _median_depth(look: ViewThumbnails) -> Array:
    return np.asarray(np.median(look.depth.reshape(len(look.views), -1), axis=1))


def _has_footing(caster: RayCaster, look: ViewThumbnails, floor: float) -> Mask:
    """(C,) whether a person could stand below the camera."""
    eyes = look.views.eyes
    below = caster.first_hit(eyes, np.tile([0.0, 0.0, -1.0], (len(eyes), 1)))
    return np.asarray(~below.hit | (eyes[:, 2] - below.distance < floor + _FOOTING_M))


def focus_distance(
    caster: RayCaster,
    eye: Array,
    forward: Array,
    fov_degrees: float,
    subjects: Subjects | None = None,
) -> float:
    """Metres along the optical axis to what a photographer would focus on; 0 where nothing is.

    Args:
        caster: The scene.
        eye: (3,) where the camera stands, metres.
        forward: (3,) unit viewing direction.
        fov_degrees: Horizontal field of view.
        subjects: What the scene is photographed for; the middle of the picture where it shows none.
    """
    look = look_of(caster, Views(eye[None], forward[None]), fov_degrees, *_RESOLUTION)
    depth, seen = look.depth[0], look.seen[0]
    rows, columns = (
        slice(round(n * (0.5 - _MIDDLE_SHARE / 2)), round(n * (0.5 + _MIDDLE_SHARE / 2)))
        for n in depth.shape
    )
    middle = np.zeros_like(seen)
    middle[rows, columns] = True
    choices = (_of_subject(subjects, look), middle, seen)
    at = next((seen & choice for choice in choices if (seen & choice).any()), seen)
    return float(np.median(depth[at])) if at.any() else 0.0


def _of_subject(subjects: Subjects | None, look: ViewThumbnails) -> Mask:
    """(H, W) where the picture shows the subject that fills most of it, by its weight."""
    if subjects is None or not len(subjects.weights):
        return np.zeros_like(look.seen[0])
    subject = np.where(look.seen[0], subjects.of_triangle[look.triangles[0]], NO_SUBJECT)
    share = np.array([(subject == row).mean() for row in range(len(subjects.weights))])
    worth = np.where(share < _LEAST_SUBJECT_SHARE, 0.0, share * subjects.weights)
    return np.asarray((subject == worth.argmax()) & (worth.max() > 0.0))
