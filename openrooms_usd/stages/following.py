"""Dependent objects follow the objects that were moved in the edits layer.

Objects that stand on another one, or are described relative to it, depend on it. Where an edit
moves an object from its described pose M to the pose M', its dependents move by M' M^-1: those on
it in space, upright or not; those beside it in the plan, on their own floor or wall. Their sizes
stay: a support that is scaled moves what it carries to the scaled places, without scaling it.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pxr import Usd

from openrooms_usd import names
from openrooms_usd.geometry.rotations import nearest_rotation, pose
from openrooms_usd.stages.placement import WALL, Placement, Stand, parents_first
from openrooms_usd.stages.poses import author_pose, composed_pose, matrix_of
from openrooms_usd.stages.surroundings import Surroundings
from openrooms_usd.usd.layers import is_off

Array: TypeAlias = NDArray[np.float64]

# A support with a smaller scale is degenerate.
_MIN_SCALE: Final = 1e-6
# How many names a note lists.
_MAX_LISTED_NAMES: Final = 5


@dataclass
class Following:
    """Moves what belongs to objects that were moved by hand.

    Attributes:
        stage: The composed stage; all objects stand there as they are described.
        room: What they stand in.
        placements: All objects by name.
        stands: Where they stand as described.
        notes: Receives a sentence for each object that nothing can follow.
    """

    stage: Usd.Stage
    room: Surroundings
    placements: Mapping[str, Placement]
    stands: Mapping[str, Stand]
    notes: list[str]
    _motions: dict[str, Array] = field(default_factory=dict)

    def author(self, by_hand: frozenset[str]) -> None:
        """Write the poses of all that follows.

        Args:
            by_hand: The objects that an edit transforms.

        Raises:
            InputError: Objects depend on each other in a circle.
        """
        parents = {
            name: stand.carrier or self.placements[name].relative_to
            for name, stand in self.stands.items()
        }
        with_others = set(parents.values())
        self._note_what_is_off(parents)
        layer = self.stage.GetEditTarget().GetLayer()
        for name in parents_first(parents) if by_hand else ():
            followed = self._followed(name, parents[name])
            if followed is not None:
                author_pose(layer.GetPrimAtPath(f"{names.FURNITURE}/{name}"), followed)
            if name in with_others:
                self._note_motion(name, followed, name in by_hand)

    def _note_motion(self, name: str, followed: Array | None, by_hand: bool) -> None:
        """Record the motion of an object from its described pose, if it has moved."""
        if followed is None and not by_hand:
            return
        prim = self._prim(name)
        if is_off(prim):
            return
        now = composed_pose(prim) if by_hand or followed is None else followed
        if not np.isfinite(now).all() or abs(np.linalg.det(now[:3, :3])) < _MIN_SCALE**3:
            self.notes.append(f"{name} is scaled to nothing: nothing follows it")
            return
        motion = now @ np.linalg.inv(self._described(name))
        if not np.allclose(motion, np.eye(4), rtol=0.0, atol=1e-6):
            self._motions[name] = motion

    def _followed(self, name: str, parent: str | None) -> Array | None:
        """The pose of an object after its parent's motion; None where it stays."""
        motion = self._motions.get(parent) if parent else None
        if motion is None:
            return None
        described = self._described(name)
        gone = motion @ described
        turn = nearest_rotation(motion[:3, :3])
        if self.stands[name].carrier:
            return pose(turn @ described[:3, :3], gone[:3, 3])
        return self._beside(name, gone, turn)

    def _beside(self, name: str, gone: Array, turn: Array) -> Array:
        """A motion in the plan alone: the room still carries the object."""
        item, stand = self.placements[name], self.stands[name]
        heading = float(np.degrees(np.arctan2(turn[1, 0], turn[0, 0])))
        x, y = gone[:2, 3].tolist()
        yaw = stand.yaw + heading
        if item.on == WALL:
            width, depth, _ = item.size
            hung = self.room.hang(x, y, width, depth)
            x, y, yaw = hung.x, hung.y, hung.yaw
        return matrix_of(x, y, stand.z, yaw, stand.tilt)

    def _note_what_is_off(self, parents: Mapping[str, str | None]) -> None:
        children: defaultdict[str, list[str]] = defaultdict(list)
        for name, parent in parents.items():
            if parent is not None:
                children[parent].append(name)
        for parent, belonging in children.items():
            if is_off(self._prim(parent)):
                self.notes.append(f"{parent} is switched off: {_some(belonging)} stay as described")

    def _described(self, name: str) -> Array:
        """(4, 4) from an object's frame to the room, as it is described."""
        item, stand = self.placements[name], self.stands[name]
        upright = matrix_of(stand.x, stand.y, stand.z, stand.yaw, stand.tilt)
        return upright if item.pose is None else item.pose

    def _prim(self, name: str) -> Usd.Prim:
        return self.stage.GetPrimAtPath(f"{names.FURNITURE}/{name}")


def _some(members: Sequence[str]) -> str:
    more = len(members) - _MAX_LISTED_NAMES
    return ", ".join(members[:_MAX_LISTED_NAMES]) + (f" and {more} more" if more > 0 else "")
