"""What floors and walls are made of, by the type of the room.

The substances of each type are OpenRooms' own lists: those of floors as they stand; walls have
paint and rough stone, fabric where the floor may have it, and specular stone in bathrooms. How
often each is taken, and which families of it suit the room, is ours.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np

from openrooms_usd.description.substances import Substance
from openrooms_usd.library.styles.assignment.weights import Weights, drawn, families_for
from openrooms_usd.tables import read_table

Place = Literal["floor", "wall", "ceiling"]
Substances = Mapping[Substance, float]


@dataclass(frozen=True)
class RoomFinishes:
    """What a type of room has.

    Attributes:
        floor: Substances of its floor, with weights.
        wall: Substances of its walls, with weights.
        suited: Families that suit this type better than those of `USUAL`, by place and substance.
    """

    floor: Substances
    wall: Substances
    suited: Mapping[tuple[Place, Substance], Weights] = field(default_factory=dict)


_NO_FACTORS: Final[Weights] = {}
_PAINTED: Final[Substances] = {"paint": 1.0}
_TABLES: Final = read_table(__file__, "rooms.toml")

USUAL: Final[dict[Place, dict[Substance, Weights]]] = _TABLES["usual"]
"""Families that suit a place, wherever a room says nothing else."""


def _surfaces(floor: Substances, wall: Substances, suited: str = "") -> RoomFinishes:
    places: dict[Place, dict[Substance, Weights]] = _TABLES[suited] if suited else {}
    better = {(place, kind): w for place, kinds in places.items() for kind, w in kinds.items()}
    return RoomFinishes(floor, wall, better)


ROOMS: Final[dict[str, RoomFinishes]] = {
    k: _surfaces(**told) for k, told in _TABLES["rooms"].items()
}


def substance_of(
    room: str, place: Place, rng: np.random.Generator, factors: Weights = _NO_FACTORS
) -> Substance:
    """Draw what a place in a room of this type is made of; ceilings are painted.

    Args:
        room: The type.
        place: Floor, wall or ceiling.
        rng: Draws it.
        factors: How much more or less often substances are drawn.
    """
    usual = {"floor": ROOMS[room].floor, "wall": ROOMS[room].wall}.get(place, _PAINTED)
    weights = {name: weight * factors.get(name, 1.0) for name, weight in usual.items()}
    return drawn(rng, weights if any(weights.values()) else usual)


def families_of(room: str, place: Place, substance: Substance) -> Weights:
    """The families of a substance that suit a place in a room of this type."""
    own = ROOMS[room].suited.get((place, substance))
    return own or USUAL[place].get(substance) or families_for(substance, {place})


def surface_of(room: str, place: Place, rng: np.random.Generator) -> tuple[str, Substance]:
    """Draw the family that a place in a room of this type has, and its substance."""
    substance = substance_of(room, place, rng)
    return drawn(rng, families_of(room, place, substance)), substance
