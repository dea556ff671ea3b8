"""A room from nothing: draw its shell, fill it group by group, and draw again what did not fit."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from openrooms_usd.description.styles import InteriorStyle
from openrooms_usd.draws import generator
from openrooms_usd.errors import InputError
from openrooms_usd.generation.boxes import Pose
from openrooms_usd.generation.clutter.living import add_clutter
from openrooms_usd.generation.coatracks import coat_racks
from openrooms_usd.generation.curtains import curtains
from openrooms_usd.generation.finishing import Finishing, finished, finishing, shell_style
from openrooms_usd.generation.fittings import Fitter
from openrooms_usd.generation.groups.kitchen import LEVEL_M, WALL_LOW_M
from openrooms_usd.generation.items import Item
from openrooms_usd.generation.kit import Kit
from openrooms_usd.generation.moments import closes
from openrooms_usd.generation.openings import openings
from openrooms_usd.generation.placement import Arrangement
from openrooms_usd.generation.polygons import floor_plan
from openrooms_usd.generation.programs import PROGRAMS, RoomProgram, Spec
from openrooms_usd.generation.shapes import Shapes
from openrooms_usd.generation.shell import WALL_THICKNESS, Shell
from openrooms_usd.generation.walls import ceiling_lamps, hang
from openrooms_usd.library.styles.assignment.weights import drawn
from openrooms_usd.library.styles.interiors import INTERIORS, Interior
from openrooms_usd.spelling import did_you_mean

# What is screwed on through tiles is flush to the wall, and may sink in by so much.
_THICK_M: Final = 0.004
# What windows keep for their casing and sill, metres.
_CASING_M: Final = 0.12
# No strip is narrower or lower, metres.
_LEAST_M: Final = 0.06

# First and last place along a wall, and the upper edge; metres.
_Strip = tuple[float, float, float]


def backsplashes(room: Arrangement, kit: Kit) -> list[Item]:
    """A strip above every worktop at a wall, up to wall cabinets or to the sill of a window."""
    tops = [item for _, items in room.items for item in items if item.category == "worktop"]
    return [item for top in tops for item in _above(room.shell, kit, top)]


def _above(shell: Shell, kit: Kit, top: Item) -> Iterator[Item]:
    index, at = _behind(shell, top)
    side, half = shell.sides[index], 0.5 * top.size[0]
    for first, last, high in _strips(shell, index, max(at - half, 0.0),
                                     min(at + half, side.length)):  # fmt: skip
        if last - first < _LEAST_M or high - LEVEL_M < _LEAST_M:
            continue
        size = (round(last - first, 3), _THICK_M, round(high - LEVEL_M, 3))
        x, y = side.point(0.5 * (first + last), 0.5 * _THICK_M).tolist()
        yield kit.item("backsplash", round(x, 4), round(y, 4), side.yaw, size=size, style="panel",
                       z=LEVEL_M, on="wall", optional=True)  # fmt: skip


def _behind(shell: Shell, top: Item) -> tuple[int, float]:
    """The wall at the back of a worktop, and where along it the worktop's middle is, metres."""
    back = np.array(top.at(0.0, 0.5 * top.size[1]))
    offsets = [back - side.start for side in shell.sides]
    away = [
        abs(offset @ side.inward) + 9.0 * abs(np.sin(np.radians(0.5 * (side.yaw - top.yaw))))
        for offset, side in zip(offsets, shell.sides, strict=True)
    ]
    index = int(np.argmin(away))
    return index, float(offsets[index] @ shell.sides[index].along)


def _strips(shell: Shell, index: int, first: float, last: float) -> Iterator[_Strip]:
    """The length cut at the windows of its wall."""
    windows = sorted(
        (gap for gap in shell.gaps if gap.side == index and gap.kind == "window"),
        key=lambda gap: gap.at,
    )
    for gap in windows:
        reach = 0.5 * gap.width + _CASING_M
        a, b = max(first, gap.at - reach), min(last, gap.at + reach)
        if b <= a or gap.sill - _CASING_M > WALL_LOW_M:
            continue
        yield first, a, WALL_LOW_M
        yield a, b, min(gap.sill - _CASING_M, WALL_LOW_M)
        first = b
    yield first, last, WALL_LOW_M


# How often a room is drawn again when what it is for found no place.
_MAX_DRAFTS: Final = 6
# What a group asks for at each try: 0 is all that it likes, 1 as little as can be.
_MODESTY: Final = {True: (0.0, 0.3, 0.6, 0.9), False: (0.0, 0.6)}
# Groups of things that have nothing to do with each other.
ON_WALLS: Final = "on the walls"
FITTINGS: Final = "fittings"
LIGHT: Final = "light"
USUAL_CLUTTER: Final = 2
"""Default amount of clutter in generated rooms: lived in."""
LEAST_AREA: Final = 2.0
MOST_AREA: Final = 400.0


@dataclass(frozen=True, eq=False)
class Furnishing:
    """What stands in a room.

    Attributes:
        groups: Titles and items, in the room's frame.
        missing: How many groups found no place that the room is for.
    """

    groups: list[tuple[str, list[Item]]]
    missing: int


@dataclass(frozen=True, eq=False)
class Generated:
    """A room from nothing.

    Attributes:
        room_type: One of the 27.
        seed: What it was drawn by.
        shell: Its walls and openings.
        openings: The openings as the description has them.
        furnishing: What stands in it.
        style: What its furniture, materials and colours go together by; None: by nothing.
        clutter: How much lies about.
        finish: What its shell wears.
    """

    room_type: str
    seed: int
    shell: Shell
    openings: list[dict[str, Any]]
    furnishing: Furnishing = field(default_factory=lambda: Furnishing([], 0))
    style: InteriorStyle | None = None
    clutter: int = 0
    finish: Finishing = field(default_factory=Finishing)

    @property
    def interior(self) -> Interior | None:
        """What rooms of its style have."""
        return INTERIORS[self.style] if self.style else None


def program_of(room_type: str) -> RoomProgram:
    """What a kind of room is like.

    Raises:
        InputError: There is no such kind.
    """
    if room_type not in PROGRAMS:
        raise InputError(
            f"no room type is named {room_type!r}{did_you_mean(room_type, PROGRAMS)}",
            remedy=f"known: {', '.join(PROGRAMS)}",
        )
    return PROGRAMS[room_type]


def style_of(room_type: str, seed: int) -> InteriorStyle:
    """The style of a generated room if none is given."""
    rng = generator(seed, "generate", room_type, "style")
    return drawn(rng, dict.fromkeys(INTERIORS, 1.0))


def generate(
    room_type: str,
    seed: int,
    area: float | None = None,
    style: InteriorStyle | None = None,
    clutter: int = 0,
    *,
    seen: bool = True,
    shapes: Shapes | None = None,
    thickness: float = WALL_THICKNESS,
) -> Generated:
    """Make a room; equal arguments give equal rooms, in any process.

    Args:
        room_type: One of the 27.
        seed: Fixes everything that is drawn.
        area: Of the floor, square metres; drawn by default.
        style: Of furniture, materials and colours; drawn by default.
        clutter: How much lies about: 0 nothing, 1 tidy, 2 lived in, 3 messy.
        seen: Whether the room is seen at its own moment, by which curtains close.
        shapes: Takes in the forms of all things that are built on the way.
        thickness: Of the walls, metres.

    Raises:
        InputError: There is no such room type or style, or no room of that area can be made.
    """
    style = style or style_of(room_type, seed)
    if style not in INTERIORS:
        raise InputError(
            f"no style is named {style!r}{did_you_mean(style, INTERIORS)}",
            remedy=f"known: {', '.join(INTERIORS)}",
        )
    best: tuple[Generated, Arrangement] | None = None
    shapes = shapes or Shapes(seed)
    closed = seen and closes(room_type, seed)
    for attempt in range(_MAX_DRAFTS):
        shell, rows = draw_shell(room_type, seed, area, attempt, thickness)
        finish = finishing(room_type, seed, shell, style)
        shell = finished(shell, finish)
        made, room = _furnished(room_type, shapes, shell, attempt, style, closed)
        found = Generated(room_type, seed, shell, rows, made, style, finish=finish)
        if best is None or found.furnishing.missing < best[0].furnishing.missing:
            best = found, room
        if not best[0].furnishing.missing:
            break
    assert best is not None
    return _with_clutter(*best, shapes, clutter)


def _with_clutter(
    room: Generated, arrangement: Arrangement, shapes: Shapes, clutter: int
) -> Generated:
    """The same room with what lies about in it."""
    groups = add_clutter(
        room.furnishing.groups, arrangement, shapes, room.room_type, room.seed, clutter
    )
    made = Furnishing(groups, room.furnishing.missing)
    return replace(room, furnishing=made, clutter=clutter)


def draw_shell(
    room_type: str,
    seed: int,
    area: float | None = None,
    attempt: int = 0,
    thickness: float = WALL_THICKNESS,
) -> tuple[Shell, list[dict[str, Any]]]:
    """Walls and openings alone.

    Raises:
        InputError: There is no such room type, or no room of that area can be made.
    """
    program = program_of(room_type)
    if area is not None and not LEAST_AREA <= area <= MOST_AREA:
        raise InputError(
            f"a room of {area:g} m2 cannot be generated",
            remedy=f"give an area between {LEAST_AREA:g} and {MOST_AREA:g} square metres",
        )
    rng = generator(seed, "generate", room_type, "shell", attempt)
    least, usual, most = program.area
    wanted = float(rng.triangular(least, usual, most)) if area is None else area
    corners = floor_plan(rng, wanted, program.aspect, program.shapes)
    height = round(float(rng.uniform(*program.height)), 2)
    return openings(rng, Shell(corners, height, thickness=thickness), program)


def furnish(
    room_type: str, seed: int, shell: Shell, style: InteriorStyle | None = None, clutter: int = 0
) -> Generated:
    """Furniture for a given room, of a style where one is given.

    Raises:
        InputError: There is no such room type.
    """
    shapes = Shapes(seed)
    found = (_furnished(room_type, shapes, shell, attempt, style) for attempt in range(_MAX_DRAFTS))
    best = next(found)
    for other in found:
        if not best[0].missing:
            break
        best = min(best, other, key=lambda made: made[0].missing)
    made = Generated(room_type, seed, shell, [], best[0], style)
    return _with_clutter(made, best[1], shapes, clutter)


def _furnished(
    room_type: str,
    shapes: Shapes,
    shell: Shell,
    attempt: int,
    style: InteriorStyle | None,
    closed: bool = False,
) -> tuple[Furnishing, Arrangement]:
    program = program_of(room_type)
    room = Arrangement(shell)
    sides = np.ptp(shell.corners, axis=0)
    kit = Kit(
        generator(shapes.seed, "generate", room_type, "furniture", attempt), shapes, shell.height,
        (float(sides.max()), float(sides.min())), INTERIORS[style] if style else None,
        shell.clear_height, room_type,
    )  # fmt: skip
    missing = 0
    for want in program.wants:
        count = _count(want, shell.area, kit)
        if want.unless in [title for title, _ in room.items]:
            count = 0
        placed = sum(_place(room, kit, want, number < want.least) for number in range(count))
        missing += max(0, want.least - placed)
    own = replace(kit, rng=generator(shapes.seed, "generate", room_type, "fittings", attempt))
    fitter = Fitter(room, own, shell_style(style), room_type)
    heaters = fitter.heating()
    lamps = ceiling_lamps(room, kit)
    cloths = curtains(room, kit, room_type, program.curtains, closed)
    hooks = coat_racks(room, own, room_type)
    hung = [*hooks, *hang(room, kit, program.hangs)]
    tiles = backsplashes(room, kit)
    fitted = [*heaters, *fitter.wiring(lamps)]
    groups = [*room.items, (ON_WALLS, [*tiles, *cloths, *hung]), (FITTINGS, fitted), (LIGHT, lamps)]
    missing += not lamps
    return Furnishing([group for group in groups if group[1]], missing), room


def _count(want: Spec, area: float, kit: Kit) -> int:
    """How many groups of a kind a room gets."""
    if want.least == 0 and not kit.chance(want.chance):
        return 0
    if want.each:
        number = round(area / want.each * float(kit.rng.uniform(0.7, 1.2)))
    else:
        number = int(kit.rng.integers(max(want.least, 1), want.most + 1))
    return int(np.clip(number, want.least, want.most))


def _place(room: Arrangement, kit: Kit, want: Spec, needed: bool) -> bool:
    facing = _pose_of(room, want.faces)
    for modesty in _MODESTY[needed]:
        kit.modesty = modesty
        made = want.build(kit)
        group = kit.apart(made) if made else None
        if group is not None and room.place(group, kit.rng, facing):
            kit.modesty = 0.0
            kit.remember(group.items)
            return True
    kit.modesty = 0.0
    return False


def _pose_of(room: Arrangement, title: str) -> Pose | None:
    """Where the first item of a group stands."""
    for name, items in room.items:
        if title and name == title:
            return items[0].x, items[0].y, items[0].yaw
    return None


def named(groups: Sequence[tuple[str, Sequence[Item]]]) -> Iterator[tuple[str, str, Item, str]]:
    """Every item with its prim name: its category, and a number where there are several.

    Yields:
        The title of its group, its name, the item, and what carries it by name.
    """
    totals: dict[str, int] = {}
    for _, items in groups:
        for item in items:
            totals[item.category] = totals.get(item.category, 0) + 1
    numbers: dict[str, int] = {}
    for title, items in groups:
        names = {"floor": "floor", "ceiling": "ceiling", "wall": "wall"}
        for item in items:
            number = numbers.get(item.category, 0)
            numbers[item.category] = number + 1
            single = totals[item.category] == 1
            names[item.key] = item.category if single else f"{item.category}_{number}"
            yield title, names[item.key], item, names[item.on]
