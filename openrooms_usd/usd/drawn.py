"""What a prim that is no polygons gives to draw."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.mesh import Mesh

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Drawn:
    """Polygons in place of curves, points and the like.

    Attributes:
        mesh: None where there is nothing to draw.
        losses: What was approximated; without a mesh the reason.
        along: Gives of a primvar's values (N, C) and its interpolation those at the places that the
            points of the mesh stand about, as many points about each, one place after the other;
            it raises ``ValueError`` where they do not fit.
    """

    mesh: Mesh | None
    losses: list[str] = field(default_factory=list)
    along: Callable[[Array, str], Array] | None = None

    def at_points(self, values: Array, interpolation: str) -> Array | None:
        """(P, C) a primvar's values at the points of the mesh; None where they do not fit."""
        if self.mesh is None or self.along is None or not len(values):
            return None
        try:
            placed = self.along(values, interpolation)
        except ValueError:
            return None
        return np.repeat(placed, len(self.mesh.points) // len(placed), axis=0)
