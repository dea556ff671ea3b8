"""How people leave a room: what lies about in it, level by level, each adding to the one before."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from openrooms_usd.building.windows import BOARD, NOSE, reveal_depth
from openrooms_usd.draws import generator
from openrooms_usd.furniture import category, offered_surfaces
from openrooms_usd.generation.clutter.amounts import DRAPED, HUNG, LAID, ROOM_AMOUNTS
from openrooms_usd.generation.clutter.arrangements import MOUSE, lay_table, put_beside
from openrooms_usd.generation.clutter.draping import Edge, edges, hang_over
from openrooms_usd.generation.clutter.forms import LevelFinder
from openrooms_usd.generation.clutter.ground import Ground
from openrooms_usd.generation.clutter.hooks import Peg, pegs
from openrooms_usd.generation.clutter.laying import item_at, posed_object, taken_by
from openrooms_usd.generation.clutter.levels import CELL_M, Level
from openrooms_usd.generation.clutter.making import ProductVariants
from openrooms_usd.generation.clutter.scatter import Scatter
from openrooms_usd.generation.clutter.settling import Vessel, fill_vessel, vessels
from openrooms_usd.generation.clutter.soft import seats
from openrooms_usd.generation.clutter.spots import SupportSurface, spots, spots_of
from openrooms_usd.generation.items import Item
from openrooms_usd.generation.placement import Arrangement
from openrooms_usd.generation.shapes import Shapes
from openrooms_usd.generation.shell import Gap, Shell


def drape(scatter: Scatter, number: int, edge: Edge, level: int) -> None:
    """Hang a cloth over an edge, as often as a level has it.

    Args:
        scatter: Lays things in this room.
        number: The edge's, the same at all levels.
        edge: The edge.
        level: 1, 2 or 3.
    """
    drawn = scatter.drawn(number, edge.place, level)
    wanted = scatter.rng.random() < DRAPED[edge.place][level - 1]
    make = scatter.variants.draw(*drawn) if drawn and wanted else None
    if drawn is None or make is None:
        return
    (width, _, height), style = make
    fit = hang_over(edge, width, height, scatter.rng)
    spec, carrier = category(drawn[0]), edge.carrier
    if fit is None or not all(
        low <= side <= high
        for low, side, high in zip(spec.min_size, fit.size, spec.max_size, strict=True)
    ):
        return
    thing = posed_object(scatter.surfaces, drawn[0], (fit.size, style))
    pose = (*carrier.at(fit.x, fit.y), carrier.yaw + fit.yaw)
    box = thing.standing(pose, carrier.z + fit.z)
    if not len(scatter.taken.near(box, {carrier.key})):
        item = item_at(thing, scatter.key(drawn[0]), pose, carrier.z + fit.z, carrier.key)
        scatter.note(number, *drawn)
        scatter.add(edge.group, item, box)


def hang(scatter: Scatter, number: int, peg: Peg, ground: Ground, level: int) -> None:
    """Hang a thing on a hook or a rail, as often as a level has it.

    Args:
        scatter: Lays things in this room.
        number: The carrier's, the same at all levels.
        peg: The hook.
        ground: The room's walls.
        level: 1, 2 or 3.
    """
    drawn = scatter.drawn(number, peg.place, level)
    wanted = scatter.rng.random() < HUNG[peg.place][level - 1]
    make = scatter.variants.draw(*drawn) if drawn and wanted else None
    if drawn is None or make is None:
        return
    thing, carrier = posed_object(scatter.surfaces, drawn[0], make), peg.carrier
    x, y, z = peg.hung(thing.size)
    turn = peg.yaw + 180.0 * float(peg.yaw > 0.0 and scatter.rng.random() < 0.5)
    pose = (*carrier.at(x, y), carrier.yaw + turn)
    box = thing.standing(pose, carrier.z + z)
    if carrier.z + z < 0.02 or ground.meets_walls(box):
        return
    if not len(scatter.taken.near(box, {carrier.key})):
        item = item_at(thing, scatter.key(drawn[0]), pose, carrier.z + z, carrier.key)
        scatter.note(number, *drawn)
        scatter.add(peg.group, item, box)


CARRIER: Final = "floor"
"""What carries things on sills by their description: the room, at a height that is said."""
# Windows that begin lower have no board that people use, nor do those out of reach; metres.
_LOWEST_M, _HIGHEST_M = 0.5, 1.75
# What stands there leaves most of the window free, metres.
_MAX_HEIGHT_M: Final = 0.4
_MAX_SHARE: Final = 0.5
# Between things and the sides of the reveal, and the frame; metres.
_BESIDE_M, _FRAME_GAP_M = 0.02, 0.002


def sills(shell: Shell, group: int) -> Iterator[SupportSurface]:
    """The sill boards of a room.

    Args:
        shell: The room.
        group: The index of the group that takes what stands there.
    """
    for gap in shell.gaps:
        if gap.kind == "window" and _LOWEST_M <= gap.sill <= _HIGHEST_M:
            level = _board(shell, gap)
            if level.area > 0.0:
                yield SupportSurface("window_sill", _window(shell, gap), group, level)


def _window(shell: Shell, gap: Gap) -> Item:
    """A window as an item whose origin is on the floor, in the inner face of its wall."""
    side = shell.sides[gap.side]
    x, y = side.point(gap.at, 0.0).tolist()
    size = gap.width, shell.thickness, gap.top - gap.sill
    return Item(CARRIER, "window", size, "", x, y, 0.0, side.yaw)


def _board(shell: Shell, gap: Gap) -> Level:
    """The upper side of a board, from its nose to the frame."""
    width = gap.width - 2 * _BESIDE_M
    depth = NOSE + reveal_depth(shell.thickness) - _FRAME_GAP_M
    cells = int(depth / CELL_M), max(int(width / CELL_M), 0)
    high = min(_MAX_HEIGHT_M, _MAX_SHARE * (gap.top - gap.sill))
    corner = np.array([-0.5 * cells[1] * CELL_M, -NOSE])
    return Level(gap.sill + BOARD, corner, np.full(cells, high), True)


# The level from which on tables are laid for a meal.
_MEALS_FROM: Final = 2
# The title of what stands on the floor and hangs on the walls by itself.
ABOUT: Final = "lying about"

# Vessels are numbered downwards from here: surfaces upwards from 0, places of the room from -1.
_FIRST_VESSEL: Final = -1000
# Free areas before windows belong to the window if they are at most twice this deep, metres.
_NOSE_M: Final = 0.03

Groups = Sequence[tuple[str, Sequence[Item]]]


def add_clutter(
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
    surfaces = LevelFinder(shapes)
    items = [item for _, group in groups for item in group]
    rng = generator(seed, "generate", room_type, "clutter")
    scatter = Scatter(
        rng, surfaces, ProductVariants(rng), taken_by(items, surfaces), room_type,
        room.shell.height, Counter(item.category for item in items),
    )  # fmt: skip
    kept = room.shell.kept
    # What stands out at windows, and the ways of doors.
    ways = kept[:, 6] <= 0.0
    scatter.taken.add(kept[ways], "room")
    scatter.taken.add(kept[~ways & (kept[:, 5] <= _NOSE_M)], CARRIER)
    boards = sills(room.shell, len(groups))
    tops = list(enumerate([*spots(groups, surfaces, room_type), *boards]))
    soft = list(enumerate(seats(groups, surfaces), len(tops)))
    hanging_edges = list(enumerate(edges(groups, surfaces), len(tops) + len(soft)))
    hanging = list(pegs(groups, surfaces))
    numbers = {
        item.key: number
        for number, item in enumerate(items, len(tops) + len(soft) + len(hanging_edges))
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
        inner = _inside(
            scatter, surfaces, known=len(tops) + len(soft) + len(hanging_edges) + len(items)
        )
        for number, spot in inner:
            scatter.fill(number, spot, step)
        if step == _MEALS_FROM:
            _lay_tables(scatter, [spot for _, spot in tops], groups, room_type)
        for number, seat in soft:
            scatter.place_on_seat(number, seat, step)
        for number, edge in hanging_edges:
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
    scatter: Scatter, groups: Groups, surfaces: LevelFinder, known: dict[str, Vessel], step: int
) -> None:
    """Things into bowls and bins: those that groups have, and those that were laid."""
    standing = [(number, item) for number, (_, items) in enumerate(groups) for item in items]
    for vessel in vessels([*standing, *scatter.added], surfaces):
        known.setdefault(vessel.carrier.key, vessel)
    for number, vessel in enumerate(known.values()):
        fill_vessel(scatter, _FIRST_VESSEL - number, vessel, step)


def _put_mice(scatter: Scatter, tops: Sequence[SupportSurface], items: Sequence[Item]) -> None:
    """A mouse beside each keyboard."""
    for item in items:
        if item.category == "keyboard":
            below = next((spot for spot in tops if spot.carrier.key == item.on), None)
            if below is not None:
                put_beside(scatter, below, item, MOUSE)


def _lay_tables(
    scatter: Scatter, tops: Sequence[SupportSurface], groups: Groups, room_type: str
) -> None:  # fmt: skip
    """Tables where people eat are laid now and then."""
    for spot in tops:
        if spot.place == "dining_table" and scatter.rng.random() < LAID.get(room_type, LAID[""]):
            lay_table(scatter, spot, groups[spot.group][1])


def _inside(
    scatter: Scatter, surfaces: LevelFinder, known: int
) -> list[tuple[int, SupportSurface]]:
    """What small things carry themselves: baskets, trays, stacks."""
    offered = [(*added, offered_surfaces(added[1].category)) for added in scatter.added]
    found = (
        spot
        for group, item, places in offered
        if places
        for spot in spots_of(item, group, places, surfaces)
    )
    return list(enumerate(found, known))
