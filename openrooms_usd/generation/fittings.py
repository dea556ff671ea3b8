"""What is screwed to walls and ceilings: radiators, vents, sockets, switches, thermostats, roses.

Heights are those of practice: switches at 1.05 to 1.2 m on the handle's side of doors, sockets with
their middle at 30 cm, or 20 cm above worktops; radiators stay 10 cm below sills.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture import Size
from openrooms_usd.generation.boxes import overlap
from openrooms_usd.generation.items import Item
from openrooms_usd.generation.kit import Kit
from openrooms_usd.generation.placement import Arrangement
from openrooms_usd.generation.shell import Gap, Side
from openrooms_usd.library.styles.assignment.weights import drawn
from openrooms_usd.library.styles.interiors import ShellStyle

# Rooms without heating, and those with sockets beside basins alone.
_UNHEATED: Final = frozenset({"closet", "garage", "storage"})
_WET: Final = frozenset({"bathroom"})
_BASINS: Final = ("sink",)
_WET_SOCKET_Z_M: Final = 1.1
# What sockets are beside.
_POWERED: Final = ("bed", "desk", "cabinet")
# How often a ceiling has a detector, how far from a lamp it is, and in how many directions.
_DETECTED: Final = 0.8
_BESIDE_LAMP_M: Final = 0.9
_TURNS: Final = 8
_RADIATOR_Z_M: Final = 0.12
_BELOW_SILL_M: Final = 0.1
_LOWEST_RADIATOR_M: Final = 0.3
_WIDTHS_M: Final = (0.5, 1.6)
_HEATED_M2: Final = 18.0  # floor for each radiator or vent
# Between fittings and corners, casings, each other; and from socket to socket; metres.
_BESIDE_M: Final = 0.06
_SOCKETS_M: Final = (2.2, 3.2)
_NEAREST_SOCKET_M: Final = 0.9
_SOCKET_Z_M: Final = 0.26
_WORKTOP_SOCKETS_M: Final = 1.0
_ABOVE_WORKTOP_M: Final = 0.16
# Sockets by beds are above the tables there, metres.
_BEDSIDE_SOCKET_Z_M: Final = 0.68
# Nothing stands before a switch, a socket and a thermostat to this distance, metres.
_REACHED_M: Final = 0.32
_PLUGGED_M: Final = 0.06
_READ_M: Final = 0.13
_THERMOSTAT_Z_M: Final = 1.4
# Half of the hole in a rose, which takes a lamp's canopy; metres.
_ROSE_HOLE_M: Final = 0.075


@dataclass
class Fitter:
    """Screws things on.

    Attributes:
        room: The furnished room; takes in what is added.
        kit: Builds the things.
        taste: How the room is finished.
        room_type: One of the 27.
    """

    room: Arrangement
    kit: Kit
    taste: ShellStyle
    room_type: str

    def heating(self) -> list[Item]:
        """Radiators below windows, or vents in the walls; before curtains are hung."""
        if self.room_type in _UNHEATED:
            return []
        style = drawn(self.kit.rng, self.taste.heaters)
        wanted = max(1, round(self.room.shell.area / _HEATED_M2))
        if style == "none":
            return self._vents(wanted)
        made = [item for gap in self._windows() if (item := self._below(gap, style))]
        return made or self._somewhere(style)

    def wiring(self, ceiling_lamps: list[Item]) -> list[Item]:
        """All the rest, when everything else stands and hangs."""
        made = self._switches()
        made += self._thermostat(made)
        made += self._outlets()
        made += self._sockets()
        return made + self._above(ceiling_lamps)

    def _windows(self) -> list[Gap]:
        return [gap for gap in self.room.shell.gaps if gap.kind == "window"]

    def _below(self, gap: Gap, style: str) -> Item | None:
        """A radiator below a window, unless something stands there."""
        usual = self.kit.size("radiator", style=style)
        height = min(usual[2], gap.sill - _BELOW_SILL_M - _RADIATOR_Z_M)
        if height < _LOWEST_RADIATOR_M or gap.sill > 1.5:
            return None
        width = float(np.clip(0.85 * gap.width, *_WIDTHS_M))
        size = (round(width, 2), usual[1], round(height, 2))
        return self._heater(self.room.shell.sides[gap.side], gap.at, size, style)

    def _somewhere(self, style: str) -> list[Item]:
        """One on a wall that is free, where no window has one."""
        usual = self.kit.size("radiator", style=style)
        size = (0.8, usual[1], usual[2])
        for side, at in self._places(size[0]):
            if item := self._heater(side, at, size, style):
                return [item]
        return []

    def _places(self, width: float) -> Iterator[tuple[Side, float]]:
        """Places along the longest walls first."""
        for side in sorted(self.room.shell.sides, key=lambda side: -side.length):
            low, high = 0.5 * width + 0.15, side.length - 0.5 * width - 0.15
            if high > low:
                yield from ((side, float(at)) for at in np.linspace(low, high, 5)[[2, 1, 3, 0, 4]])

    def _heater(self, side: Side, at: float, size: Size, style: str) -> Item | None:
        item = self._item("radiator", side, at, size, style, _RADIATOR_Z_M)
        box = item.box[None]
        shell = self.room.shell
        blocked = overlap(box, shell.walls, -0.002).any() or overlap(box, shell.kept, 0.01).any()
        blocked |= len(self.room.solids) > 0 and overlap(box, self.room.solids, 0.03).any()
        # Brackets and pipes are above skirting; panelling is in their way.
        panelling = shell.fixed[
            (shell.fixed[:, 6] == 0.0) & (shell.fixed[:, 7] > _LOWEST_RADIATOR_M)
        ]
        blocked |= overlap(box, panelling).any() | self._is_hung_above(box)
        return item if not blocked and self.room.add(item) else None

    def _is_hung_above(self, box: Array) -> bool:
        """Whether something of a group hangs where a radiator's heat would rise to it."""
        hung = [item.box for _, group in self.room.items for item in group if item.on == "wall"]
        column = box.copy()
        column[:, 7] = self.room.shell.height
        return bool(hung) and bool(overlap(column, np.array(hung)).any())

    def _vents(self, wanted: int) -> list[Item]:
        size, style = self.kit.make("wall_vent")
        made: list[Item] = []
        windows = [(self.room.shell.sides[gap.side], gap.at) for gap in self._windows()]
        for side, at in (*windows, *self._places(size[0])):
            if len(made) == wanted:
                break
            made += self._hang_flat("wall_vent", side, at, self._foot(0.06), size, style)
        return made

    def _foot(self, above: float) -> float:
        """A height above the skirting, metres."""
        low = self.room.shell.fixed[self.room.shell.fixed[:, 6] == 0.0, 7]
        return round(float(low.max(initial=0.0)) + above, 2)

    def _switches(self) -> list[Item]:
        """One beside each door, on the side of its handle where that is free."""
        size, style = self.kit.make("light_switch")
        middle = 1.05 + 0.05 * int(self.kit.rng.integers(0, 3))
        z = round(middle - 0.5 * size[2], 2)
        made: list[Item] = []
        for gap in self.room.shell.doors:
            side = self.room.shell.sides[gap.side]
            away = 0.5 * gap.width + self.room.shell.casing + _BESIDE_M + 0.5 * size[0]
            first = 1.0 if gap.hinge == "right" else -1.0
            for at in (gap.at + s * (away + more) for more in (0.0, 0.15) for s in (first, -first)):
                found = self._hang_flat("light_switch", side, at, z, size, style, _REACHED_M)
                if found:
                    made += found
                    break
        return made

    def _thermostat(self, switches: list[Item]) -> list[Item]:
        """Above a switch, as often as not."""
        if not self.kit.chance(0.5) or self.room_type in _UNHEATED:
            return []
        size, style = self.kit.make("thermostat")
        for item in switches:
            side = min(self.room.shell.sides, key=lambda s: _distance(s, item))
            at = float((np.array([item.x, item.y]) - side.start) @ side.along)
            made = self._hang_flat("thermostat", side, at, _THERMOSTAT_Z_M, size, style, _READ_M)
            if made:
                return made
        return []

    def _outlets(self) -> list[Item]:
        """Beside what a television stands on."""
        made: list[Item] = []
        size, style = self.kit.make("data_outlet")
        for item in self._standing(("television",)):
            carrier = next((other for _, group in self.room.items for other in group
                            if other.key == item.on), item)  # fmt: skip
            for side, at in self._beside(carrier, 0.25):
                found = self._hang_flat(
                    "data_outlet", side, at, _SOCKET_Z_M, size, style, _PLUGGED_M
                )
                if found:
                    made += found
                    break
        return made

    def _sockets(self) -> list[Item]:
        """Beside beds and desks, above worktops, and along the walls."""
        size, style = self.kit.make("socket")
        made: list[Item] = []
        for side, at, z in self._socket_places():
            x, y = side.point(at)
            near = [abs(o.x - x) + abs(o.y - y) for o in made if abs(o.z - z) < 0.3]
            if min(near, default=9.0) >= _NEAREST_SOCKET_M:
                made += self._hang_flat("socket", side, at, z, size, style, _PLUGGED_M)
        return made

    def _socket_places(self) -> Iterator[tuple[Side, float, float]]:
        """Walls, places along them and heights, the most wanted first; metres."""
        if self.room_type in _WET:
            for item in self._standing(_BASINS):
                yield from ((s, at, _WET_SOCKET_Z_M) for s, at in self._beside(item, 0.2))
            return
        for item in self._standing(_POWERED):
            z = _BEDSIDE_SOCKET_Z_M if item.category == "bed" else _SOCKET_Z_M
            yield from ((side, at, z) for side, at in self._beside(item, 0.14))
        for item in self._standing(("worktop",)):
            yield from self._over(item)
        for side in self.room.shell.sides:
            at = self.kit.between(0.4, 0.9)
            while at < side.length - 0.3:
                yield side, at, _SOCKET_Z_M
                at += self.kit.between(*_SOCKETS_M)

    def _standing(self, categories: tuple[str, ...]) -> list[Item]:
        return [i for _, group in self.room.items for i in group if i.category in categories]

    def _beside(self, item: Item, away: float) -> Iterator[tuple[Side, float]]:
        """Both sides of what stands with its back to a wall."""
        side = min(self.room.shell.sides, key=lambda s: _distance(s, item))
        if abs(_distance(side, item) - 0.5 * item.size[1]) > 0.3:
            return
        at = float((np.array([item.x, item.y]) - side.start) @ side.along)
        for s in (1.0, -1.0):
            yield side, at + s * (0.5 * item.size[0] + away)

    def _over(self, worktop: Item) -> list[tuple[Side, float, float]]:
        side = min(self.room.shell.sides, key=lambda s: _distance(s, worktop))
        at = float((np.array([worktop.x, worktop.y]) - side.start) @ side.along)
        z = round(worktop.z + worktop.size[2] + _ABOVE_WORKTOP_M, 2)
        count = max(1, int(worktop.size[0] / _WORKTOP_SOCKETS_M))
        offsets = (np.arange(count) - 0.5 * (count - 1)) * _WORKTOP_SOCKETS_M + 0.22
        return [(side, at + float(offset), z) for offset in offsets]

    def _above(self, lamps: list[Item]) -> list[Item]:
        """Roses around lamps that hang, and a detector beside them."""
        made: list[Item] = []
        if self.kit.chance(self.taste.rose):
            size, style = self.kit.make("ceiling_rose")
            for lamp in lamps:
                item = self._overhead("ceiling_rose", lamp.x, lamp.y, size, style)
                if self._fits_around(item, lamp):
                    made.append(self._occupy(item))
        if lamps and self.room_type not in _WET and self.kit.chance(_DETECTED):
            made += self._detector(lamps[0])
        return made

    def _detector(self, lamp: Item) -> list[Item]:
        size, style = self.kit.make("smoke_detector")
        for turn in self.kit.rng.permutation(_TURNS).tolist():
            angle = 2.0 * np.pi * turn / _TURNS
            x, y = lamp.x + _BESIDE_LAMP_M * np.cos(angle), lamp.y + _BESIDE_LAMP_M * np.sin(angle)
            item = self._overhead("smoke_detector", float(x), float(y), size, style)
            if self._is_free_above(item):
                return [self._occupy(item)]
        return []

    def _overhead(self, name: str, x: float, y: float, size: Size, style: str) -> Item:
        z = round(self.room.shell.height - size[2], 3)
        return self.kit.item(name, round(x, 3), round(y, 3), size=size, style=style, z=z,
                             on="ceiling")  # fmt: skip

    def _is_free_above(self, item: Item) -> bool:
        box, shell = item.box[None], self.room.shell
        free = bool(shell.contains(box[:, :2])[0]) and not overlap(box, shell.walls, 0.3).any()
        free &= not overlap(box, shell.attached, 0.05).any()
        return free and not overlap(box, self.room.solids, 0.05).any()

    def _fits_around(self, item: Item, lamp: Item) -> bool:
        """Whether a lamp's canopy is all of it that comes near to its rose."""
        box, shell = item.box[None], self.room.shell
        if overlap(box, shell.walls, 0.05).any() or overlap(box, shell.attached, 0.02).any():
            return False
        parts = self.kit.slices(lamp)
        high = parts[parts[:, 7] > item.z - 0.01]
        return bool((np.hypot(high[:, 4], high[:, 5]) < 1.4 * _ROSE_HOLE_M).all()) and bool(
            (high[:, 4:6] < _ROSE_HOLE_M - 0.005).all()
        )

    def _hang_flat(
        self, name: str, side: Side, at: float, z: float, size: Size, style: str, reach: float = 0.0
    ) -> list[Item]:
        """A flat thing on a wall where nothing else is; none where something is."""
        item = self._item(name, side, at, size, style, z)
        inside = 0.5 * size[0] + 0.02 <= at <= side.length - 0.5 * size[0] - 0.02
        if not inside or self._is_cut(side, at, z, size):
            return []
        before = side.keep(at, size[0], max(reach, size[1]), z, z + size[2])[None]
        solids, shell = self.room.solids, self.room.shell
        taken = len(solids) > 0 and bool(overlap(before, solids, 0.001).any())
        taken |= bool(overlap(before, shell.fixed, 0.004).any())
        taken |= bool(overlap(item.box[None], shell.standing, -0.002).any())
        taken |= self.room.is_splashed(item.box[None])
        return [] if taken else [self._occupy(item)]

    def _is_cut(self, side: Side, at: float, z: float, size: Size) -> bool:
        """Whether an opening or its casing is there."""
        shell = self.room.shell
        beyond = shell.casing + 0.03 + 0.5 * size[0]
        return any(
            shell.sides[gap.side] is side
            and abs(gap.at - at) < 0.5 * gap.width + max(beyond, 0.07 + 0.5 * size[0])
            and gap.sill - shell.casing - 0.05 < z + size[2]
            and gap.top + shell.casing > z
            for gap in shell.gaps
        )

    def _item(self, name: str, side: Side, at: float, size: Size, style: str, z: float) -> Item:
        x, y = side.point(at, 0.5 * size[1]).tolist()
        return self.kit.item(
            name, x, y, side.yaw, size=size, style=style, z=z, on="wall", optional=True
        )

    def _occupy(self, item: Item) -> Item:
        solids: Array = np.concatenate([self.room.solids, item.box[None]])
        self.room.solids = solids
        return item


def _distance(side: Side, item: Item) -> float:
    """From an item's middle to a wall that it has its back to, metres; large for any other."""
    offset = np.array([item.x, item.y]) - side.start
    turned = abs((item.yaw - side.yaw + 180.0) % 360.0 - 180.0)
    beyond = max(0.0, -float(offset @ side.along), float(offset @ side.along) - side.length)
    return abs(float(offset @ side.inward)) + beyond + (99.0 if turned > 5.0 else 0.0)
