"""What stands around an object: the floor or what it stands on, the walls, what was seen."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.points.visibility import Panoramas
from openrooms_usd.scan.registration.template import SIDES, Template, turn_of
from openrooms_usd.scan.registration.wallsides import NO_WALLS, Walls

Array = NDArray[np.float64]

# Standard deviations of contacts, metres: the base on its support, a hidden side at a wall, and
# what is behind a wall.
_STANDING_SIGMA_M: Final = 0.01
_TOUCHING_SIGMA_M: Final = 0.03
_BEHIND_WALL_SIGMA_M: Final = 0.01
# A hidden side is at the wall if it is about so near to it, metres.
_AT_WALL_M: Final = 0.08
# Cosine of the angle within which a side is parallel to a wall.
_PARALLEL_COS: Final = 0.94
# A side is hidden if less than this part of it was visible.
_MAX_VISIBLE_SHARE: Final = 0.15
# What belongs to a side: within this part of the extent, normals within 45 degrees.
_SIDE_SHARE: Final = 0.15
# How much likelier a side that is flat is at the wall than one with handles and corners.
_FLAT_BACK_ODDS: Final = 10.0


@dataclass(frozen=True, eq=False)
class Rows:
    """Linearised residuals, each over its standard deviation.

    Attributes:
        residual: (K,).
        slope: (K, 7) by the parameters of the template.
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

    def rows(self, template: Template, parameters: Array, hidden: NDArray[np.bool_]) -> Rows:
        """Contacts of a template.

        Args:
            template: The template.
            parameters: (7,) where it is.
            hidden: (4,) which of its sides no camera saw (see `hidden_sides`).
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
            # The corner that is deepest in the wall.
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


def hidden_sides(template: Template, visible: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(4,) whether the sides +x, -x, +y and -y of a template were hidden from all sensors.

    Args:
        template: The template.
        visible: (N,) which of its points were not.
    """
    reach = template.points @ SIDES.T / np.maximum(0.5 * np.abs(SIDES) @ template.size, 1e-9)
    of_side = (reach > 1.0 - 2.0 * _SIDE_SHARE) & (template.normals @ SIDES.T > np.sqrt(0.5))
    seen = (of_side & visible[:, None]).sum(axis=0)
    return np.asarray(seen <= _MAX_VISIBLE_SHARE * of_side.sum(axis=0))


def _slope(n: Array, turn: Array, local: Array) -> Array:
    """(7,) how a point of a template (scaled, not turned) moves along a direction."""
    lever = turn @ local
    return np.array([*n, n[1] * lever[0] - n[0] * lever[1], *((n @ turn) * local)])
