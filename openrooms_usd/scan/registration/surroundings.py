"""Contact residuals of an object with its support and walls, and its visibility."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.scan.points.visibility import Panoramas
from openrooms_usd.scan.registration.template import SIDES, Template, turn_of
from openrooms_usd.scan.results import FoundRoom

# Walls of rooms as segments with inward normals, for contacts with objects.

# Of a thing that is turned to its wall: the most between them, metres, and the least and the
# largest turn, radians.
_ASKEW_AT_M: Final = 0.25
_ALONG_RAD: Final = 0.05
_MAX_TURN_RAD: Final = 0.35
# Walls farther than this from an object's bounding circle do not touch it, metres.
_WALL_REACH_M: Final = 0.4


@dataclass(frozen=True, eq=False)
class Walls:
    """W straight walls.

    Attributes:
        starts: (W, 2) metres.
        ends: (W, 2) metres.
        normals: (W, 2) unit, into the room.
    """

    starts: Array
    ends: Array
    normals: Array

    def near(self, place: Array, radius: float) -> "Walls":
        """The walls that a disc is close to, or intersects, on their inner side."""
        along = self.ends - self.starts
        length = np.linalg.norm(along, axis=1)
        unit = along / np.maximum(length, 1e-9)[:, None]
        offset = place[:2] - self.starts
        station = np.einsum("ij,ij->i", offset, unit)
        depth = np.einsum("ij,ij->i", offset, self.normals)
        kept = (station > -0.5 * radius) & (station < length + 0.5 * radius)
        kept &= (depth > -0.5 * radius) & (depth < radius + _WALL_REACH_M)
        return Walls(self.starts[kept], self.ends[kept], self.normals[kept])

    def gaps(self, parameters: Array, size: Array) -> Array:
        """(W,) metres from each wall to the nearest corner of a box, negative behind it.

        Args:
            parameters: (7,) pose of a template.
            size: (3,) of its box, metres.
        """
        half = 0.5 * size[:2] * (self.normals @ turn_of(parameters)[:2, :2])
        middle = np.einsum("ij,ij->i", parameters[:2] - self.starts, self.normals)
        return np.asarray(middle - np.abs(half).sum(axis=1))

    def askew(self, parameters: Array, size: Array) -> tuple[int, float] | None:
        """The wall that a box stands at askew, and the turn that brings it along it, radians.

        Args:
            parameters: (7,) pose of a template.
            size: (3,) of its box, metres.

        Returns:
            None where it stands at no wall, along it, or askew by more than is likely an error.
        """
        quarter = 0.5 * np.pi
        off = parameters[3] - np.arctan2(self.normals[:, 1], self.normals[:, 0])
        turns = (0.5 * quarter - off) % quarter - 0.5 * quarter
        at = np.flatnonzero(np.abs(self.gaps(parameters, size)) < _ASKEW_AT_M)
        row = min(at.tolist(), key=lambda row: float(abs(turns[row])), default=None)
        if row is None or not _ALONG_RAD < abs(turns[row]) < _MAX_TURN_RAD:
            return None
        return row, float(turns[row])


def walls_of(rooms: Sequence[FoundRoom]) -> Walls:
    """All walls of some rooms."""
    starts = [room.corners[:, :2] for room in rooms] or [np.empty((0, 2))]
    ends = [np.roll(corners, -1, axis=0) for corners in starts]
    a, b = np.concatenate(starts), np.concatenate(ends)
    along = (b - a) / np.maximum(np.linalg.norm(b - a, axis=1), 1e-9)[:, None]
    return Walls(a, b, np.stack([-along[:, 1], along[:, 0]], axis=1))


NO_WALLS: Final = walls_of(())


# Standard deviations of contacts, metres: base to support, hidden side to wall, and penetration
# into a wall.
_STANDING_SIGMA_M: Final = 0.01
_TOUCHING_SIGMA_M: Final = 0.03
_BEHIND_WALL_SIGMA_M: Final = 0.01
# Width of the robust kernel of a hidden side's gap to a wall, metres.
_AT_WALL_M: Final = 0.08
# Least cosine at which a side is parallel to a wall.
_PARALLEL_COS: Final = 0.94
# A side is hidden if at most this part of it was visible.
_MAX_VISIBLE_SHARE: Final = 0.15
# Points of a side: within this part of the extent, normals within 45 degrees.
_SIDE_SHARE: Final = 0.15
# Energy against a side at the wall that is not flat, as one with handles.
_FLAT_BACK_ODDS: Final = 10.0


@dataclass(frozen=True, eq=False)
class Rows:
    """Linearised residuals, each divided by its standard deviation.

    Attributes:
        residual: (K,).
        slope: (K, 7) Jacobian by the template's parameters.
        energy: Sum of all, robust kernels included.
    """

    residual: Array
    slope: Array
    energy: float


@dataclass(frozen=True, eq=False)
class ObjectSurroundings:
    """The surroundings of an object.

    Attributes:
        panoramas: Visibility from the sensors; None: not known.
        support: Height of its support, metres; None: not known, or it hangs.
        walls: Those near it.
        doubt: Energy of the prior against this support where another one is likelier.
    """

    panoramas: Panoramas | None = None
    support: float | None = None
    walls: Walls = field(default=NO_WALLS)
    doubt: float = 0.0

    def rows(self, template: Template, parameters: Array, hidden: Mask) -> Rows:
        """Contact residuals of a template.

        Args:
            template: The template.
            parameters: (7,) its pose.
            hidden: (4,) which of its sides are hidden (see `hidden_sides`).
        """
        residuals, slopes, energy = [0.0], [np.zeros(7)], self.doubt
        if self.support is not None:
            residuals.append((parameters[2] - self.support) / _STANDING_SIGMA_M)
            slopes.append(np.eye(7)[2] / _STANDING_SIGMA_M)
            energy += residuals[-1] ** 2
        half = 0.5 * template.size * [1.0, 1.0, 0.0] * np.exp(parameters[4:])
        turn = turn_of(parameters)
        for start, inward in zip(self.walls.starts, self.walls.normals, strict=True):
            n = np.array([*inward, 0.0])
            room = float(n[:2] @ (parameters[:2] - start))
            local = turn.T @ n
            # The corner that penetrates the wall deepest.
            corner = -half * np.sign(local)
            depth = room + float(local @ corner)
            if depth < 0.0:
                residuals.append(depth / _BEHIND_WALL_SIGMA_M)
                slopes.append(_slope(n, turn, corner) / _BEHIND_WALL_SIGMA_M)
                energy += residuals[-1] ** 2
            side = int((SIDES @ local).argmin())
            middle = half * SIDES[side]
            gap = room + float(local @ middle)
            near = _AT_WALL_M**2 / (_AT_WALL_M**2 + gap**2)
            energy += _FLAT_BACK_ODDS * near * (1.0 - template.flat[side])
            if hidden[side] and SIDES[side] @ local < -_PARALLEL_COS and depth > 0.0:
                residuals.append(gap * near / _TOUCHING_SIGMA_M)
                slopes.append(_slope(n, turn, middle) * near / _TOUCHING_SIGMA_M)
                energy += (gap / _TOUCHING_SIGMA_M) ** 2 * near
        return Rows(np.array(residuals), np.array(slopes), energy)


def hidden_sides(template: Template, visible: Mask) -> Mask:
    """(..., 4) whether the sides +x, -x, +y and -y of a template were hidden from all sensors.

    Args:
        template: The template.
        visible: (..., N) which of its points are visible from some sensor.
    """
    reach = template.points @ SIDES.T / np.maximum(0.5 * np.abs(SIDES) @ template.size, 1e-9)
    of_side = (reach > 1.0 - 2.0 * _SIDE_SHARE) & (template.normals @ SIDES.T > np.sqrt(0.5))
    seen = visible.astype(np.float64) @ of_side
    return np.asarray(seen <= _MAX_VISIBLE_SHARE * of_side.sum(axis=0))


def _slope(n: Array, turn: Array, local: Array) -> Array:
    """(7,) derivative of a template point's coordinate along a direction, by the parameters."""
    lever = turn @ local
    return np.array([*n, n[1] * lever[0] - n[0] * lever[1], *((n @ turn) * local)])
