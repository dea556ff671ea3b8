"""Depth pictures with the errors of consumer depth cameras.

Noise and disparity steps grow with the square of the distance, returns fail at grazing angles and
on glass, and mirrors show the room a second time.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.scan.rooms import GLASS, MIRROR, Part, SimulatedRoom
from openrooms_usd.arrays import Array, Floats, Ints, Mask
from openrooms_usd.geometry.pinhole import pixel_directions
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.fusion import DepthFrame

SIZE: Final = (640, 480)
FOCAL: Final = 577.0
NEAR: Final = 0.3
# cos of the angle of incidence below which returns begin to fail.
GRAZING: Final = 0.25
# Glass gives no return, but for this part of the rays.
GLINT: Final = 0.08
# Above this height below the ceiling nothing is seen where the ceiling was missed, metres.
CEILING: Final = 0.25


@dataclass(frozen=True)
class Scanner:
    """How a scan is made.

    Attributes:
        frames: Depth frames on the path.
        reduce: Every how many-th pixel of the 640x480 is computed, across and down.
        noise: Factor on noise and disparity steps; 0 turns them off.
        reach: The farthest return, metres.
        drift: The largest error of a pose's place, metres; its turn is in proportion.
        drift_degrees: The largest error of a pose's turn.
        voxel: The edge of a fused cell, metres.
        fewest: Cells with fewer returns are dropped.
        wrong_labels: The part of labels that are wrong.
        ceiling: Whether the ceiling is seen.
        missing_walls: How many walls are not seen: what is on them, and what is behind them.
        blind: How far before those nothing is seen either, metres.
        single: One view instead of a path.
    """

    frames: int = 100
    reduce: int = 3
    noise: float = 1.0
    reach: float = 7.0
    drift: float = 0.0
    drift_degrees: float = 0.0
    voxel: float = 0.016
    fewest: int = 2
    wrong_labels: float = 0.07
    ceiling: bool = True
    missing_walls: int = 0
    blind: float = 0.01
    single: bool = False


class View(NamedTuple):
    """A depth picture, and what is in it.

    Attributes:
        depth: (H, W) planar, metres; 0 where there is no return.
        K: (3, 3) pixels, the top-left pixel's centre at 0.5, 0.5.
        part: (H, W) rows of the room's parts; -1 where there is no return.
    """

    depth: Floats
    K: Array
    part: NDArray[np.int32]

    def frame(self, parts: Sequence[Part], camera: Array) -> DepthFrame:
        """The picture as importers give it, from where the scanner believes that it stood."""
        label, instance = (
            np.array([*(getattr(part, name) for part in parts), 0], dtype=np.int32)[self.part]
            for name in ("label", "instance")
        )
        return DepthFrame(self.depth, self.K, camera, label, instance)


def take(
    room: SimulatedRoom,
    caster: RayCaster,
    camera: Array,
    how: Scanner,
    random: np.random.Generator,
    missed: frozenset[int] = frozenset(),
) -> View:
    """One depth picture from a true pose (4, 4) of the camera, OpenCV axes."""
    width, height = (side // how.reduce for side in SIZE)
    focal = FOCAL / how.reduce
    K = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1.0]])
    rays = pixel_directions(K, width, height).reshape(-1, 3)
    directions = rays @ camera[:3, :3].T
    # Rays that are as long as the camera's z: distances along them are planar depths.
    length = np.linalg.norm(rays, axis=1)
    distance, triangle, cosine = trace(room, caster, camera[:3, 3], directions, random)
    depth = distance / length
    unseen = hidden(room, missed, camera[:3, 3], camera[:3, 3] + depth[:, None] * directions, how)
    kept = (triangle >= 0) & (depth > NEAR) & (depth < how.reach)
    part = np.where(triangle >= 0, room.part[triangle], -1)
    if how.noise:
        kept &= random.random(len(depth)) < np.clip(np.abs(cosine) / GRAZING, 0, 1) ** 1.5
        depth = noisy(depth, how.noise, random)
    walls = np.array([p.wall for p in room.parts])[part]
    kept &= ~(unseen | np.isin(walls, list(missed)))
    shape = (height, width)
    return View(
        np.where(kept, depth, 0.0).reshape(shape).astype(np.float32),
        K,
        np.where(kept, part, -1).reshape(shape).astype(np.int32),
    )


def trace(
    room: SimulatedRoom,
    caster: RayCaster,
    origin: Array,
    directions: Array,
    random: np.random.Generator,
) -> tuple[Array, Ints, Array]:
    """What comes back along rays: through glass mostly nothing, off mirrors the room in them.

    Returns:
        (R,) distance; (R,) triangle that the return is taken for, -1 without one; (R,) the cosine
        of the angle of incidence.
    """
    optics = np.array([part.optics for part in room.parts])[room.part]
    hits = caster.first_hit(origin, directions)
    triangle = hits.triangle.astype(np.int64)
    distance = np.where(triangle >= 0, hits.distance, 0.0)
    units = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    cosine = np.einsum("ij,ij->i", units, caster.normals[triangle])
    kind = np.where(triangle >= 0, optics[triangle], 0)
    glass = np.flatnonzero(kind == GLASS)
    triangle[glass[random.random(len(glass)) > GLINT]] = -1
    mirror = np.flatnonzero(kind == MIRROR)
    if len(mirror):
        normals = caster.normals[triangle[mirror]]
        turned = units[mirror] - 2 * cosine[mirror, None] * normals
        starts = origin + distance[mirror, None] * units[mirror] + 1e-4 * turned
        again = caster.first_hit(starts, turned)
        met = again.triangle >= 0
        distance[mirror[met]] += again.distance[met]
        # The camera takes them for what it sees in the mirror's place.
        triangle[mirror[~met]] = -1
    return distance, triangle, cosine


def noisy(depth: Array, factor: float, random: np.random.Generator) -> Array:
    """Depth with the sensor's noise, then rounded to its disparity steps of 0.0014 z^2 metres."""
    sigma = factor * depth_sigma(depth)
    shaken = np.maximum(depth + sigma * random.standard_normal(len(depth)), NEAR / 2)
    # A step of the disparity q is one of q z^2 in depth.
    step = factor * 0.0014
    return np.asarray(1.0 / (np.maximum(np.round(1.0 / (shaken * step)), 1.0) * step))


def depth_sigma(depth: Array) -> Array:
    """Standard deviation of depth noise, metres."""
    return np.asarray(0.0012 + 0.0019 * (depth - 0.4) ** 2)


def hidden(
    room: SimulatedRoom, missed: frozenset[int], origin: Array, points: Array, how: Scanner
) -> Mask:
    """(R,) whether returns are of the ceiling, or beyond walls, that the scan shall not show."""
    found = np.zeros(len(points), dtype=np.bool_)
    layout = room.truth.rooms[0]
    if not how.ceiling and layout.ceiling is not None:
        found |= points[:, 2] > layout.corners[0, 2] + layout.ceiling - CEILING
    for wall in missed:
        a, b = room.floor[wall], room.floor[(wall + 1) % len(room.floor)]
        along = (b - a) / np.linalg.norm(b - a)
        across = np.array([along[1], -along[0]])
        away, before = (points[:, :2] - a) @ across, (origin[:2] - a) @ across
        # Where the ray goes through the wall; else where it ends.
        crossing = np.clip(before / np.minimum(before - away, -1e-9), 0.0, 1.0)
        run = (origin[:2] + crossing[:, None] * (points[:, :2] - origin[:2]) - a) @ along
        within = (run > 0) & (run < np.linalg.norm(b - a)) & (before < 0)
        found |= within & (away > -how.blind)
    return found


def returns(view: View, camera: Array) -> tuple[Array, Ints, Array]:
    """Points of a picture: (P, 3) places, (P,) parts, (P, 3) unit directions to the camera."""
    height, width = view.depth.shape
    rays = pixel_directions(view.K, width, height)
    rows = view.depth > 0
    local = rays[rows] * view.depth[rows, None].astype(np.float64)
    turned = local @ camera[:3, :3].T
    back = -turned / np.linalg.norm(turned, axis=1, keepdims=True)
    return turned + camera[:3, 3], view.part[rows].astype(np.int64), back


# Wrong labels, as segmentation networks give them: in blobs, and at the borders of things.

# Which part of the wrong labels lies at borders; there, how far a label spreads, metres.
BORDERS: Final = 0.4
SPREAD: Final = (0.02, 0.06)
# Elsewhere the radius of a blob, metres.
BLOB: Final = (0.05, 0.25)
# One blob in two takes the label of any thing of the room, the others that of the next thing.
FOREIGN: Final = 0.5
NEIGHBOURS: Final = 24
# Borders are looked for around so many points.
TRIED: Final = 50_000


def spoiled(cloud: Cloud, wrong: float, random: np.random.Generator) -> Cloud:
    """The cloud with a part of its labels wrong, and instances with them.

    Args:
        cloud: With labels and instances.
        wrong: The part of points whose label or instance is not the true one.
        random: Decides which.
    """
    from scipy.spatial import cKDTree

    if cloud.label is None or cloud.instance is None or not wrong or len(cloud) <= NEIGHBOURS:
        return cloud
    true = cloud.label.astype(np.int64) << 32 | cloud.instance.astype(np.int64)
    if (true == true[0]).all():
        return cloud
    tree, source = cKDTree(cloud.points), np.arange(len(cloud))
    _at_borders(source, true, tree, BORDERS * wrong, random)
    _in_blobs(source, true, tree, wrong, random)
    return replace(cloud, label=cloud.label[source], instance=cloud.instance[source])


def _at_borders(
    source: Ints, true: Ints, tree: Any, wrong: float, random: np.random.Generator
) -> None:
    """Let things spread over their borders; changes ``source``, whose label each point takes."""
    tried = random.permutation(len(true))[:TRIED]
    near = tree.query(tree.data[tried], k=NEIGHBOURS)[1]
    differs = true[near] != true[tried, None]
    bad = 0
    for row in np.flatnonzero(differs.any(axis=1)):
        if bad >= wrong * len(true):
            return
        other = near[row, differs[row].argmax()]
        bad += _paint(source, true, tree, other, tried[row], random.uniform(*SPREAD))


def _in_blobs(
    source: Ints, true: Ints, tree: Any, wrong: float, random: np.random.Generator
) -> None:
    bad, tries = int((true[source] != true).sum()), 0
    while bad < wrong * len(true) and tries < 10_000:
        tries += 1
        centre, other = random.integers(len(true), size=2)
        radius = random.uniform(*BLOB)
        if random.random() > FOREIGN:
            near = np.sort(tree.query_ball_point(tree.data[centre], 2 * radius))
            others = near[true[near] != true[centre]]
            if not len(others):
                continue
            other = random.choice(others)
        bad += _paint(source, true, tree, centre, other, radius)


def _paint(source: Ints, true: Ints, tree: Any, centre: int, other: int, radius: float) -> int:
    """Give all points of a ball the label of another; returns how many more are wrong now."""
    rows = np.array(tree.query_ball_point(tree.data[centre], radius))
    before = int((true[source[rows]] != true[rows]).sum())
    source[rows] = other
    return int((true[other] != true[rows]).sum()) - before
