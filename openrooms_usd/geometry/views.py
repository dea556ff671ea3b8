"""View selection as the OpenRooms paper does it: many views along the walls, the best are kept.

Eyes are sampled along the walls, looking at the room's centre; each view is scored from a quick
cast of depth and normals (OpenRooms, CVPR 2021, section 3, "views"); the ranges of height, distance
and angles are those of the released sampler. The N best that differ are kept.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.geometry.curves import signed_area
from openrooms_usd.geometry.floorplan import inside, room_centre
from openrooms_usd.geometry.pinhole import intrinsics, pixel_directions, rotations
from openrooms_usd.geometry.raycast import RayCaster

Array = NDArray[np.float64]

YAW: Final = 45.0  # degrees to either side of the centre
PITCH: Final = (-60.0, 20.0)  # degrees above the horizon
CLEARANCE: Final = 0.2  # metres between an eye and any surface

NEAR: Final = 0.4  # what is nearer than this, in metres, blocks the view
BLOCKED: Final = 0.1  # largest fraction of pixels that may be blocked
OPEN: Final = 0.5  # largest fraction of pixels that may see nothing

# Pictures of the first look at all candidates, and of the second at the best of them.
FIRST_LOOK: Final = (40, 30)
SECOND_LOOK: Final = (160, 120)

# How different two views are: these distances, in these units, added up.
APART: Final = 1.0  # metres
TURNED: Final = 40.0  # degrees

# How different the chosen views shall be; the next number where too few are.
SEPARATIONS: Final = (2.0, 1.5, 1.0, 0.5, 0.25, 0.0)


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
    caster: RayCaster, views: Views, count: int, *, fov_degrees: float, aspect: float = 4.0 / 3.0
) -> Views:
    """The best views that differ from each other, best first.

    Args:
        caster: The room with all that stands in it.
        views: The candidates.
        count: How many to keep; fewer come back where there are fewer good candidates.
        fov_degrees: Horizontal field of view.
        aspect: Width over height of the pictures.
    """
    free = views[clear(caster, views.eyes)]
    first = rate_views(caster, free, fov_degrees, _look(FIRST_LOOK, aspect))
    best = _ranked(first)[: max(3 * count, 32)]
    short = free[best]
    second = rate_views(caster, short, fov_degrees, _look(SECOND_LOOK, aspect))
    return short[differing(short, second, count)]


def clear(caster: RayCaster, eyes: Array, clearance: float = CLEARANCE) -> NDArray[np.bool_]:
    """(C,) which points have no surface within the clearance and are not inside a solid."""
    around = sphere_directions(64)
    origins = np.repeat(eyes, len(around), axis=0)
    directions = np.tile(around, (len(eyes), 1))
    hits = caster.first_hit(origins, directions)
    near = (hits.distance < clearance).reshape(-1, len(around)).any(axis=1)
    normals = caster.normals[hits.triangle] if len(caster.normals) else np.zeros_like(directions)
    from_behind = hits.hit & (np.einsum("ij,ij->i", normals, directions) > 0)
    inner = from_behind.reshape(-1, len(around)).mean(axis=1) > 0.5
    return np.asarray(~near & ~inner)


def rate_views(
    caster: RayCaster, views: Views, fov_degrees: float, resolution: tuple[int, int]
) -> Array:
    """(C,) score of each view by a cast of its pixels; -inf for blocked or empty ones.

    Args:
        caster: The scene.
        views: The views.
        fov_degrees: Horizontal field of view.
        resolution: Width and height of the pictures that are cast.
    """
    rated = [
        _rate(caster, views[start : start + 32], fov_degrees, *resolution)
        for start in range(0, len(views), 32)
    ]
    return np.concatenate([np.zeros(0), *rated])


def _rate(caster: RayCaster, views: Views, fov: float, width: int, height: int) -> Array:
    rays = pixel_directions(intrinsics(fov, width, height), width, height).reshape(-1, 3)
    lengths = np.linalg.norm(rays, axis=1)
    directions = rays @ rotations(views.forwards).swapaxes(1, 2)
    origins = np.repeat(views.eyes, len(rays), axis=0)
    hits = caster.first_hit(origins, directions.reshape(-1, 3))
    shape = len(views), height, width
    seen = hits.hit.reshape(shape)
    distance = np.where(hits.hit, hits.distance, 0.0).reshape(len(views), -1)
    depth = (distance / lengths).reshape(shape)
    normals = np.zeros((*shape, 3))
    normals[seen] = caster.normals[hits.triangle[hits.hit]]
    # Towards the eye, whichever way the triangle is wound.
    away = np.einsum("chwi,chwi->chw", normals, directions.reshape(*shape, 3)) > 0
    normals[away] *= -1.0
    blocked = (seen & (depth < NEAR)).mean(axis=(1, 2)) > BLOCKED
    empty = (~seen).mean(axis=(1, 2)) > OPEN
    return np.where(blocked | empty, -np.inf, score(normals, depth))


def differing(views: Views, scores: Array, count: int) -> NDArray[np.int64]:
    """Rows of the best views, each apart from all better ones.

    Greedy; where too few are apart, less and less distance is asked for until there are enough.
    Views with a score of -inf are never taken.
    """
    order = _ranked(scores)
    chosen: list[int] = []
    for apart in SEPARATIONS:
        for row in order:
            if len(chosen) == count:
                break
            if row not in chosen and _separation(views, row, chosen) >= apart:
                chosen.append(int(row))
    return np.array(sorted(chosen, key=lambda row: -scores[row]), dtype=np.int64)


def _separation(views: Views, row: int, others: list[int]) -> float:
    """How different a view is from the most similar of the others."""
    if not others:
        return np.inf
    moved = np.linalg.norm(views.eyes[others] - views.eyes[row], axis=1)
    cosines = np.clip(views.forwards[others] @ views.forwards[row], -1.0, 1.0)
    return float((moved / APART + np.degrees(np.arccos(cosines)) / TURNED).min())


def _ranked(scores: Array) -> NDArray[np.int64]:
    """Rows from the best to the worst, without those that are out of the question."""
    order = np.argsort(-scores, kind="stable")
    return order[scores[order] > -np.inf]


def _look(resolution: tuple[int, int], aspect: float) -> tuple[int, int]:
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
