"""From openings as they are described or captured to holes that fit their walls."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Literal

import numpy as np

from openrooms_usd.building.openings import around, clamped, free_span, misfit, too_close
from openrooms_usd.building.shell import Hole
from openrooms_usd.building.walls import Wall
from openrooms_usd.capture import CapturedOpening
from openrooms_usd.description.layout import USUAL_OPENINGS, Opening, named_openings
from openrooms_usd.description.mistakes import FieldsError, Steps
from openrooms_usd.description.naming import captured_names

Kind = Literal["window", "door", "opening"]

# Angle of a captured door that is open by an unknown angle, degrees.
_AJAR_DEG: Final = 60.0
# Captured doors and passages that begin no higher than this reach the floor, metres.
_MAX_THRESHOLD_M: Final = 0.1
# Largest distance (metres) and angle between a captured opening and its wall.
_REACH, _PARALLEL = 0.5, 0.8


_OPENINGS: Final = ("layout", "openings")
NO_PARTITIONS: Final[Mapping[str, str]] = MappingProxyType({})
"""What a capture without inner walls has."""


@dataclass(frozen=True)
class Cut:
    """An opening with its name, its wall and the hole that it makes there.

    Attributes:
        name: Its prim name.
        kind: What it is.
        wall: Its wall.
        hole: Its rectangle in the wall's x and z, metres.
        open: How far a door's leaf shall stand open, degrees.
        hinge: The hinge side of a door, seen from inside.
        swing: Where a door's leaf swings to.
        style: How it is built; the usual way where None.
        source: The captured opening that it is made from.
        beyond: What lies behind it.
    """

    name: str
    kind: Kind
    wall: Wall
    hole: Hole
    open: float = 0.0
    hinge: Literal["left", "right"] = "left"
    swing: Literal["in", "out"] = "in"
    style: str | None = None
    source: CapturedOpening | None = None
    beyond: Literal["outside", "hallway"] = "outside"


def described_cuts(
    openings: Sequence[Opening],
    walls: Sequence[Wall],
    height: float,
    *,
    clockwise: bool = False,
    before: Sequence[Cut] = (),
) -> list[Cut]:
    """The holes of the description's openings.

    Args:
        openings: As they are described.
        walls: Those of the outline by ascending number, then those that stand free.
        height: Floor to ceiling, metres.
        clockwise: Whether the polygon was given clockwise, so that walls start at their left end.
        before: Openings that are there already.

    Returns:
        The openings in order.

    Raises:
        DescriptionError: Some do not fit their wall, or come too close to each other.
    """
    cuts: list[Cut] = []
    mistakes: list[tuple[Steps, str]] = []
    places: dict[str, Steps] = {cut.name: _OPENINGS for cut in before}
    for index, (name, opening) in enumerate(named_openings(openings)):
        places[name] = field = (*_OPENINGS, index)
        wall = _wall_of(opening, walls)
        if isinstance(wall, str):
            mistakes.append((field, wall))
            continue
        hole = hole_of(opening, wall, clockwise=clockwise)
        if reason := misfit(wall, wall.top(height, (hole.left, hole.right)), hole):
            said = f"{name} in {_words(wall)} {reason}; {_free(wall, clockwise)}"
            mistakes.append((field, said))
            continue
        how = (opening.open, opening.hinge, opening.swing, opening.style)
        cuts.append(Cut(name, opening.kind, wall, hole, *how, beyond=opening.beyond))
    clashes = _clashes([*before, *cuts], clockwise)
    mistakes += [(places[name], said) for name, said in clashes]
    if mistakes:
        raise FieldsError(*mistakes)
    return cuts


def _wall_of(opening: Opening, walls: Sequence[Wall]) -> Wall | str:
    """The wall that an opening names, or why there is none."""
    standing = {wall.partition: wall for wall in walls if wall.partition}
    outline = walls[: len(walls) - len(standing)]
    if opening.partition is not None:
        has = f"only {', '.join(map(str, standing))}" if standing else "the room has none"
        return standing.get(opening.partition) or (
            f"there is no partition {opening.partition}: {has}"
        )
    assert opening.wall is not None, "the description says where each opening is"
    if opening.wall < len(outline):
        return outline[opening.wall]
    return f"there is no wall {opening.wall}, only 0 to {len(outline) - 1}"


def _words(wall: Wall) -> str:
    return wall.partition or f"wall {wall.number}"


def hole_of(opening: Opening, wall: Wall, *, clockwise: bool) -> Hole:
    """The hole that a described opening makes in its wall, whether it fits or not.

    Args:
        opening: As it is described.
        wall: Its wall.
        clockwise: Whether the polygon was given clockwise.
    """
    width, height, sill = (
        default if given is None else given
        for given, default in zip(
            (opening.width, opening.height, opening.sill), USUAL_OPENINGS[opening.kind], strict=True
        )
    )
    at = 0.5 * wall.length if opening.at is None else opening.at
    middle = _from_start(wall, at, clockwise)
    return Hole(middle - 0.5 * width, middle + 0.5 * width, sill, sill + height)


def _from_start(wall: Wall, at: float, clockwise: bool) -> float:
    """A distance from the wall's start to one from its left end, or back.

    Seen from inside, the walls of a polygon that runs counter-clockwise start on the right;
    partitions always start on the left.
    """
    return at if clockwise or wall.partition else wall.length - at


def _free(wall: Wall, clockwise: bool) -> str:
    low, high = free_span(wall)
    if low >= high:
        return "nothing can be cut into it"
    ends = sorted(_from_start(wall, end, clockwise) for end in (low, high))
    return f"from its start it is free between {ends[0]:.3f} m and {ends[1]:.3f} m"


def _clashes(cuts: Sequence[Cut], clockwise: bool) -> Iterator[tuple[str, str]]:
    """The later of two that overlap, and what is wrong."""
    for i, cut in enumerate(cuts):
        for other in cuts[:i]:
            if other.wall is cut.wall and too_close(other.hole, cut.hole):
                places = " and ".join(f"{c.name} {_extent(c, clockwise)}" for c in (other, cut))
                pair = f"{other.name} and {cut.name} in {_words(cut.wall)}"
                yield cut.name, f"{pair} overlap: {places}; move one, or make it narrower"


def _extent(cut: Cut, clockwise: bool) -> str:
    ends = sorted(_from_start(cut.wall, x, clockwise) for x in (cut.hole.left, cut.hole.right))
    across = f"{ends[0]:.3f} to {ends[1]:.3f} m from the wall's start"
    return f"({across}, {cut.hole.bottom:.3f} to {cut.hole.top:.3f} m high)"


def captured_cuts(
    openings: Sequence[CapturedOpening],
    walls: Sequence[Wall],
    height: float,
    *,
    described: Sequence[Opening],
    notes: list[str],
    partitions: Mapping[str, str] = NO_PARTITIONS,
) -> list[Cut]:
    """The holes of captured openings, made to fit: moved to their wall, clamped, merged.

    Args:
        openings: As they were captured.
        walls: Those of the outline, then those that stand free.
        height: Floor to ceiling, metres.
        described: The openings of the description, whose names stay theirs.
        notes: Receives a sentence for everything that was changed.
        partitions: The names of captured partitions by their identifiers in the source.

    Returns:
        The openings in order.
    """
    found: list[tuple[CapturedOpening, Wall, Hole]] = []
    # Before anything is dropped or merged: what depends on the walls must rename no opening.
    taken = {name for name, _ in named_openings(described)}
    given = captured_names([(opening.kind, opening.id) for opening in openings], taken)
    name_of = {id(opening): name for opening, name in zip(openings, given, strict=True)}
    for opening in openings:
        wall = _nearest_wall(opening, _possible(opening, walls, partitions))
        if wall is None:
            notes.append(f"dropped the {opening.kind} {opening.id}: no wall is near it")
            continue
        whole = _captured_hole(opening, wall)
        hole = clamped(wall, wall.top(height, (whole.left, whole.right)), whole)
        if hole is None:
            notes.append(f"dropped the {opening.kind} {opening.id}: it does not fit its wall")
            continue
        lost = max(whole.right - hole.right + hole.left - whole.left, whole.top - hole.top)
        if lost > 1e-3:
            what = f"the {opening.kind} {opening.id} {100.0 * lost:.1f} cm smaller"
            notes.append(f"made {what}, to fit {_words(wall)}")
        found.append((opening, wall, hole))
    return [
        Cut(
            name_of[id(opening)],
            opening.kind,
            wall,
            hole,
            _AJAR_DEG if opening.is_open else 0.0,
            source=opening,
        )
        for opening, wall, hole in _merged(found, notes)
    ]


def _possible(
    opening: CapturedOpening, walls: Sequence[Wall], partitions: Mapping[str, str]
) -> Sequence[Wall]:
    """The walls that an opening can be in: its own partition, or where another is its own none."""
    if opening.wall is None:
        return walls
    own = partitions.get(opening.wall)
    return [wall for wall in walls if wall.partition == own]


def _nearest_wall(opening: CapturedOpening, walls: Sequence[Wall]) -> Wall | None:
    """The wall along an opening that is nearest to its middle."""

    def distance(wall: Wall) -> float:
        x, y = wall.from_plan(opening.center[:2])
        depth = np.clip(y, 0.0, wall.thickness) if wall.partition else 0.0
        return float(np.hypot(x - np.clip(x, 0.0, wall.length), y - depth))

    along = [w for w in walls if abs(float(w.along @ opening.direction[:2])) > _PARALLEL]
    nearest = min(along, key=distance, default=None)
    return nearest if nearest is not None and distance(nearest) < _REACH else None


def _captured_hole(opening: CapturedOpening, wall: Wall) -> Hole:
    x = float(wall.from_plan(opening.center[:2])[0])
    z, half = float(opening.center[2]), 0.5 * opening.width
    bottom, top = z - 0.5 * opening.height, z + 0.5 * opening.height
    if opening.kind != "window" and bottom < _MAX_THRESHOLD_M:
        bottom = 0.0
    return Hole(x - half, x + half, bottom, top)


def _merged(
    found: Sequence[tuple[CapturedOpening, Wall, Hole]], notes: list[str]
) -> Iterator[tuple[CapturedOpening, Wall, Hole]]:
    """Join openings of one wall that overlap; doors win over windows, windows over openings."""
    rank = list(USUAL_OPENINGS)
    groups: list[list[tuple[CapturedOpening, Wall, Hole]]] = []
    for item in found:
        touching = [g for g in groups if g[0][1] is item[1] and too_close(_box(g), item[2])]
        groups = [g for g in groups if g not in touching]
        groups.append([row for group in touching for row in group] + [item])
    order = {id(item[0]): i for i, item in enumerate(found)}
    for group in sorted(groups, key=lambda g: min(order[id(row[0])] for row in g)):
        best = min(group, key=lambda row: (row[0].kind != "door", rank.index(row[0].kind)))
        if len(group) > 1:
            ids = " and ".join(row[0].id for row in group)
            notes.append(f"merged the overlapping openings {ids} in {_words(best[1])}")
        yield best[0], best[1], _box(group)


def _box(group: Sequence[tuple[CapturedOpening, Wall, Hole]]) -> Hole:
    return around([hole for _, _, hole in group])
