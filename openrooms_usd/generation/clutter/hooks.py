"""Where things hang by a loop: the crooks of hooks, and rails that take hangers.

What hangs is built with a loop on its top (`openrooms_usd.furniture.placements`): it hangs with
the underside of that loop on the crook, which is found on the mesh.
"""

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture import offered_surfaces
from openrooms_usd.furniture.placements import LOOP_BACK_M, LOOP_M, Place
from openrooms_usd.generation.clutter.forms import LevelFinder
from openrooms_usd.generation.items import Item
from openrooms_usd.generation.shapes import BuiltForm
from openrooms_usd.geometry.mesh import Mesh

# The underside of a loop is so far above the crook, metres.
_CLEAR_M: Final = 0.0008
# Lines that look for a crook are so far apart, metres.
_STEP_M: Final = 0.001
# From hanger to hanger on a rail, and from the rail's ends, metres.
_HANGERS_M: Final = 0.085
_RAIL_ENDS_M: Final = 0.16
# The rail of a rack is what its part of this name has on top.
_RAIL: Final = "tube"
HANGING: Final[tuple[Place, ...]] = ("hook", "clothes_rail")


class Peg(NamedTuple):
    """Something that one thing hangs on.

    Attributes:
        place: ``hook`` or ``clothes_rail``.
        carrier: What it belongs to.
        group: The index of the group of the carrier.
        at: Where a loop rests, in the carrier's frame, metres.
    """

    place: Place
    carrier: Item
    group: int
    at: tuple[float, float, float]

    @property
    def yaw(self) -> float:
        """Of what hangs, in the carrier's frame, degrees: hangers are square to their rail."""
        return 0.0 if self.place == "hook" else 90.0

    def hung(self, size: tuple[float, float, float]) -> tuple[float, float, float]:
        """Where the middle of a thing's base comes, in the carrier's frame, metres."""
        x, y, z = self.at
        back = 0.5 * size[1] - LOOP_BACK_M if self.place == "hook" else 0.0
        return x, y - back, z + LOOP_M + _CLEAR_M - size[2]


def pegs(groups: Sequence[tuple[str, Sequence[Item]]], surfaces: LevelFinder) -> Iterator[Peg]:
    """All hooks and rails of a furnished room.

    Args:
        groups: Titles and items, in the room's frame.
        surfaces: Knows their forms.
    """
    for number, (_, items) in enumerate(groups):
        for item in items:
            offered = offered_surfaces(item.category)
            for place in (place for place in offered if place in HANGING):
                shape = surfaces.shape(item)
                found = _crooks(shape) if place == "hook" else _along_rail(shape)
                yield from (Peg(place, item, number, at) for at in found)


def _crooks(shape: BuiltForm) -> Iterator[tuple[float, float, float]]:
    """The lowest place on the upper side of each hook, behind its tip."""
    for hook in shape.named("hook"):
        low, high = hook.extent
        x = 0.5 * float(low[0] + high[0])
        y = np.arange(low[1] + 0.5 * _STEP_M, high[1], _STEP_M)
        z = _tops(hook, np.full(len(y), x), y)
        tip = int(np.argmax(z[: len(z) // 2]))
        at = tip + int(np.argmin(z[tip:]))
        yield x, float(y[at]), float(z[at])


def _along_rail(shape: BuiltForm) -> Iterator[tuple[float, float, float]]:
    """Places on the highest tube, as far apart as hangers are."""
    rail = next(shape.named(_RAIL), None)
    if rail is None:
        return
    low, high = rail.extent
    x = np.arange(low[0] + _RAIL_ENDS_M, high[0] - _RAIL_ENDS_M, _HANGERS_M)
    y = np.full(len(x), 0.5 * float(low[1] + high[1]))
    yield from zip(x.tolist(), y.tolist(), _tops(rail, x, y).tolist(), strict=True)


def _tops(mesh: Mesh, x: Array, y: Array) -> Array:
    found = BuiltForm((mesh,)).tops(x, y)
    return np.asarray(np.where(np.isfinite(found), found, np.inf))
