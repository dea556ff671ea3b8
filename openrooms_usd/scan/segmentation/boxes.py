"""Boxes around things without a name: along the walls where they allow it, and apart."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.rotations import in_plan
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.thinning import thin
from openrooms_usd.scan.registration.hints import Box
from openrooms_usd.scan.registration.surroundings import walls_of
from openrooms_usd.scan.results import FoundRoom
from openrooms_usd.scan.segmentation.shape import upright_box

_THINNING_M: Final = 0.02
# Boxes of nearly one heading that overlap by less than this part of the smaller one's side are
# parted there; what overlaps more is inside of the other.
_PARALLEL_RAD: Final = np.deg2rad(10.0)
_MAX_CUT_SHARE: Final = 0.4


@dataclass(frozen=True, eq=False)
class _Upright:
    """An upright box: the middle of its base (3,), its size (3,) and its yaw."""

    base: Array
    size: Array
    yaw: float


def boxes_of(
    cloud: Cloud, instance: NDArray[np.int32], numbers: Collection[int], rooms: Sequence[FoundRoom]
) -> dict[int, Box]:
    """The boxes of some things, by their numbers.

    Args:
        cloud: N points, floor at z = 0, metres.
        instance: (N,) the thing of each point.
        numbers: Of the things.
        rooms: In the frame of the cloud.
    """
    walls, found = walls_of(rooms), {}
    for number in numbers:
        points = thin(Cloud(cloud.points[instance == number]), _THINNING_M).points
        if len(points):
            base, size, yaw, _ = upright_box(points, walls)
            found[number] = _Upright(base, size, yaw)
    order = sorted(found, key=lambda number: -float(np.prod(found[number].size)))
    for place, number in enumerate(order):
        for larger in order[:place]:
            found[number] = _parted(found[number], found[larger])
    return {number: _as_box(found[number]) for number in order}


def _parted(box: _Upright, other: _Upright) -> _Upright:
    """A box cut where it overlaps a little with another one of about the same heading."""
    quarter = 0.5 * np.pi
    apart = (box.yaw - other.yaw + 0.5 * quarter) % quarter - 0.5 * quarter
    if abs(apart) > _PARALLEL_RAD:
        return box
    turn = np.eye(3)
    turn[:2, :2] = in_plan(box.yaw)
    crossed = round((box.yaw - other.yaw - apart) / quarter) % 2 == 1
    size = other.size[[1, 0, 2]] if crossed else other.size
    rise = 0.5 * np.array([0.0, 0.0, 1.0])
    offset = turn.T @ (other.base + rise * size - box.base - rise * box.size)
    overlap = 0.5 * (box.size + size) - np.abs(offset)
    axis = int((overlap / box.size).argmin())
    cut = float(overlap[axis])
    if (overlap <= 0.0).any() or cut > _MAX_CUT_SHARE * box.size[axis]:
        return box
    away = -float(np.sign(offset[axis])) or 1.0
    smaller = box.size - cut * np.eye(3)[axis]
    # Of a shorter box the base moves only if it is cut from below.
    shift = 0.5 * away * cut if axis < 2 else max(away, 0.0) * cut
    return replace(box, base=box.base + shift * turn[:, axis], size=smaller)


def _as_box(box: _Upright) -> Box:
    middle = box.base + np.array([0.0, 0.0, 0.5 * float(box.size[2])])
    turn = np.array([np.cos(0.5 * box.yaw), 0.0, 0.0, np.sin(0.5 * box.yaw)])
    return Box(middle, box.size, turn)
