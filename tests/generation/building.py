"""Is a room built right? Rows of kitchen units, boards along walls, what is screwed to these."""

from collections.abc import Iterator

import fcl
import numpy as np

from tests.generation.scenes import Body, Opening, Scene

# Units of one row have their backs and their upper sides in line to this, metres.
IN_LINE = 0.003
ROW = {"kitchen_unit", "dishwasher"}
# Sockets can be plugged into, and hands reach switches: so much before them is free, metres.
FREE = {"socket": 0.04, "data_outlet": 0.04, "light_switch": 0.3, "thermostat": 0.1}
# What is lower is moved by whoever wants a plug, metres.
HEAVY = 0.5
# Boards end at doors: above thresholds, below lintels, so far into the hole; metres.
DOORWAY = (0.05, 0.2, 0.02)
# Within so much of a wall's inner face, metres.
BOARDS = 0.06


def misbuilt(scene: Scene, supports: dict[str, str]) -> Iterator[str]:
    """What is out of line, crosses a door or cannot be reached, one sentence each."""
    for top in (body for body in scene.objects if body.category == "worktop"):
        yield from _out_of_line(top, scene)
    for way in (opening for opening in scene.openings if opening.walked):
        for body in scene.trim:
            if body.meets(_doorway(way)):
                yield f"{body.name} runs across {way.name}"
    for body in scene.objects:
        if body.category in FREE and supports[body.name] == "wall":
            yield from _covered(body, scene)


def _out_of_line(top: Body, scene: Scene) -> Iterator[str]:
    """Units below a worktop whose back or upper side is not where that of the others is."""
    units = [
        body
        for body in scene.objects
        if body.category in ROW
        and body.hits(top, np.array([0.0, 0.0, 0.02]))
        and abs(body.frame[:3, 0] @ top.frame[:3, 0]) > 0.5
    ]
    backs = [_reach(body, top)[1, 1] for body in units]
    heights = [body.high[2] for body in units]
    for name, sides in (("back", backs), ("upper side", heights)):
        for unit, side in zip(units, sides, strict=True):
            if abs(side - np.median(sides)) > IN_LINE:
                yield f"the {name} of {unit.name} is out of line"


def _reach(body: Body, frame: Body) -> np.ndarray:
    """(2, 3) least and greatest coordinates of a body in the frame of another."""
    own = (body.points - frame.frame[:3, 3]) @ frame.frame[:3, :3]
    return np.stack([own.min(axis=0), own.max(axis=0)])


def _doorway(way: Opening) -> fcl.CollisionObject:
    """What must be free of boards: the hole of a door, before the inner face of its wall."""
    low, below, in_ = DOORWAY
    size = np.array([way.width - 2.0 * in_, BOARDS, way.height - low - below])
    z = way.sill + low + 0.5 * size[2]
    middle = np.array([*(way.middle + 0.5 * BOARDS * way.inward), z])
    return fcl.CollisionObject(fcl.Box(*size), fcl.Transform(_upright(way.frame), middle))


def _covered(body: Body, scene: Scene) -> Iterator[str]:
    """What stands close before a plate on a wall."""
    low, high = _reach(body, body)
    depth = FREE[body.category]
    size = np.array([0.8 * (high - low)[0], depth, 0.8 * (high - low)[2]])
    local = np.array([0.5 * (low + high)[0], low[1] - 0.5 * depth - 0.002, 0.5 * (low + high)[2]])
    place = body.frame[:3, :3] @ local + body.frame[:3, 3]
    before = fcl.CollisionObject(fcl.Box(*size), fcl.Transform(body.frame[:3, :3], place))
    reach = np.linalg.norm(size)
    for other in scene.objects:
        near = (other.low < place + reach).all() and (other.high > place - reach).all()
        moved = other.high[2] - other.low[2] < HEAVY
        if other is not body and near and not moved and other.meets(before):
            yield f"{body.name} is behind {other.name}"


def _upright(frame: np.ndarray) -> np.ndarray:
    """(3, 3) a turn about the vertical, from a frame that may be mirrored."""
    x = frame[:3, 0] / np.linalg.norm(frame[:3, 0])
    return np.column_stack([x, np.cross([0.0, 0.0, 1.0], x), [0.0, 0.0, 1.0]])
