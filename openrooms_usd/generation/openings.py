"""Doors and windows: how many, in which walls, where, and how large."""

from dataclasses import replace
from typing import Any, Final

import numpy as np

from openrooms_usd.building.hallways import Way, hallways_behind
from openrooms_usd.building.shell import Hole
from openrooms_usd.building.walls import Wall, walls_of
from openrooms_usd.generation.boxes import overlap
from openrooms_usd.generation.programs import RoomProgram
from openrooms_usd.generation.shell import Gap, Shell
from openrooms_usd.geometry.polygons import turns

# Between an opening and the ends of its wall, and between two openings; metres.
_END_GAP_M: Final = 0.32
# Beyond the thickness of a wall that meets the room's concave corner, metres.
_BEYOND_THICKNESS_M: Final = 0.12
_GAP_M: Final = 0.3
_DOOR_WIDTHS: Final = (0.8, 0.85, 0.9, 0.95)
_MAX_TRIES: Final = 40


def openings(
    rng: np.random.Generator, shell: Shell, program: RoomProgram
) -> tuple[Shell, list[dict[str, Any]]]:
    """Cut doors and windows into a room.

    Args:
        rng: Draws them.
        shell: The room without openings; its polygon runs counter-clockwise.
        program: The kind of the room.

    Returns:
        The room with them, and the openings as the description has them: none is seen through
        that leads to a hallway for which there is no space.
    """
    rows: list[dict[str, Any]] = []
    for number in range(_doors(rng, shell, program)):
        shell = _door(rng, shell, program, rows, number)
    if program.gate and rng.random() < program.gate:
        shell = _gate(rng, shell, rows)
    return _shut(_windows(rng, shell, program, rows), rows), rows


def _shut(shell: Shell, rows: list[dict[str, Any]]) -> Shell:
    """Shut the doors, and put doors into the passages, behind which there is no space."""
    numbers = np.arange(len(shell.corners))
    walls = walls_of(shell.corners, numbers, shell.thickness)
    ways = [_way(walls[gap.side], gap, row) for gap, row in zip(shell.gaps, rows, strict=True)]
    gaps = list(shell.gaps)
    for index, size in enumerate(hallways_behind(shell.corners, ways)):
        if ways[index].leads and size is None:
            if rows[index]["kind"] == "opening":
                # A leaf that swings out takes nothing of the room.
                rows[index] |= {"kind": "door", "hinge": "left", "swing": "out"}
                gaps[index] = replace(gaps[index], kind="door", swing="out")
            rows[index]["open"] = 0.0
    return replace(shell, gaps=tuple(gaps))


def _way(wall: Wall, gap: Gap, row: dict[str, Any]) -> Way:
    """An opening in the frame of its wall, whose x runs against the side's."""
    middle = wall.length - gap.at
    hole = Hole(middle - 0.5 * gap.width, middle + 0.5 * gap.width, gap.sill, gap.top)
    leads = "beyond" in row and row.get("open", 1.0) > 0.0
    out = gap.kind == "door" and gap.swing == "out" and row["open"] > 0.0
    return Way(wall, hole, gap.kind == "window", leads, gap.width if out else 0.0)


def _doors(rng: np.random.Generator, shell: Shell, program: RoomProgram) -> int:
    least, most = program.doors
    return int(rng.integers(least, max(least, min(most, 1 + int(shell.area // 9))) + 1))


def _door(
    rng: np.random.Generator, shell: Shell, program: RoomProgram, rows: list[dict[str, Any]],
    number: int,
) -> Shell:  # fmt: skip
    width = float(rng.choice(_DOOR_WIDTHS)) if shell.area < 60 else 1.0
    passage = number > 0 and rng.random() < 0.35
    out = rng.random() < program.swing_out
    for _ in range(_MAX_TRIES):
        side, at, near_start = _place(rng, shell, width)
        if side is None:
            continue
        gap = Gap("opening" if passage else "door", side, at, width, 0.0,
                  min(2.1 if shell.height > 2.6 else 2.05, shell.height - 0.15),
                  "out" if out else "in", "right" if near_start else "left")  # fmt: skip
        grown = _with(shell, gap)
        if grown is None:
            continue
        row: dict[str, Any] = {
            "kind": gap.kind, "wall": side, "at": at, "width": width, "height": gap.top,
            "beyond": "hallway",
        }  # fmt: skip
        if not passage:
            # The leaf turns to the nearer corner: seen from inside, the start is on the right.
            row |= {"hinge": gap.hinge, "swing": gap.swing}
            row["open"] = float(rng.choice((0, 0, 0, 15, 35, 60)))
        rows.append(row)
        return grown
    return shell


def _gate(rng: np.random.Generator, shell: Shell, rows: list[dict[str, Any]]) -> Shell:
    """A wide opening, as garages have."""
    for width in (2.6, 2.4, 2.2):
        for _ in range(_MAX_TRIES // 2):
            side, at, _ = _place(rng, shell, width)
            if side is None:
                continue
            grown = _with(shell, Gap("opening", side, at, width, 0.0, 2.1))
            if grown is not None:
                rows.append(
                    {"kind": "opening", "wall": side, "at": at, "width": width, "height": 2.1}
                )
                return grown
    return shell


def _end_gap(shell: Shell) -> float:
    """Between openings and the ends of their walls, whose outer faces are shorter at corners."""
    concave = bool((turns(shell.corners) < 0.0).any())
    return max(_END_GAP_M, shell.thickness + _BEYOND_THICKNESS_M if concave else 0.0)


def _place(rng: np.random.Generator, shell: Shell, width: float) -> tuple[int | None, float, bool]:
    """A wall and a place in it: near a corner more often than not."""
    lengths, gap = np.array([side.length for side in shell.sides]), _end_gap(shell)
    room = np.maximum(lengths - width - 2 * gap, 0.0)
    if not room.any():
        return None, 0.0, False
    weights = np.where(room > 0.0, lengths, 0.0)
    side = int(rng.choice(len(lengths), p=weights / weights.sum()))
    away = min(float(rng.exponential(0.25)) if rng.random() < 0.7 else 99.0, room[side])
    if away == room[side]:
        away = float(rng.uniform(0.0, room[side]))
    near_start = bool(rng.random() < 0.5)
    at = gap + 0.5 * width + away
    at = at if near_start else lengths[side] - at
    return side, round(float(at), 2), bool(at < 0.5 * lengths[side])


def _with(shell: Shell, gap: Gap) -> Shell | None:
    """The room with one more opening; None where it is in the way of another or of a wall."""
    one = replace(shell, gaps=(gap,))
    side = one.sides[gap.side]
    for other in shell.gaps:
        clear = abs(other.at - gap.at) - 0.5 * (other.width + gap.width)
        if other.side == gap.side and clear < _GAP_M:
            return None
    if gap.kind != "window":
        before = one.kept.copy()
        before[:, :2] += 0.02 * side.inward
        if overlap(before, shell.walls).any() or overlap(before, shell.kept).any():
            return None
        if not bool(shell.contains(before[:, :2]).all()):
            return None
    return replace(shell, gaps=(*shell.gaps, gap))


def _windows(
    rng: np.random.Generator, shell: Shell, program: RoomProgram, rows: list[dict[str, Any]]
) -> Shell:
    """Windows in one or two outer walls, alike and evenly spaced in each."""
    least, most = program.windows
    wanted = int(rng.integers(least, most + 1))
    wanted = min(wanted, max(least, int(np.ceil(shell.area / 6.0))))
    width, height, sill = _window_size(rng, shell, program)
    lengths, end = np.array([side.length for side in shell.sides]), _end_gap(shell)
    used = {gap.side for gap in shell.doors}
    outer = sorted(
        range(len(lengths)), key=lambda i: (i in used, -lengths[i] * rng.uniform(0.6, 1))
    )
    for side in outer[:3]:
        if wanted <= 0:
            break
        free = lengths[side] - 2 * end
        count = min(wanted, int((free + _GAP_M) // (width + _GAP_M)))
        pitch = free / max(count, 1)
        for i in range(count):
            at = round(float(end + (i + 0.5) * pitch), 2)
            gap = Gap("window", side, at, width, sill, round(sill + height, 2))
            grown = _with(shell, gap)
            if grown is not None:
                shell = grown
                wanted -= 1
                rows.append({"kind": "window", "wall": side, "at": at, "width": width,
                             "height": height, "sill": sill})  # fmt: skip
    return shell


def _window_size(
    rng: np.random.Generator, shell: Shell, program: RoomProgram
) -> tuple[float, float, float]:
    """Width, height and sill, metres."""
    if program.high_windows:
        height = float(rng.choice((0.4, 0.5, 0.6)))
        sill = round(min(1.7, shell.height - height - 0.2), 2)
        return float(rng.choice((0.6, 0.8, 1.0))), height, sill
    if rng.random() < program.glazed:
        return float(rng.choice((1.4, 1.8, 2.2))), round(min(2.2, shell.height - 0.35), 2), 0.1
    sill = float(rng.choice(program.sills))
    height = round(min(float(rng.choice((1.2, 1.3, 1.4, 1.5))), shell.height - sill - 0.2), 2)
    return float(rng.choice((1.0, 1.2, 1.4, 1.6, 1.8))), height, sill
