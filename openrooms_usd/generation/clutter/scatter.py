"""Things on the surfaces of a room, drawn by the records of what lies there, level by level."""

from collections import Counter
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture import Size, category
from openrooms_usd.furniture.placements import Place, SurfacePlacement
from openrooms_usd.furniture.placements import Pose as Lying
from openrooms_usd.generation.boxes import Pose
from openrooms_usd.generation.clutter.amounts import ROOM_AMOUNTS, amount_of
from openrooms_usd.generation.clutter.forms import LevelFinder
from openrooms_usd.generation.clutter.ground import Ground
from openrooms_usd.generation.clutter.laying import (
    PosedObject,
    Taken,
    Tilt,
    item_at,
    places_on,
    posed_object,
)
from openrooms_usd.generation.clutter.making import ProductVariants, candidates
from openrooms_usd.generation.clutter.resting import rest_on
from openrooms_usd.generation.clutter.soft import Seat, drop, lean
from openrooms_usd.generation.clutter.spots import SupportSurface
from openrooms_usd.generation.items import Item, placed

# Turns from the direction of those who use a surface, degrees.
_TURNED: Final[dict[Lying, float]] = {"flat": 180.0, "on_back": 180.0, "on_side": 180.0}
_JITTER_DEG: Final = 14.0
_TILTS: Final[dict[Lying, Tilt]] = {"on_back": (-90.0, 0.0), "on_side": (0.0, 90.0)}
# Between the things of a row, least and most; how far they stand out of line, and how far their
# corners turn out of it; metres.
_ROW_GAPS_M: Final = (0.008, 0.03)
_ROW_SHIFT_M: Final = 0.012
_ROW_SWING_M: Final = 0.006
# What comes no farther out of a circle is round, metres.
_ROUND_M: Final = 0.002
# How much a stack's things are turned and shifted against each other.
_STACK_TURN_DEG: Final = 6.0
_STACK_SHIFT_M: Final = 0.006
# How much likelier things become whose company lies there already.
_COMPANY: Final = 4.0
# How much less likely, where there are such already.
_SAME_AGAIN: Final = 2.0
_HIGHEST_ON_SEAT_M: Final = 0.6
_TRIES_ON_SEAT: Final = 5
# Nothing reaches higher: there may be beams, cornices and lamps.
_BELOW_CEILING_M: Final = 0.3
_MAX_STACK_M: Final = 0.4
# A thing that falls this far below the top of what it is stacked on lies beside it, metres.
_MAX_SINK_M: Final = 0.03


@dataclass
class Scatter:
    """Lays things on the surfaces of a room.

    Attributes:
        rng: Draws them; another one at each level.
        surfaces: Knows the forms of things.
        variants: What the room has.
        taken: What takes up space already.
        room_type: One of the 27.
        ceiling: Height of the room, metres.
        counts: How many there are of each category.
        added: What was laid, with the group of its carrier.
    """

    rng: np.random.Generator
    surfaces: LevelFinder
    variants: ProductVariants
    taken: Taken
    room_type: str
    ceiling: float
    counts: Counter[str]
    added: list[tuple[int, Item]] = field(default_factory=list)
    _company: dict[int, list[tuple[str, Array, str]]] = field(default_factory=dict)
    _used: dict[tuple[str, SurfacePlacement], int] = field(default_factory=dict)
    _keys: dict[str, int] = field(default_factory=dict)

    def fill(self, number: int, spot: SupportSurface, level: int) -> None:
        """Lay on a surface what a level adds.

        Args:
            number: The surface's, the same at all levels.
            spot: The surface.
            level: 1, 2 or 3.
        """
        for _ in range(self.count(spot.place, spot.level.area, level)):
            drawn = self.drawn(number, spot.place, level)
            if drawn is not None:
                self._lay(number, spot, *drawn)

    def place_on_seat(self, number: int, seat: Seat, level: int) -> None:
        """Lay on a seat or a bed what a level adds.

        Args:
            number: The seat's, the same at all levels.
            seat: The seat.
            level: 1, 2 or 3.
        """
        for _ in range(self.count(seat.place, seat.area, level)):
            drawn = self.drawn(number, seat.place, level)
            if drawn is None:
                continue
            name, placement = drawn
            x0, x1, y0, y1 = seat.reach
            make = self.variants.draw(name, placement, (x1 - x0, y1 - y0, _HIGHEST_ON_SEAT_M))
            if make is None:
                continue
            leans = placement.pose == "leaning"
            tilt = (-float(self.rng.uniform(4.0, 16.0)), 0.0) if leans else (0.0, 0.0)
            thing = posed_object(self.surfaces, name, make, _TILTS.get(placement.pose, tilt))
            for _ in range(_TRIES_ON_SEAT):
                laid = (lean if leans else drop)(seat, thing, self.key(name), self.rng)
                if laid is None:
                    continue
                item, _ = laid
                box = thing.standing((item.x, item.y, item.yaw), item.z + float(thing.low[2]))
                if not len(self.taken.near(box, {seat.carrier.key})):
                    self.note(number, *drawn)
                    self.add(seat.group, item, box)
                    break

    def stand(self, ground: Ground, place: Place, group: int, level: int) -> None:
        """Put on the floor, or hang on the walls, what a level adds.

        Args:
            ground: The room's floor and walls.
            place: ``wall`` or one of the floor.
            group: The index of the group that takes it.
            level: 1, 2 or 3.
        """
        low, high = ROOM_AMOUNTS[place][level - 1]
        for _ in range(int(self.rng.integers(low, high + 1))):
            drawn = self.drawn(-1 - list(ROOM_AMOUNTS).index(place), place, level)
            make = self.variants.draw(*drawn) if drawn else None
            if drawn is None or make is None:
                continue
            name, placement = drawn
            thing = posed_object(self.surfaces, name, make, _TILTS.get(placement.pose, (0.0, 0.0)))
            z = 0.0
            if place == "wall":
                z = (category(name).mount_height or 1.3) + float(self.rng.uniform(-0.1, 0.15))
            pose = ground.hang(thing, z) if place == "wall" else ground.place(place, thing)
            if pose is None:
                continue
            carrier = "wall" if place == "wall" else "floor"
            item = item_at(thing, self.key(name), pose, round(z, 3), carrier)
            self._used[drawn] = self._used.get(drawn, 0) + 1
            self.add(group, item, thing.standing((item.x, item.y, item.yaw), z))

    def count(self, place: Place, area: float, level: int) -> int:
        """How many things, stacks or rows a level adds to a surface."""
        amount = amount_of(place)
        if self.rng.random() > amount.chance:
            return 0
        usual = min(amount.most, area * amount.each) * float(self.rng.uniform(0.7, 1.3))
        wanted = usual * amount.shares[level - 1]
        return int(wanted + self.rng.random())

    def drawn(self, number: int, place: Place, level: int) -> tuple[str, SurfacePlacement] | None:
        """What to lay next: likelier what goes with what is there, less likely what is there."""
        rows = [
            row
            for row in candidates(place, self.room_type, level)
            if self._used.get(row, 0) < row[1].max_groups and self.left(row[0]) > 0
        ]
        if not rows:
            return None
        company = self._company.get(number, [])
        clusters = {cluster for cluster, _, _ in company}
        here = Counter(name for _, _, name in company)
        weights = [
            placement.weight
            * (_COMPANY if placement.cluster and placement.cluster in clusters else 1.0)
            / (1.0 + self._used.get((name, placement), 0) + _SAME_AGAIN * here[name])
            for name, placement in rows
        ]
        share = np.cumsum(weights) / np.sum(weights)
        return rows[int(np.searchsorted(share, self.rng.random()))]

    def left(self, name: str) -> float:
        """How many more of a category the room may have."""
        most = category(name).max_per_room
        return np.inf if most is None else most - self.counts[name]

    def _lay(
        self, number: int, spot: SupportSurface, name: str, placement: SurfacePlacement
    ) -> None:
        count = int(self.rng.integers(placement.count[0], placement.count[1] + 1))
        count = int(min(count, self.left(name)))
        room = self._room_on(spot)
        make = self.variants.draw(name, placement, room)
        if make is None:
            return
        thing = posed_object(self.surfaces, name, make, _TILTS.get(placement.pose, (0.0, 0.0)))
        if placement.pose == "row":
            laid = self._row(number, spot, self._beside(thing, placement, count, room), placement)
        elif placement.pose == "stacked":
            laid = self._stack(number, spot, thing, placement, count, room)
        else:
            laid = []
            for index in range(count):
                # What lies together is alike only where a room has one make of it.
                other = (
                    self.variants.draw(name, placement, room)
                    if index and placement.max_variants > 1
                    else None
                )
                if other is not None:
                    thing = posed_object(self.surfaces, name, other, thing.tilt)
                item = self._place_one(number, spot, thing, placement)
                laid += [item] if item is not None else []
        if laid:
            self._used[name, placement] = self._used.get((name, placement), 0) + 1

    def _room_on(self, spot: SupportSurface) -> Size:
        """Width, depth and height of what could stand on a surface at most."""
        (x0, y0), (x1, y1) = spot.reach
        high = float(spot.level.clear[spot.level.clear > 0.0].max())
        return x1 - x0, y1 - y0, min(high, 1.2) - 0.005

    def _place_one(
        self, number: int, spot: SupportSurface, thing: PosedObject, placement: SurfacePlacement
    ) -> Item | None:
        """One thing somewhere on a surface."""
        middle = self._place(number, spot, thing.size, placement)
        if middle is None:
            return None
        item = item_at(thing, self.key(thing.name), middle, spot.z, spot.carrier.key)
        self._take(number, spot, item, thing, middle, spot.z, placement)
        return item

    def _beside(
        self, first: PosedObject, placement: SurfacePlacement, count: int, room: Size
    ) -> list[PosedObject]:
        """What stands in a row: makes as the room has them."""
        made = [first]
        for _ in range(count - 1):
            make = self.variants.draw(first.name, placement, room)
            made.append(posed_object(self.surfaces, first.name, make) if make else first)
        return made

    def _row(
        self,
        number: int,
        spot: SupportSurface,
        things: list[PosedObject],
        placement: SurfacePlacement,
    ) -> list[Item]:
        """Several side by side, a little out of line; fewer where there is no space."""
        gaps = self.rng.uniform(*_ROW_GAPS_M, len(things)).tolist()
        for n in range(len(things), 0, -1):
            sizes = np.array([thing.size for thing in things[:n]])
            whole = float(sizes[:, 0].sum()) + sum(gaps[: n - 1])
            depth = float(sizes[:, 1].max()) + 2.0 * _ROW_SHIFT_M
            middle = self._place(number, spot, (whole, depth, float(sizes[:, 2].max())), placement)
            if middle is None:
                continue
            laid, x = [], -0.5 * whole
            for thing, gap in zip(things[:n], gaps, strict=False):
                spread = 180.0 if _is_round(thing) else np.degrees(_ROW_SWING_M / thing.size[1])
                y = float(self.rng.uniform(-_ROW_SHIFT_M, _ROW_SHIFT_M))
                turn = float(self.rng.uniform(-spread, spread))
                one = (*placed(middle, x + 0.5 * thing.size[0], y), middle[2] + turn)
                item = item_at(thing, self.key(thing.name), one, spot.z, spot.carrier.key)
                self._take(number, spot, item, thing, one, spot.z, placement)
                laid.append(item)
                x += thing.size[0] + gap
            return laid
        return []

    def _stack(
        self,
        number: int,
        spot: SupportSurface,
        thing: PosedObject,
        placement: SurfacePlacement,
        count: int,
        room: Size,
    ) -> list[Item]:
        """Several on top of each other, none larger than the one below."""
        width, depth, height = thing.size
        clear = min(room[2], _MAX_STACK_M, count * (height + 0.01))
        more = 2 * _STACK_SHIFT_M + np.hypot(width, depth) * np.sin(np.radians(_STACK_TURN_DEG))
        size = (width + more, depth + more, max(clear, height))
        base = self._place(number, spot, size, placement)
        if base is None:
            return []
        laid: list[Item] = []
        z, carrier, below, middle = spot.z, spot.carrier.key, thing, base
        for index in range(count):
            upper = thing if index == 0 else self._next(below, placement, room[2])
            if upper is None:
                break
            if index:
                turn = float(self.rng.uniform(-_STACK_TURN_DEG, _STACK_TURN_DEG))
                turn += 90.0 * ((upper.size[0] > upper.size[1]) != (width > depth))
                shift = self.rng.uniform(-_STACK_SHIFT_M, _STACK_SHIFT_M, 2).tolist()
                there = (*placed(base, shift[0], shift[1]), base[2] + turn)
                rise = self._rise(below, upper, _within(middle, there))
                if rise < below.size[2] - _MAX_SINK_M or z + rise + upper.size[2] > spot.z + clear:
                    break
                middle, z = there, z + rise
            item = item_at(upper, self.key(thing.name), middle, z, carrier)
            self._take(number, spot, item, upper, middle, z, placement)
            laid.append(item)
            carrier, below = item.key, upper
        return laid

    def _next(
        self, below: PosedObject, placement: SurfacePlacement, high: float
    ) -> PosedObject | None:
        """What may lie on top of something: no larger than that."""
        width, depth, _ = below.make[0]
        make = self.variants.draw(below.name, placement, (width + 0.002, depth + 0.002, high))
        return posed_object(self.surfaces, below.name, make) if make else None

    def _rise(self, below: PosedObject, upper: PosedObject, pose: Pose) -> float:
        """How far above the lowest point of a thing that of another comes to rest on it."""
        origin = rest_on(below.corners, upper.above(pose))
        return origin + float(upper.low[2]) - float(below.low[2])

    def _place(
        self,
        number: int,
        spot: SupportSurface,
        size: tuple[float, float, float],
        placement: SurfacePlacement,
    ) -> Pose | None:
        (x0, y0), (x1, y1) = spot.reach
        if min(size[:2]) > min(x1 - x0, y1 - y0):
            return None
        if spot.z + size[2] > self.ceiling - _BELOW_CEILING_M:
            return None
        spread = _TURNED.get(placement.pose, _JITTER_DEG)
        yaws = self.rng.uniform(-spread, spread, 16)
        if spot.around:
            yaws = yaws + 90.0 * self.rng.integers(0, 4, 16)
        mates = [
            middle
            for cluster, middle, _ in self._company.get(number, [])
            if placement.cluster and cluster == placement.cluster
        ]
        near = np.array(mates).reshape(-1, 2)
        return places_on(
            spot, size, yaws, self.taken.near(spot.box, {spot.carrier.key}), near, self.rng
        )

    def _take(
        self,
        number: int,
        spot: SupportSurface,
        item: Item,
        thing: PosedObject,
        middle: Pose,
        z: float,
        placement: SurfacePlacement,
    ) -> None:
        self.add(spot.group, item, thing.standing((item.x, item.y, item.yaw), z))
        back = (0.0, 0.0, -spot.pose[2])
        local = placed(back, middle[0] - spot.pose[0], middle[1] - spot.pose[1])
        self._company.setdefault(number, []).append(
            (placement.cluster, np.array(local), thing.name)
        )

    def add(self, group: int, item: Item, boxes: Array) -> None:
        """Take in what was laid."""
        self.added.append((group, item))
        self.counts[item.category] += 1
        self.taken.add(boxes, item.key)

    def note(self, number: int, name: str, placement: SurfacePlacement) -> None:
        """Remember that something was laid on a surface without places of its own."""
        self._used[name, placement] = self._used.get((name, placement), 0) + 1
        self._company.setdefault(number, []).append((placement.cluster, np.zeros(2), name))

    def key(self, name: str) -> str:
        """A new key."""
        self._keys[name] = self._keys.get(name, 0) + 1
        return f"{name} lying {self._keys[name]}"


def _is_round(thing: PosedObject) -> bool:
    """Whether it takes up the same however it is turned."""
    middle = 0.5 * (thing.low + thing.high)[:2]
    radius = np.linalg.norm(thing.points[:, :2] - middle, axis=1).max()
    return bool(radius < 0.5 * min(thing.size[:2]) + _ROUND_M)


def _within(frame: Pose, pose: Pose) -> Pose:
    """A pose in the frame of another."""
    x, y = placed((0.0, 0.0, -frame[2]), pose[0] - frame[0], pose[1] - frame[1])
    return x, y, pose[2] - frame[2]
