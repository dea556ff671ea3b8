"""How people leave a room: what lies about in it, level by level, each adding to the one before."""

from collections.abc import Sequence
from typing import Final

from openrooms_usd.draws import generator
from openrooms_usd.furniture import offered_surfaces
from openrooms_usd.generation.clutter.amounts import LAID, ROOM_AMOUNTS
from openrooms_usd.generation.clutter.arrangements import MOUSE, lay_table, put_beside
from openrooms_usd.generation.clutter.draping import edges
from openrooms_usd.generation.clutter.forms import Surfaces
from openrooms_usd.generation.clutter.ground import Ground
from openrooms_usd.generation.clutter.hanging import drape, hang
from openrooms_usd.generation.clutter.hooks import pegs
from openrooms_usd.generation.clutter.laying import taken_by
from openrooms_usd.generation.clutter.making import ProductVariants
from openrooms_usd.generation.clutter.scatter import Scatter
from openrooms_usd.generation.clutter.settling import Vessel, fill_vessel, vessels
from openrooms_usd.generation.clutter.sills import CARRIER, sills
from openrooms_usd.generation.clutter.soft import seats
from openrooms_usd.generation.clutter.spots import Spot, spots, spots_of
from openrooms_usd.generation.items import Item
from openrooms_usd.generation.placement import Arrangement
from openrooms_usd.generation.shapes import Shapes

# The level from which on tables are laid for a meal.
_MEALS_FROM: Final = 2
# The title of what stands on the floor and hangs on the walls by itself.
ABOUT: Final = "lying about"

# Vessels are numbered downwards from here: surfaces upwards from 0, places of the room from -1.
_FIRST_VESSEL: Final = -1000
# What is kept free before windows and is no deeper than twice this is part of them, metres.
_NOSE_M: Final = 0.03

Groups = Sequence[tuple[str, Sequence[Item]]]


def lived_in(
    groups: Groups, room: Arrangement, shapes: Shapes, room_type: str, seed: int, level: int
) -> list[tuple[str, list[Item]]]:
    """The groups of a room with what lies on them, and a group of what lies about.

    What one level adds is drawn and laid after all that the levels below have: so a level holds
    everything of those below it.

    Args:
        groups: Titles and items, in the room's frame.
        room: The room with its paths; takes in what stands on the floor.
        shapes: The forms of the room's furniture.
        room_type: One of the 27.
        seed: Fixes everything that is drawn.
        level: 0 nothing, 1 tidy, 2 lived in, 3 messy.
    """
    full = [(title, list(items)) for title, items in groups]
    if not level:
        return full
    surfaces = Surfaces(shapes)
    items = [item for _, group in groups for item in group]
    rng = generator(seed, "generate", room_type, "clutter")
    scatter = Scatter(
        rng, surfaces, ProductVariants(rng), taken_by(items, surfaces), room_type, room.shell.height
    )
    kept = room.shell.kept
    # What stands out at windows, and the ways of doors.
    ways = kept[:, 6] <= 0.0
    scatter.taken.add(kept[ways], "room")
    scatter.taken.add(kept[~ways & (kept[:, 5] <= _NOSE_M)], CARRIER)
    boards = sills(room.shell, len(groups))
    tops = list(enumerate([*spots(groups, surfaces, room_type), *boards]))
    soft = list(enumerate(seats(groups, surfaces), len(tops)))
    hems = list(enumerate(edges(groups, surfaces), len(tops) + len(soft)))
    hanging = list(pegs(groups, surfaces))
    numbers = {
        item.key: number for number, item in enumerate(items, len(tops) + len(soft) + len(hems))
    }
    hollow: dict[str, Vessel] = {}
    ground = Ground(room, items, scatter.taken, rng)
    for step in range(1, level + 1):
        drawn = generator(seed, "generate", room_type, "clutter", step)
        scatter.rng = scatter.variants.rng = ground.rng = drawn
        if step == 1:
            _put_mice(scatter, [spot for _, spot in tops], items)
        for number, spot in tops:
            scatter.fill(number, spot, step)
        inner = _inside(scatter, surfaces, known=len(tops) + len(soft) + len(hems) + len(items))
        for number, spot in inner:
            scatter.fill(number, spot, step)
        if step == _MEALS_FROM:
            _lay_tables(scatter, [spot for _, spot in tops], groups, room_type)
        for number, seat in soft:
            scatter.sit(number, seat, step)
        for number, edge in hems:
            drape(scatter, number, edge, step)
        for peg in hanging:
            hang(scatter, numbers[peg.carrier.key], peg, ground, step)
        for place in ROOM_AMOUNTS:
            scatter.stand(ground, place, len(groups), step)
        _fill_vessels(scatter, groups, surfaces, hollow, step)
    full.append((ABOUT, []))
    for group, item in scatter.added:
        full[group][1].append(item)
    return [group for group in full if group[1]]


def _fill_vessels(
    scatter: Scatter, groups: Groups, surfaces: Surfaces, known: dict[str, Vessel], step: int
) -> None:
    """Things into bowls and bins: those that groups have, and those that were laid."""
    standing = [(number, item) for number, (_, items) in enumerate(groups) for item in items]
    for vessel in vessels([*standing, *scatter.added], surfaces):
        known.setdefault(vessel.carrier.key, vessel)
    for number, vessel in enumerate(known.values()):
        fill_vessel(scatter, _FIRST_VESSEL - number, vessel, step)


def _put_mice(scatter: Scatter, tops: Sequence[Spot], items: Sequence[Item]) -> None:
    """A mouse beside each keyboard."""
    for item in items:
        if item.category == "keyboard":
            below = next((spot for spot in tops if spot.carrier.key == item.on), None)
            if below is not None:
                put_beside(scatter, below, item, MOUSE)


def _lay_tables(
    scatter: Scatter, tops: Sequence[Spot], groups: Groups, room_type: str
) -> None:  # fmt: skip
    """Tables where people eat are laid now and then."""
    for spot in tops:
        if spot.place == "dining_table" and scatter.rng.random() < LAID.get(room_type, LAID[""]):
            lay_table(scatter, spot, groups[spot.group][1])


def _inside(scatter: Scatter, surfaces: Surfaces, known: int) -> list[tuple[int, Spot]]:
    """What small things carry themselves: baskets, trays, stacks."""
    offered = [(*added, offered_surfaces(added[1].category)) for added in scatter.added]
    found = (
        spot
        for group, item, places in offered
        if places
        for spot in spots_of(item, group, places, surfaces)
    )
    return list(enumerate(found, known))
