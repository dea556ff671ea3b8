"""Captured boxes that stand in each other come apart, by the solver of scans.

Phones draw a box around a chair and another around the table that it is pushed under; what the
library builds for the two may then be one in the other.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.library.assets import Asset
from openrooms_usd.library.models.cads import merged
from openrooms_usd.scan.models.cad import CadModel
from openrooms_usd.scan.placement.arrangement import arranged
from openrooms_usd.scan.placement.settling import find_supports
from openrooms_usd.scan.placement.spreading import Spread
from openrooms_usd.scan.results import FoundObject, FoundRoom, Pose
from openrooms_usd.steps.alignment.placement import Placement
from openrooms_usd.steps.alignment.surroundings import RoomGeometry

# How far a box is moved at most: what lies deeper in another is not where it was seen, metres.
_REACH_M: Final = 0.3
# Shorter motions are ignored.
_NO_MOTION_M: Final = 0.001


def moved_apart(
    things: Sequence[Placement], room: RoomGeometry, notes: list[str]
) -> list[Placement]:
    """Placements of a capture by the least motion in the plan that parts them.

    Args:
        things: Built at the sizes that were captured; those with a pose of their own stay.
        room: What they stand in; its walls hold them.
        notes: Receives a sentence about what was moved.
    """
    free = [thing for thing in things if thing.pose is None]
    if len(free) < 2 or not len(room.walls):
        return list(things)
    assets = {thing.asset.name: thing.asset for thing in free}
    models = {name: _model(asset) for name, asset in assets.items()}
    objects = [_object(number, thing, room) for number, thing in enumerate(free)]
    corners = np.column_stack([room.walls[:, 0], np.full(len(room.walls), room.floor)])
    height = None if room.ceiling is None else room.ceiling - room.floor
    home = FoundRoom(np.array([0.0, 0.0, 1.0]), corners[0], corners, ceiling=height)
    state = arranged(objects, models, [home])
    find_supports(state)
    shifts = np.array([motion[:2, 3] for motion in state.motions]) + Spread(state, _REACH_M).run()
    far = dict(zip((thing.name for thing in free), np.hypot(*shifts.T).tolist(), strict=True))
    moved = {
        thing.name: replace(thing, x=thing.x + dx, y=thing.y + dy)
        for thing, (dx, dy) in zip(free, shifts.tolist(), strict=True)
        if far[thing.name] > _NO_MOTION_M
    }
    if moved:
        most = max(moved, key=far.__getitem__)
        notes.append(
            f"{len(moved)} of {len(things)} captured objects overlapped others or walls and were "
            f"moved apart, {most} the farthest: {far[most]:.2f} m"
        )
    return [moved.get(thing.name, thing) for thing in things]


def _model(asset: Asset) -> CadModel:
    vertices, faces = merged(asset.build(), np.eye(4))
    return CadModel(asset.name, "", np.asarray(vertices, np.float64), faces, "none", "Z", 1.0)


def _object(number: int, thing: Placement, room: RoomGeometry) -> FoundObject:
    half = np.deg2rad(thing.yaw) / 2.0
    height = room.floor if thing.z is None else thing.z
    pose = Pose(
        np.array([thing.x, thing.y, height]),
        np.array([np.cos(half), 0.0, 0.0, np.sin(half)]),
        np.ones(3),
    )
    word = thing.source.word if thing.source else ""
    return FoundObject(number, "", thing.asset.name, pose, 0.0, 1.0, word=word)
