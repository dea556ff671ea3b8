"""An automatic walk: through the room's free space, past its cameras, looking where they look."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.errors import RenderError
from openrooms_usd.geometry.pinhole import rotations
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.geometry.rotations import pose
from openrooms_usd.rendering.paths.free_space import FreeSpace
from openrooms_usd.rendering.paths.spline import eased, interpolated

# People stroll and look around no faster than this, as a rule.
_STROLL_M_PER_S: Final = 0.8
_TURN_DEG_PER_S: Final = 40.0
_LEAST_STOPS: Final = 3
_EYE_LEVELS_M: Final = (1.2, 1.7)
_BELOW_CEILING_M: Final = 0.3
_FARTHEST_STOP_M: Final = 1.0
_STEP_M: Final = 0.05
_SMOOTHINGS: Final = 400
_PITCHES_DEG: Final = (-20.0, 0.0)
# A turn of at least so much may be made the other way round, where there is more to be seen.
_WIDE_TURN_DEG: Final = 110.0
_WORTH_OF_OTHER_TURN: Final = 1.2
_FARTHEST_SIGHT_M: Final = 5.0


@dataclass(frozen=True, eq=False)
class _Stop:
    """A place of the walk, and where it looks there: yaw and pitch, radians."""

    cell: tuple[int, int]
    yaw: float
    pitch: float


def walk(caster: RayCaster, cameras: Sequence[Array], times: Array) -> Array:
    """(F, 4, 4) poses of a walk past cameras, at eye level, around walls and furniture.

    Args:
        caster: The room.
        cameras: (4, 4) world_from_camera each; those from which the first cannot be reached are
            left out. What is missing to three stops are the places farthest from the others.
        times: (F,) seconds of the frames: what cannot be reached in that time is left out.

    Raises:
        RenderError: There is no room for a walk.
    """
    space = FreeSpace(caster, _start(caster, cameras))
    stops = _stops(space, cameras)
    line, marks = _line(space, stops)
    looks = _looks(caster, line, marks, stops)
    seconds = _seconds(marks, looks)
    length = float(times[-1] - times[0]) or 1.0
    share = eased((times - times[0]) / length)
    # The speed stays that of a walk: a short path shows less of the room.
    now = share * min(seconds[-1], length)
    along = interpolated(seconds, marks[:, None], now)[:, 0]
    along = np.maximum.accumulate(np.clip(along, 0.0, marks[-1]))
    eyes = np.column_stack([np.interp(along, _lengths(line), line[:, k]) for k in range(3)])
    yaw, pitch = np.clip(interpolated(seconds, looks, now), looks.min(axis=0), looks.max(axis=0)).T
    ahead = np.column_stack(
        [np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), np.sin(pitch)]
    )
    check_passable(caster, eyes)
    return np.array([pose(R, eye) for R, eye in zip(rotations(ahead), eyes, strict=True)])


def _start(caster: RayCaster, cameras: Sequence[Array]) -> Array:
    """(3,) where the first camera is, at the height above the floor that people's eyes have."""
    start = cameras[0][:3, 3].copy()
    down, up = caster.first_hit(start, [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]).distance
    level = float(np.median([camera[2, 3] for camera in cameras]))
    if np.isfinite(down):
        level = float(np.clip(level, *(start[2] - down + np.array(_EYE_LEVELS_M))))
    start[2] = min(level, start[2] + up - _BELOW_CEILING_M)
    return start


def check_passable(caster: RayCaster, eyes: Array) -> None:
    """See that a camera passes through nothing between frames.

    Raises:
        RenderError: It does.
    """
    way = np.diff(eyes, axis=0)
    length = np.linalg.norm(way, axis=1)
    blocked = np.flatnonzero((length > 0.0) & caster.occluded(eyes[:-1], way, length))
    if len(blocked):
        x, y, z = eyes[blocked[0]]
        raise RenderError(
            f"the path passes through an object at ({x:.2f}, {y:.2f}, {z:.2f})",
            remedy="lead it around walls and furniture, or use `--path walk`",
        )


def _stops(space: FreeSpace, cameras: Sequence[Array]) -> list[_Stop]:
    """Where the walk leads past, in the order of the way."""
    found: list[_Stop] = []
    for camera in cameras:
        cell, apart = space.nearest(camera[:3, 3])
        ahead = camera[:3, 2]
        pitch = float(np.clip(np.arcsin(np.clip(ahead[2], -1, 1)), *np.radians(_PITCHES_DEG)))
        if not found or (apart < _FARTHEST_STOP_M and cell not in [stop.cell for stop in found]):
            found.append(_Stop(cell, float(np.arctan2(ahead[1], ahead[0])), pitch))
    places = space.places(space.usable)
    middle = places.mean(axis=0)
    while len(found) < _LEAST_STOPS:
        taken = space.places(np.array([stop.cell for stop in found]))
        nearest = np.linalg.norm(places[:, None] - taken, axis=2).min(axis=1)
        far = int(np.argmax(nearest))
        i, j = space.usable[far]
        back = middle - places[far]
        found.append(_Stop((int(i), int(j)), float(np.arctan2(back[1], back[0])), 0.0))
    ordered = [found.pop(0)]
    while found:
        here = space.places(np.array([ordered[-1].cell]))[0]
        left = space.places(np.array([stop.cell for stop in found]))
        ordered.append(found.pop(int(np.argmin(np.linalg.norm(left - here, axis=1)))))
    return ordered


def _line(space: FreeSpace, stops: list[_Stop]) -> tuple[Array, Array]:
    """(N, 3) points of the way, and how far along it (S,) the stops are, metres."""
    pieces, ends = [space.places(np.array([stops[0].cell]))], [0]
    for here, there in pairwise(stops):
        cells = space.way(here.cell, there.cell)
        points = _resampled(space.places(cells)) if len(cells) > 1 else pieces[-1][-1:]
        pieces.append(points)
        ends.append(ends[-1] + len(points))
    line = np.concatenate(pieces)
    for _ in range(_SMOOTHINGS):
        smooth = line.copy()
        smooth[1:-1] = 0.25 * line[:-2] + 0.5 * line[1:-1] + 0.25 * line[2:]
        better = space.is_free(smooth)
        better &= ~space.is_over_furniture(smooth) | space.is_over_furniture(line)
        line = np.where(better[:, None], smooth, line)
    return line, _lengths(line)[ends]


def _looks(caster: RayCaster, line: Array, marks: Array, stops: list[_Stop]) -> Array:
    """(S, 2) yaw and pitch at the stops; turns do not lead past a wall that is near."""
    yaws = [stops[0].yaw]
    for number, stop in enumerate(stops[1:]):
        short = (stop.yaw - yaws[-1] + np.pi) % (2.0 * np.pi) - np.pi
        turns = [short]
        if abs(short) > np.radians(_WIDE_TURN_DEG):
            turns.append(short - np.sign(short) * 2.0 * np.pi)
        middle = 0.5 * (marks[number] + marks[number + 1])
        eye = np.array([np.interp(middle, _lengths(line), line[:, k]) for k in range(3)])
        seen = [_sight(caster, eye, yaws[-1], turn) for turn in turns]
        longer = len(turns) > 1 and seen[1] > _WORTH_OF_OTHER_TURN * seen[0]
        yaws.append(yaws[-1] + turns[int(longer)])
    return np.column_stack([yaws, [stop.pitch for stop in stops]])


def _sight(caster: RayCaster, eye: Array, yaw: float, turn: float) -> float:
    """How far one sees on the mean during a turn, metres."""
    swept = yaw + turn * np.linspace(0.15, 0.85, 15)
    ahead = np.column_stack([np.cos(swept), np.sin(swept), np.zeros_like(swept)])
    distance = caster.first_hit(eye, ahead).distance
    return float(np.minimum(distance, _FARTHEST_SIGHT_M).mean())


def _resampled(line: Array) -> Array:
    """(N, 3) points in even steps along a line, without its first."""
    lengths = _lengths(line)
    at = np.linspace(0.0, lengths[-1], max(2, round(lengths[-1] / _STEP_M) + 1))[1:]
    return np.column_stack([np.interp(at, lengths, line[:, k]) for k in range(3)])


def _lengths(line: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])


def _seconds(marks: Array, looks: Array) -> Array:
    """(S,) when the stops are reached at an easy pace, as far as walking and looking take it."""
    turns = np.abs(np.diff(looks[:, 0]))
    needed = np.maximum(np.diff(marks) / _STROLL_M_PER_S, turns / np.radians(_TURN_DEG_PER_S))
    return np.concatenate([[0.0], np.cumsum(np.maximum(needed, 1e-3))])
