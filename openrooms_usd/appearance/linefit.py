"""Moves cameras so that lines of a room's geometry lie on lines of photographs."""

from collections.abc import Sequence
from itertools import product
from typing import Final

import numpy as np

from openrooms_usd.appearance.lines import Drawing, Lines, agreement, closeness, geometry_lines
from openrooms_usd.appearance.motions import descended, distinct, in_camera, motion
from openrooms_usd.appearance.views import Geometry, scaled
from openrooms_usd.arrays import Array
from openrooms_usd.geometry.rotations import inverse

# The search: views of geometry are taken so far apart, and tried at these places around.
_VIEWS_M: Final = (-0.6, -0.3, 0.0, 0.3, 0.6)
_AROUND_M: Final = (-0.1, 0.0, 0.1)
_HEIGHTS_M: Final = (-0.2, -0.1, 0.0, 0.1, 0.2)
_YAWS_DEG: Final = tuple(np.arange(-17.5, 17.6, 2.5))
# Photographs that take part in it, width of their views, points of each.
_SEARCHED: Final = 8
_COARSE_WIDTH: Final = 160
_FINE_WIDTH: Final = 320
_COARSE_POINTS: Final = 200
# Tolerances from coarse to fine, pixels of pictures 480 wide.
_SIGMAS_PX: Final = (10.0, 6.0, 3.0)
_FINEST_PX: Final = 2.0
_OWN_SIGMAS_PX: Final = (8.0, 4.0, _FINEST_PX)
_STEPS: Final = 5
_KEPT: Final = (10, 4)
# How many points of lines tell as much as one.
_ALIKE_POINTS: Final = 20.0


def search(drawings: Sequence[Drawing], geometry: Geometry, pivot: Array) -> Array:
    """The motion (4, 4) of all cameras that brings lines together, from a wide search.

    Args:
        drawings: Of the photographs, with their poses.
        geometry: The room.
        pivot: (3,) what turns leave where it is.
    """
    some = [drawings[i] for i in _spread(len(drawings), _SEARCHED)]
    trials, scores = _tried(some, geometry, pivot)
    kept = distinct(trials, scores, pivot, _KEPT[0])
    # The motion as it is said takes part always.
    candidates = [*kept, np.eye(4)]
    for sigma, count in zip(_SIGMAS_PX[:-1], (_KEPT[1], 1), strict=True):
        candidates = [
            refine(some, geometry, one, pivot, (sigma,), _COARSE_WIDTH) for one in candidates
        ]
        marks = np.array([score(some, geometry, one, sigma, _COARSE_WIDTH) for one in candidates])
        candidates = distinct(candidates, marks, pivot, count)
    return refine(drawings, geometry, candidates[0], pivot, (*_SIGMAS_PX[1:], _FINEST_PX))


def _tried(
    drawings: Sequence[Drawing], geometry: Geometry, pivot: Array
) -> tuple[list[Array], Array]:
    """All motions of the search, and their scores."""
    sigma = _SIGMAS_PX[0]
    expected = [drawn.expected(sigma) for drawn in drawings]
    trials: list[Array] = []
    scores: list[Array] = []
    turns = [np.radians(yaw) for yaw in _YAWS_DEG]
    for east, north in product(_VIEWS_M, _VIEWS_M):
        shifted = motion([east, north, 0, 0, 0, 0], pivot)
        seen = lines_of(drawings, geometry, shifted, _COARSE_WIDTH, _COARSE_POINTS)
        here = [
            motion([east + dx, north + dy, dz, 0, 0, turn], pivot)
            for dx, dy, dz, turn in product(_AROUND_M, _AROUND_M, _HEIGHTS_M, turns)
        ]
        total = np.zeros(len(here))
        backs = np.array([inverse(one) for one in here])
        for drawn, lines, usual in zip(drawings, seen, expected, strict=True):
            total += _scores(drawn, lines, backs, usual, sigma)
        trials += here
        scores.append(total / len(drawings))
    return trials, np.concatenate(scores)


def _scores(drawn: Drawing, lines: Lines, backs: Array, usual: Array, sigma: float) -> Array:
    """(S,) agreement of one photograph under S motions, given by their inverses (S, 4, 4)."""
    if not len(lines.points):
        return np.zeros(len(backs))
    camera = inverse(drawn.pose) @ backs
    local = lines.points @ camera[:, :3, :3].transpose(0, 2, 1) + camera[:, None, :3, 3]
    cell, inside = drawn.cells(local.reshape(-1, 3))[1:]
    bins = np.tile(lines.bins, len(backs))
    near = closeness(drawn.distance[bins, cell[:, 1], cell[:, 0]], sigma) - usual[bins]
    return np.asarray((near * inside).reshape(len(backs), -1).mean(axis=1))


def lines_of(
    drawings: Sequence[Drawing],
    geometry: Geometry,
    moved: Array,
    width: int = _FINE_WIDTH,
    count: int | None = None,
) -> list[Lines]:
    """The lines that the cameras see after a motion (4, 4), in views so wide."""
    found = []
    for drawn in drawings:
        full_width, full_height = drawn.size
        factor = min(1.0, width / full_width)
        size = round(factor * full_width), round(factor * full_height)
        lines = geometry_lines(geometry, scaled(drawn.K, factor), moved @ drawn.pose, size)
        found.append(lines if count is None else lines.thinned(count))
    return found


def score(
    drawings: Sequence[Drawing],
    geometry: Geometry,
    moved: Array,
    sigma: float,
    width: int = _FINE_WIDTH,
) -> float:
    """Mean agreement of all photographs after a motion (4, 4)."""
    lines = lines_of(drawings, geometry, moved, width)
    return float(agreement(drawings, lines, [moved @ one.pose for one in drawings], sigma).mean())


def refine(
    drawings: Sequence[Drawing],
    geometry: Geometry,
    start: Array,
    pivot: Array,
    sigmas: Sequence[float],
    width: int = _FINE_WIDTH,
) -> Array:
    """One motion (4, 4) of all cameras, from one that is near.

    Args:
        drawings: Of the photographs.
        geometry: The room.
        start: (4, 4) the motion to begin with.
        pivot: (3,) what small motions turn about.
        sigmas: Tolerances, pixels, one after the other; geometry is seen anew for each.
        width: Of the views of geometry, pixels.
    """
    now = start
    for sigma in sigmas:
        now = _closer(drawings, geometry, now, pivot, sigma, width)
    return now


def refine_one(drawn: Drawing, geometry: Geometry, start: Array) -> Array:
    """The motion (4, 4) of one photograph's camera near one of all, drawn to it."""
    eye = (start @ drawn.pose)[:3, 3]
    now = start
    for sigma in _OWN_SIGMAS_PX:
        now = _closer([drawn], geometry, now, eye, sigma, origin=start)
    return now


def _closer(
    drawings: Sequence[Drawing],
    geometry: Geometry,
    start: Array,
    pivot: Array,
    sigma: float,
    width: int = _FINE_WIDTH,
    origin: Array | None = None,
) -> Array:
    """`refine` at one tolerance, by reweighted least squares."""
    lines = lines_of(drawings, geometry, start, width)
    poses = [start @ one.pose for one in drawings]
    # The fewer lines agree, the more of those that do are met by chance.
    agree = float(agreement(drawings, lines, poses, sigma).mean())
    trust = 1.0 if origin is None else max(agree, 0.0) ** 2

    def evidence(now: Array) -> tuple[Array, Array]:
        normal, right = np.zeros((6, 6)), np.zeros(6)
        for drawn, seen in zip(drawings, lines, strict=True):
            J, off, weight = _equations(drawn, seen, now, pivot, sigma)
            normal += (J * weight[:, None]).T @ J
            right -= J.T @ (weight * off)
        scale = trust / (_ALIKE_POINTS * max(sigma, _FINEST_PX) ** 2)
        return scale * normal, scale * right

    return descended(evidence, start, pivot, _STEPS, origin)


def _equations(
    drawn: Drawing, lines: Lines, moved: Array, pivot: Array, sigma: float
) -> tuple[Array, Array, Array]:
    """(N, 6) derivative, (N,) pixels from lines, and (N,) weights of a photograph's points."""
    pose = moved @ drawn.pose
    local = in_camera(lines.points, pose)
    pixel, cell, inside = drawn.cells(local)
    local, pixel, cell = local[inside], pixel[inside], cell[inside]
    across, bins, points = lines.across[inside], lines.bins[inside], lines.points[inside]
    row, column = cell[:, 1], cell[:, 0]
    aim = drawn.nearest[bins, :, row, column] + 0.5
    off = np.einsum("ij,ij->i", across, pixel - aim)
    weight = closeness(drawn.distance[bins, row, column], sigma).astype(np.float64)
    # The camera's motion moves points the other way.
    K, z = drawn.K, local[:, 2]
    slope = across * K[[0, 1], [0, 1]] / z[:, None]
    ahead = -(slope * local[:, :2]).sum(axis=1) / z
    pull = np.column_stack([slope, ahead]) @ pose[:3, :3].T
    return np.column_stack([-pull, -np.cross(points - pivot, pull)]), off, weight


def _spread(total: int, count: int) -> list[int]:
    """At most so many rows, evenly."""
    return sorted({round(x) for x in np.linspace(0, total - 1, min(count, total))})
