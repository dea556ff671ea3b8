"""What stands around an object: the floor or what it stands on, the walls, what was seen."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.points.visibility import Panoramas
from openrooms_usd.scan.registration.template import SIDES, Shape, turn_of
from openrooms_usd.scan.registration.wallsides import NO_WALLS, Walls

Array = NDArray[np.float64]

# Standard deviations of contacts, metres: the base on its support, a hidden side at a wall, and
# what is behind a wall.
_STANDING: Final = 0.01
_TOUCHING: Final = 0.03
_INSIDE: Final = 0.01
# A hidden side is at the wall if it is about so near to it, metres.
_NEAR: Final = 0.08
# Cosine of the angle within which a side is parallel to a wall.
_PARALLEL: Final = 0.94
# A side is hidden if less than this part of it was visible.
_HIDDEN: Final = 0.15
# What belongs to a side: within this part of the extent, normals within 45 degrees.
_SKIN: Final = 0.15
# How much likelier a side that is flat is at the wall than one with handles and corners.
_BACK: Final = 10.0


@dataclass(frozen=True, eq=False)
class Rows:
    """Linearised residuals, each over its standard deviation.

    Attributes:
        residual: (K,).
        slope: (K, 7) by the parameters of the shape.
        energy: Of all, with their robust kernels.
    """

    residual: Array
    slope: Array
    energy: float


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What an object touches.

    Attributes:
        panoramas: What was seen; None: not known.
        support: Height of what it stands on, metres; None: not known, or it hangs.
        walls: Those near it.
        doubt: What that support costs because another one is likelier, in the energy's unit.
    """

    panoramas: Panoramas | None = None
    support: float | None = None
    walls: Walls = field(default=NO_WALLS)
    doubt: float = 0.0

    def rows(self, shape: Shape, parameters: Array, hidden: NDArray[np.bool_]) -> Rows:
        """Contacts of a shape.

        Args:
            shape: The shape.
            parameters: (7,) where it is.
            hidden: (4,) which of its sides no camera saw (see `hidden_sides`).
        """
        residuals, slopes, energy = [0.0], [np.zeros(7)], self.doubt
        if self.support is not None:
            residuals.append((parameters[2] - self.support) / _STANDING)
            slopes.append(np.eye(7)[2] / _STANDING)
            energy += residuals[-1] ** 2
        half = 0.5 * shape.size * [1.0, 1.0, 0.0] * np.exp(parameters[4:])
        turn = turn_of(parameters)
        for start, inward in zip(self.walls.starts, self.walls.normals, strict=True):
            n = np.array([*inward, 0.0])
            room = float(n[:2] @ (parameters[:2] - start))
            local = turn.T @ n
            # The corner that is deepest in the wall.
            corner = -half * np.sign(local)
            depth = room + float(local @ corner)
            if depth < 0.0:
                residuals.append(depth / _INSIDE)
                slopes.append(_slope(n, turn, corner) / _INSIDE)
                energy += residuals[-1] ** 2
            side = int((SIDES @ local).argmin())
            middle = half * SIDES[side]
            gap = room + float(local @ middle)
            near = _NEAR**2 / (_NEAR**2 + gap**2)
            energy += _BACK * near * (1.0 - shape.flat[side])
            if hidden[side] and SIDES[side] @ local < -_PARALLEL and depth > 0.0:
                residuals.append(gap * near / _TOUCHING)
                slopes.append(_slope(n, turn, middle) * near / _TOUCHING)
                energy += (gap / _TOUCHING) ** 2 * near
        return Rows(np.array(residuals), np.array(slopes), energy)


def hidden_sides(shape: Shape, visible: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(4,) whether the sides +x, -x, +y and -y of a shape were hidden from all sensors.

    Args:
        shape: The shape.
        visible: (N,) which of its points were not.
    """
    reach = shape.points @ SIDES.T / np.maximum(0.5 * np.abs(SIDES) @ shape.size, 1e-9)
    of_side = (reach > 1.0 - 2.0 * _SKIN) & (shape.normals @ SIDES.T > np.sqrt(0.5))
    seen = (of_side & visible[:, None]).sum(axis=0)
    return np.asarray(seen <= _HIDDEN * of_side.sum(axis=0))


def _slope(n: Array, turn: Array, local: Array) -> Array:
    """(7,) how a point of a shape (scaled, not turned) moves along a direction."""
    lever = turn @ local
    return np.array([*n, n[1] * lever[0] - n[0] * lever[1], *((n @ turn) * local)])
