"""View selection as the OpenRooms paper does it: many views along the walls, the best are kept.

Eyes are sampled along the walls, looking at the room's centre. Each view is scored from a quick
cast of depth and normals (OpenRooms, CVPR 2021, section 3, "views"). The ranges of height, distance
and angles are those of the released sampler. The best is kept, and then, one by one, those that are
good and show what the others do not: parts of the room, and its openings. So several views cover a
room, and do not all look into its most furnished corner.
"""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.curves import signed_area
from openrooms_usd.geometry.floorplan import inside, room_centre
from openrooms_usd.geometry.looks import (
    Rating,
    Sights,
    Views,
    ViewThumbnails,
    rated,
    sights_of,
    visible,
)
from openrooms_usd.geometry.raycast import Caster

YAW: Final = 45.0  # degrees to either side of the centre
PITCH: Final = (-60.0, 20.0)  # degrees above the horizon
CLEARANCE: Final = 0.2  # metres between an eye and any surface

# Pictures of the first look at all candidates, and of the second at the best of them.
FIRST_LOOK: Final = (32, 24)
SECOND_LOOK: Final = (80, 60)

# How different two views are: these distances, in these units, added up.
APART: Final = 1.0  # metres
TURNED: Final = 40.0  # degrees

# Share of a room of which less is nothing new.
_LITTLE_NEW: Final = 0.02

# How different the chosen views shall be; the next number where too few are.
SEPARATIONS: Final = (2.0, 1.5, 1.0, 0.5, 0.25, 0.0)


def score(normals: ArrayLike, depth: ArrayLike) -> Array:
    """How much there is to see: sum of |grad n| + 0.3 sum of log(depth + 1), over all pixels.

    The gradient is the absolute difference of neighbours, in both directions and all three
    channels.

    Args:
        normals: (..., H, W, 3) unit normals; 0 where nothing is seen.
        depth: (..., H, W) planar depth, metres; 0 where nothing is seen.

    Returns:
        (...) scores.
    """
    n, d = np.asarray(normals, dtype=np.float64), np.asarray(depth, dtype=np.float64)
    across = np.abs(np.diff(n, axis=-2)).sum(axis=(-3, -2, -1))
    down = np.abs(np.diff(n, axis=-3)).sum(axis=(-3, -2, -1))
    return np.asarray(across + down + 0.3 * np.log1p(d).sum(axis=(-2, -1)))


def sample_views(
    polygon: ArrayLike,
    floor: float,
    count: int,
    rng: np.random.Generator,
    *,
    height: tuple[float, float] = (1.4, 1.8),
    distance: tuple[float, float] = (0.3, 1.5),
) -> Views:
    """Views along the walls that face the room's centre, give or take; none outside the polygon.

    Args:
        polygon: (P, 2) corners of the floor, metres, either way round.
        floor: Height of the floor, metres.
        count: How many to draw; those that fall outside the polygon are left out.
        rng: Draws them.
        height: Range of heights above the floor, metres.
        distance: Range of distances from the wall, metres.
    """
    corners = np.asarray(polygon, dtype=np.float64)
    sides = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(sides, axis=1)
    if not lengths.sum() > 0:
        raise InputError("the floor polygon has no sides")
    inward = np.stack([-sides[:, 1], sides[:, 0]], axis=1) / np.maximum(lengths, 1e-12)[:, None]
    inward *= np.sign(signed_area(corners - corners[0]))
    # Stratified along the perimeter: every wall gets its share, also with few candidates.
    at = (np.arange(count) + rng.random(count)) / count * lengths.sum()
    wall = np.minimum(np.searchsorted(np.cumsum(lengths), at), len(corners) - 1)
    along = (at - (np.cumsum(lengths) - lengths)[wall]) / lengths[wall]
    away = rng.uniform(*distance, count)
    plan = corners[wall] + along[:, None] * sides[wall] + away[:, None] * inward[wall]
    eyes = np.column_stack([plan, floor + rng.uniform(*height, count)])
    to_centre = room_centre(corners) - plan
    yaw = np.arctan2(to_centre[:, 1], to_centre[:, 0]) + np.radians(rng.uniform(-YAW, YAW, count))
    # Uniform in the sine, so that directions are uniform on the sphere.
    lowest, highest = np.sin(np.radians(PITCH)).tolist()
    rise = rng.uniform(lowest, highest, count)
    level = np.sqrt(1.0 - rise**2)
    forwards = np.column_stack([level * np.cos(yaw), level * np.sin(yaw), rise])
    return Views(eyes, forwards)[inside(corners, plan)]


def select_views(
    caster: Caster,
    views: Views,
    count: int,
    *,
    fov_degrees: float,
    aspect: float = 4.0 / 3.0,
    places: Array | None = None,
    rating: Rating | None = None,
    spare: int = 0,
) -> Views:
    """The best views that differ from each other and together show the room, best first.

    Args:
        caster: The room with all that stands in it.
        views: The candidates.
        count: How many to keep; fewer come back where there are fewer good candidates.
        fov_degrees: Horizontal field of view.
        aspect: Width over height of the pictures.
        places: (K, 3) what shall be seen besides, such as the middles of openings; metres.
        rating: How good views are; by default as the paper has it.
        spare: How many more to keep; they come last, in the order in which they would be taken.
    """
    wanted = np.zeros((0, 3)) if places is None else places
    short = views[clear(caster, views.eyes)]
    for look, keep, more in ((FIRST_LOOK, max(3 * count, 32), 0), (SECOND_LOOK, count, spare)):
        scores, parts = rated(
            caster, short, fov_degrees, _shaped(look, aspect), rating or paper_scores
        )
        where = short.eyes, short.forwards
        seen = visible(caster, *where, wanted, fov_degrees=fov_degrees, aspect=aspect)
        short = short[differing(short, scores, keep, sights_of(parts, seen), more)]
    return short


def clear(caster: Caster, eyes: Array, clearance: float = CLEARANCE) -> Mask:
    """(C,) which points have no surface within the clearance and are not inside a solid."""
    around = sphere_directions(64)
    origins = np.repeat(eyes, len(around), axis=0)
    directions = np.tile(around, (len(eyes), 1))
    hits = caster.first_hit(origins, directions)
    near = (hits.distance < clearance).reshape(-1, len(around)).any(axis=1)
    normals = caster.normals_of(hits.triangle)
    from_behind = hits.hit & (np.einsum("ij,ij->i", normals, directions) > 0)
    inner = from_behind.reshape(-1, len(around)).mean(axis=1) > 0.5
    return np.asarray(~near & ~inner)


def rate_views(
    caster: Caster, views: Views, fov_degrees: float, resolution: tuple[int, int]
) -> Array:
    """(C,) score of each view by a cast of its pixels; -inf for blocked or empty ones.

    Args:
        caster: The scene.
        views: The views.
        fov_degrees: Horizontal field of view.
        resolution: Width and height of the pictures that are cast.
    """
    return rated(caster, views, fov_degrees, resolution, paper_scores)[0]


def paper_scores(look: ViewThumbnails) -> Array:
    """(C,) the score of each view as the paper has it."""
    return score(look.normals, look.depth)


def differing(
    views: Views, scores: Array, count: int, sights: Sights | None = None, spare: int = 0
) -> Ints:
    """Rows of the best views, each apart from all better ones.

    Greedy; where too few are apart, less and less distance is asked for until there are enough.
    Views with a score of -inf are never taken.

    Args:
        views: The views.
        scores: (C,) how good they are.
        count: How many to take.
        sights: What they see: after the best, those count for more that show something new.
        spare: How many more to take, after these and in the order in which they are taken: what is
            taken first is the same with any number of them.
    """
    order = _ranked(scores)
    chosen: list[int] = []
    # What has been shown; all is new again when nothing new is left.
    round_start = 0
    for apart in SEPARATIONS:
        while len(chosen) < count + spare:
            away = _separations(views, chosen)
            rest = order[(away[order] >= apart) & ~np.isin(order, chosen)]
            if not len(rest):
                break
            value = scores[rest]
            if sights is not None and chosen:
                news = sights.news(np.array(chosen[round_start:], dtype=np.int64))[rest]
                if news.max() < _LITTLE_NEW:
                    round_start = len(chosen)
                value = value * news
            chosen.append(int(rest[np.argmax(value)]))
    best = sorted(chosen[:count], key=lambda row: -scores[row])
    return np.array([*best, *chosen[count:]], dtype=np.int64)


def _separations(views: Views, others: list[int]) -> Array:
    """(C,) how different each view is from the most similar of the others."""
    if not others:
        return np.full(len(views), np.inf)
    moved = np.linalg.norm(views.eyes[:, None] - views.eyes[others], axis=2)
    cosines = np.clip(views.forwards @ views.forwards[others].T, -1.0, 1.0)
    return np.asarray((moved / APART + np.degrees(np.arccos(cosines)) / TURNED).min(axis=1))


def _ranked(scores: Array) -> Ints:
    """Rows from the best to the worst, without those that are out of the question."""
    order = np.argsort(-scores, kind="stable")
    return order[scores[order] > -np.inf]


def _shaped(resolution: tuple[int, int], aspect: float) -> tuple[int, int]:
    """The same number of pixels in another shape."""
    pixels = resolution[0] * resolution[1]
    height = max(2, round((pixels / aspect) ** 0.5))
    return max(2, round(pixels / height)), height


def sphere_directions(count: int) -> Array:
    """(count, 3) unit vectors, evenly spread (Fibonacci lattice)."""
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    turn = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    level = np.sqrt(1.0 - z**2)
    return np.stack([level * np.cos(turn), level * np.sin(turn), z], axis=1)
