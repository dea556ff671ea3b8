"""How high a room of RoomPlan is, and which of its walls have other heights or shapes."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np

from orusd_scans.roomplan.records import Record
from orusd_scans.roomplan.spaces import placed, rectangle
from orusd_scans.worldframe import WorldFrame

# Walls whose tops differ by less are equally high, metres; so many identifiers are named.
_SAME_HEIGHT_M: Final = 0.1
_MOST_NAMED: Final = 4


def ceiling_height(walls: Sequence[Record], frame: WorldFrame) -> float | None:
    """The height of a level ceiling: the median of the walls' tops, weighted by their lengths.

    Where walls slope it is the highest top, so that nothing captured is above the ceiling.

    Args:
        walls: All that were captured.
        frame: The room's.

    Returns:
        Metres above the floor; None without walls.
    """
    walls = [wall for wall in walls if wall.size[0] > 0.0 and wall.size[1] > 0.0]
    if not walls:
        return None
    tops = np.array([_top(wall, frame) for wall in walls])
    if any(_is_sloped(wall) for wall in walls):
        return float(tops.max())
    order = np.argsort(tops)
    weight = np.cumsum(np.array([wall.size[0] for wall in walls])[order])
    return float(tops[order][np.searchsorted(weight, 0.5 * weight[-1])])


def _top(wall: Record, frame: WorldFrame) -> float:
    corners = wall.corners if len(wall.corners) else rectangle(wall)
    return float(frame.points(placed(wall, corners))[:, 2].max())


def _is_sloped(wall: Record) -> bool:
    """Whether a wall ends at different heights: under a roof, or beside a stair."""
    if len(wall.corners) < 3:
        return False
    height = wall.corners[:, 1]
    middle = 0.5 * (height.min() + height.max())
    return len(wall.corners) != 4 or bool(np.ptp(height[height > middle]) > _SAME_HEIGHT_M)


def tell_heights(
    walls: Iterable[Record], height: float | None, frame: WorldFrame, notes: list[str]
) -> None:
    """Say which walls of the outline are built to another height or shape than they have.

    Args:
        walls: Those of the outline.
        height: Of the ceiling, metres.
        frame: The room's.
        notes: Receives the sentence.
    """
    others: dict[str, list[str]] = defaultdict(list)
    for wall in walls if height is not None else ():
        top = _top(wall, frame)
        if _is_sloped(wall):
            others[f"sloped, up to {top:.2f} m"].append(wall.id)
        elif abs(top - (height or 0.0)) > _SAME_HEIGHT_M:
            others[f"{top:.2f} m high"].append(wall.id)
    if others:
        each = "; ".join(
            f"{len(ids)} {'walls are' if len(ids) > 1 else 'wall is'} {what} ({_some(ids)})"
            for what, ids in sorted(others.items())
        )
        notes.append(
            f"the ceiling is level at {height:.2f} m (`height` says otherwise), and all walls of"
            f" the outline are built up to it as rectangles: {each}"
        )


def _some(ids: Sequence[str]) -> str:
    more = f" and {len(ids) - _MOST_NAMED} more" if len(ids) > _MOST_NAMED else ""
    return ", ".join(ids[:_MOST_NAMED]) + more
