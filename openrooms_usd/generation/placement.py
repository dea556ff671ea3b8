"""Where groups stand: many candidates at once, the good ones first, none that blocks anything."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.generation.boxes import NONE, Pose, overlap, posed, reach
from openrooms_usd.generation.floor import Floor, floor_of
from openrooms_usd.generation.items import (
    HEADROOM_M,
    STEP_M,
    Group,
    Item,
    placed,
    with_dependants,
    wrapped,
)
from openrooms_usd.generation.shell import Shell

# Between furniture of different groups, metres.
_GROUP_GAP_M: Final = 0.03
# How many places for a group are tried on each wall, and in the room.
_ON_WALL, _IN_ROOM = 24, 220
# How many of the best places are checked for free paths.
_CHECKED_PLACES: Final = 8
# What is liked below a window, and how near to its middle that must be, metres.
_BELOW_WINDOW_TASTE, _BELOW_WINDOW_M = 1.5, 0.3
# Two walls are square to each other from this sine of the turn between them on.
_SQUARE_CORNER_SINE: Final = 0.9999
# Where the wall must be behind what hangs on it, metres.
_BEHIND_M: Final = 0.03
# Carriers that are parts of the room.
_ROOM: Final = ("floor", "wall", "ceiling")
# Narrower groups belong into corners, metres.
_CORNER_WIDTH_M: Final = 0.6
# Above these nothing hangs: what is splashed, and what is hot.
# Nothing electric is nearer to a bath or a shower (IEC 60364-7-701, zone 2), metres.
_DRY_M: Final = 0.6
_WET: Final = frozenset({"bathtub", "shower"})
_HOT: Final = frozenset({"hob", "radiator", "stove"})
# Between a hob and the wall behind it, metres.
_BEHIND_HOB_M: Final = 0.15
# The core of what hangs, as a share of its width and height, and how far people look at it from.
_CORE_SHARE, _LOOK_M = 0.5, 0.5


@dataclass
class Arrangement:
    """A room that fills.

    Attributes:
        shell: The room.
        items: What stands in it, in the room's frame, by group.
        wet: (W, 8) from the floor up, above what people bathe in.
        hot: (H, 8) likewise, above what is hot.
    """

    shell: Shell
    items: list[tuple[str, list[Item]]] = field(default_factory=list)
    solids: Array = field(default_factory=lambda: NONE)
    zones: Array = field(default_factory=lambda: NONE)
    wet: Array = field(default_factory=lambda: NONE)
    hot: Array = field(default_factory=lambda: NONE)
    access: list[tuple[float, float]] = field(default_factory=list)
    floor: Floor = field(init=False)

    def __post_init__(self) -> None:
        self.floor = floor_of(self.shell)

    def place(self, group: Group, rng: np.random.Generator, facing: Pose | None = None) -> bool:
        """Find a place for a group.

        Args:
            group: What to place; optional items that do not fit are left out.
            rng: Draws the candidates.
            facing: What it shall look at, when it may choose.

        Returns:
            Whether there was one.
        """
        poses, taste = self._candidates(group, rng, facing)
        if not len(poses):
            return False
        kept, possible = self._fits(group, poses)
        count = kept.sum(axis=1) - group.required.sum()
        score = np.where(possible, taste + 0.6 * count, -np.inf)
        order = np.argsort(-score, kind="stable")[:_CHECKED_PLACES]
        for row in order[score[order] > -np.inf]:
            x, y, yaw = poses[row].tolist()
            if self._settle(group, (x, y, yaw), kept[row].tolist()):
                return True
        return False

    def add(self, item: Item) -> bool:
        """Take in one more thing at its place, unless it narrows a path too much."""
        if not self.take(item.box[None]):
            return False
        self.know([item])
        return True

    def know(self, items: Iterable[Item]) -> None:
        """Remember above which things nothing hangs."""
        for item in items:
            column = item.box[None].copy()
            column[:, 6:] = -1.0, 99.0
            if item.category in _WET:
                self.wet = np.concatenate([self.wet, column])
            if item.category in _HOT:
                column[:, 5] += _BEHIND_HOB_M
                self.hot = np.concatenate([self.hot, column])

    def is_splashed(self, box: Array) -> bool:
        """Whether a (1, 8) box is where nothing electric may be: near a bath or a shower."""
        return bool(overlap(box, self.wet, _DRY_M).any())

    def shows(self, box: Array, gap: float) -> bool:
        """Whether what hangs in (1, 8) a box is clear of all else, and nothing hides it."""
        core = box.copy()
        core[:, 4] *= _CORE_SHARE
        core[:, 6:] += 0.5 * (1.0 - _CORE_SHARE) * (box[:, 7] - box[:, 6]) * np.array([1.0, -1.0])
        core[:, :2] += 0.5 * _LOOK_M * np.stack([core[:, 3], -core[:, 2]], axis=1)
        core[:, 5] += 0.5 * _LOOK_M
        return not (
            overlap(box, self.solids, gap).any()
            or overlap(core, self.solids).any()
            or overlap(box, self.wet, gap).any()
            or overlap(box, self.hot, gap).any()
        )

    def take(self, boxes: Array) -> bool:
        """Take up space, unless that narrows a path too much."""
        floor = self.floor.with_boxes(boxes)
        if (boxes[:, 6] < HEADROOM_M).any():
            reachable = floor.connected()
            if reachable is None or not floor.reaches(reachable, self.access):
                return False
        self.floor = floor
        self.solids = np.concatenate([self.solids, boxes])
        return True

    def _candidates(
        self, group: Group, rng: np.random.Generator, facing: Pose | None
    ) -> tuple[Array, Array]:
        """(P, 3) poses and (P,) how much each is liked."""
        make = {"wall": _wall_poses, "free": _free_poses}[group.anchor]
        poses, taste = make(self.shell, group, rng)
        if facing is not None:
            forward = np.radians(poses[:, 2] - 90.0)
            to = np.array(facing[:2]) - poses[:, :2]
            away = np.maximum(np.linalg.norm(to, axis=1), 1e-9)
            ahead = (to[:, 0] * np.cos(forward) + to[:, 1] * np.sin(forward)) / away
            taste = taste + 4.0 * ahead - 1.5 * np.abs(away - 2.6) / 2.6
        return poses, taste

    def _fits(self, group: Group, poses: Array) -> tuple[Mask, Mask]:
        """(P, N) which items can stay, and (P,) whether all needed ones can."""
        boxes = posed(group.boxes, poses)
        hung = np.array([item.on in ("wall", "ceiling") for item in group.items])
        low = boxes[..., 7] <= STEP_M
        free = ~overlap(boxes, self.shell.walls).any(axis=-1)
        free &= self.shell.contains(boxes[..., :2])
        on_top = np.array([item.on not in _ROOM for item in group.items])
        free &= on_top | ~overlap(boxes, self.shell.kept).any(axis=-1)
        free &= ~on_top | ~overlap(boxes, self.shell.kept_on_tops).any(axis=-1)
        if len(self.shell.attached):
            free &= ~overlap(boxes, self.shell.attached).any(axis=-1)
        on_wall = np.array([item.on == "wall" for item in group.items])
        if on_wall.any():
            free &= ~on_wall | self._backed(boxes)
            for columns in (self.wet, self.hot):
                free &= ~on_wall | ~overlap(boxes, columns).any(axis=-1)
        free &= boxes[..., 7] <= self.shell.height - 0.02 + 0.02 * hung
        if len(self.solids):
            free &= ~overlap(boxes, self.solids, _GROUP_GAP_M).any(axis=-1)
        if len(self.zones):
            free &= hung | low | ~overlap(boxes, self.zones).any(axis=-1)
        kept = self._standing(group, free)
        possible: Mask = np.asarray(kept[:, group.required].all(axis=1))
        if len(group.zones):
            needed = posed(group.zones, poses)
            clear = ~overlap(needed, self.shell.walls).any(axis=-1)
            clear &= self.shell.contains(needed[..., :2])
            if len(self.solids):
                clear &= ~overlap(needed, self.solids).any(axis=-1)
            possible = possible & clear.all(axis=1)
        return kept, possible

    def _backed(self, boxes: Array) -> Mask:
        """(P, N) which boxes have a wall behind all of their width, none that ends before."""
        c, s, half, deep = (boxes[..., axis] for axis in (2, 3, 4, 5))
        back = boxes[..., :2] + (deep + _BEHIND_M)[..., None] * np.stack([-s, c], axis=-1)
        along = half[..., None] * np.stack([c, s], axis=-1)
        room = self.shell.contains
        return np.asarray(~room(back - along) & ~room(back) & ~room(back + along))

    def _standing(self, group: Group, free: Mask) -> Mask:
        if free.all():
            return free
        return np.array([with_dependants(row, group.items) for row in free.tolist()])

    def _settle(self, group: Group, pose: Pose, kept: list[bool]) -> bool:
        """Take a place, unless it cuts off a door or something that people use."""
        items = [item.posed(pose) for item, keep in zip(group.items, kept, strict=True) if keep]
        boxes = np.array([item.box for item in items])
        floor = self.floor.with_boxes(boxes)
        reachable = floor.connected()
        places = [*self.access, *_places(group, pose)]
        if reachable is None or not floor.reaches(reachable, places):
            return False
        self.floor, self.access = floor, places
        self.solids = np.concatenate([self.solids, boxes])
        self.zones = np.concatenate([self.zones, posed(group.zones, [pose])[0]])
        self.items.append((group.title, items))
        self.know(items)
        return True


def _places(group: Group, pose: Pose) -> list[tuple[float, float]]:
    return [placed(pose, x, y) for x, y in group.access]


def _wall_poses(shell: Shell, group: Group, rng: np.random.Generator) -> tuple[Array, Array]:
    """Along all walls; liked at their ends, a little in their middles."""
    left, _, right, _ = reach(group.boxes[group.required])
    corners = 1.4 if right - left < _CORNER_WIDTH_M else 0.5
    poses, taste = [], []
    for index, side in enumerate(shell.sides):
        # The group's x runs against the wall's direction.
        first, last = right + group.beside, side.length + left - group.beside
        if last < first:
            continue
        middle = 0.5 * (first + last)
        windows = [
            gap.at + group.window_at
            for gap in shell.gaps
            if group.window_at is not None and gap.kind == "window" and gap.side == index
        ]
        windows = [at for at in windows if first < at < last]
        if group.corner:
            places = _in_corner(shell, index, group, (left, right))
        else:
            drawn = rng.uniform(first, last, _ON_WALL).tolist()
            places = [first, last, middle, *windows, *drawn]
        for at in places:
            x, y = side.point(at, group.back + group.gap)
            poses.append((round(float(x), 3), round(float(y), 3), round(wrapped(side.yaw), 3)))
            ends = min(at - first, last - at)
            near = min((abs(at - window) for window in windows), default=9.0)
            taste.append(
                corners * (ends < 0.05) + 0.2 * (at == middle)
                + _BELOW_WINDOW_TASTE * (near < _BELOW_WINDOW_M)
            )  # fmt: skip
    fancy = rng.uniform(0.0, 1.0, len(poses))
    return np.array(poses).reshape(-1, 3), np.array(taste) + fancy


def _in_corner(shell: Shell, index: int, group: Group, ends: tuple[float, float]) -> list[float]:
    """Where a group stands whose one end goes on along the next wall; only in square corners."""
    side = shell.sides[index]
    # The wall's start is on the right, seen from inside.
    before = shell.sides[index - 1]
    after = shell.sides[(index + 1) % len(shell.sides)]
    pair = (before, side) if group.corner == "right" else (side, after)
    (ax, ay), (bx, by) = pair[0].along.tolist(), pair[1].along.tolist()
    if ax * by - ay * bx < _SQUARE_CORNER_SINE:
        return []
    left, right = ends
    at = right + group.gap if group.corner == "right" else side.length + left - group.gap
    return [at]


def _free_poses(shell: Shell, group: Group, rng: np.random.Generator) -> tuple[Array, Array]:
    """All over the room, square to its longest wall; liked in the middle."""
    low, high = shell.corners.min(axis=0), shell.corners.max(axis=0)
    places = rng.uniform(low, high, (_IN_ROOM, 2))
    middle = shell.corners.mean(axis=0)
    places[: _IN_ROOM // 4] = middle + 0.3 * (places[: _IN_ROOM // 4] - middle)
    longest = max(shell.sides, key=lambda side: side.length)
    turns = longest.yaw + 90.0 * rng.integers(0, 4, _IN_ROOM)
    poses = np.column_stack([places.round(2), [wrapped(turn) for turn in turns.round(3)]])
    away = np.linalg.norm((places - middle) / (high - low), axis=1)
    return poses, rng.uniform(0.0, 0.6, _IN_ROOM) - 1.5 * away


Build = Callable[[float], Group | None]


def tries(build: Build, modesty: Sequence[float]) -> Iterator[Group]:
    """A group again and again, asking for less each time."""
    for level in modesty:
        group = build(level)
        if group is not None:
            yield group
