"""What hangs on the walls and from the ceiling once the furniture stands."""

from itertools import pairwise
from typing import Final

import numpy as np

from openrooms_usd.furniture import Size, category, styles
from openrooms_usd.generation.boxes import overlap
from openrooms_usd.generation.items import Item
from openrooms_usd.generation.kit import Kit
from openrooms_usd.generation.placement import Arrangement
from openrooms_usd.generation.shell import Shell
from openrooms_usd.geometry.floorplan import room_centre

# Between what hangs and anything else, metres.
_HANGING_GAP_M: Final = 0.08
_MAX_TRIES: Final = 30
# One ceiling lamp for this much floor, square metres; and the least height to walk below it.
_FLOOR_PER_LAMP_M2: Final = 14.0
_LAMP_HEADROOM_M: Final = 2.05
_MAX_LAMPS: Final = 40
# Between two beams lamps hang in bays that are at least so wide, metres.
_NARROWEST_BAY_M: Final = 0.3
# What fits where larger lamps do not, metres.
_SMALL_LAMP_WIDTH_M: Final = 0.35


def hang(
    room: Arrangement, kit: Kit, wanted: tuple[tuple[str, int, int], ...]
) -> list[Item]:  # fmt: skip
    """Hang pictures, clocks, boards and lamps where the walls are free.

    Args:
        room: The furnished room.
        kit: Builds them.
        wanted: Category, least and greatest number.
    """
    made: list[Item] = []
    for name, least, most in wanted:
        for _ in range(int(kit.rng.integers(least, most + 1))):
            found = _hang(room, kit, name)
            if found and room.add(found):
                made.append(found)
    return made


def _hang(room: Arrangement, kit: Kit, name: str) -> Item | None:
    spec = category(name)
    size, style = kit.make(name) if spec.one_variant_per_room else (kit.size(name), "")
    low = round(spec.mount_height + float(kit.rng.uniform(-0.05, 0.1)), 2)
    if low + size[2] > min(room.shell.height - 0.1, room.shell.clear_height - 0.02):
        return None
    style = style or kit.style(name, size)
    sides = room.shell.sides
    weights = np.array([max(0.0, side.length - size[0] - 0.2) for side in sides])
    if not weights.any():
        return None
    for _ in range(_MAX_TRIES):
        side = sides[int(kit.rng.choice(len(sides), p=weights / weights.sum()))]
        half = 0.5 * size[0] + 0.1
        at = float(kit.rng.uniform(half, side.length - half))
        x, y = side.point(at, 0.5 * size[1]).tolist()
        item = kit.item(name, x, y, side.yaw, size=size, style=style, z=low, on="wall")
        if _is_free(room, item):
            return item
    return None


def _is_free(room: Arrangement, item: Item) -> bool:
    box = item.box[None]
    away = overlap(box, room.shell.kept, _HANGING_GAP_M).any()
    away |= overlap(box, room.shell.attached, 0.01).any()
    away |= overlap(box, room.shell.walls, -0.002).any()
    away |= item.category == "wall_lamp" and room.is_splashed(box)
    return not away and room.shows(box, _HANGING_GAP_M)


def ceiling_lamps(room: Arrangement, kit: Kit) -> list[Item]:
    """Lamps of one make on a grid over the floor; at least one."""
    shell = room.shell
    style = kit.style("ceiling_lamp")
    size = kit.size("ceiling_lamp", style=style)
    size = (size[0], size[1], round(min(size[2], max(0.08, shell.height - _LAMP_HEADROOM_M)), 2))
    style = style if style in styles("ceiling_lamp", size) else kit.style("ceiling_lamp", size)
    places = [_between_beams(room.shell, x, y) for x, y in _grid(room.shell)]
    made = _add_wall_lamps(room, kit, [(size, style)] * _MAX_LAMPS, list(dict.fromkeys(places)))
    if not made:
        small = (min(size[0], _SMALL_LAMP_WIDTH_M), min(size[1], _SMALL_LAMP_WIDTH_M), size[2])
        x, y = _between_beams(room.shell, *room_centre(room.shell.corners).tolist())
        made = _add_wall_lamps(room, kit, [(small, kit.style("ceiling_lamp", small))], [(x, y)])
    if made:
        room.solids = np.concatenate([room.solids, [item.box for item in made]])
    return made


def _add_wall_lamps(
    room: Arrangement, kit: Kit, makes: list[tuple[Size, str]], places: list[tuple[float, float]]
) -> list[Item]:
    """Lamps at those of some places where they hang clear of walls and furniture."""
    made: list[Item] = []
    for (size, style), (x, y) in zip(makes, places, strict=False):
        z = round(room.shell.height - size[2], 3)
        item = kit.item(
            "ceiling_lamp", round(x, 2), round(y, 2), size=size, style=style, z=z, on="ceiling"
        )
        box = item.box[None]
        clear = bool(room.shell.contains(box[:, :2])[0])
        clear &= not overlap(box, room.shell.walls, 0.1).any()
        clear &= not overlap(kit.slices(item), room.shell.attached, 0.01).any()
        if clear and not (len(room.solids) and overlap(box, room.solids, 0.05).any()):
            made.append(item)
    return made


def _between_beams(shell: Shell, x: float, y: float) -> tuple[float, float]:
    """The middle of the bay that is nearest to a place, where beams divide the ceiling."""
    place = [x, y]
    for axis in (0, 1):
        # Those that are thin along the axis divide it.
        beams = shell.beams[shell.beams[:, 4 + axis] < shell.beams[:, 5 - axis]]
        ends = [shell.corners[:, axis].min(), *sorted(beams[:, axis]), shell.corners[:, axis].max()]
        middles = [0.5 * (a + b) for a, b in pairwise(ends) if b - a > _NARROWEST_BAY_M]
        if len(beams) and middles:
            place[axis] = min(middles, key=lambda middle: abs(middle - place[axis]))
    return float(place[0]), float(place[1])


def _grid(shell: Shell) -> list[tuple[float, float]]:
    """Places spread over the room's bounding box, one for each `_FLOOR_PER_LAMP_M2` of its area."""
    low, high = shell.corners.min(axis=0), shell.corners.max(axis=0)
    sides = high - low
    counts = np.maximum(1, np.round(sides / np.sqrt(_FLOOR_PER_LAMP_M2))).astype(int).tolist()
    x, y = (low[i] + sides[i] * (np.arange(n) + 0.5) / n for i, n in enumerate(counts))
    return [(float(px), float(py)) for py in y for px in x]
