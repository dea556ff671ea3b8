"""What is true of a scan, in the terms of what is found in scans."""

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.geometry.rotations import pose
from openrooms_usd.scan.results import FoundObject, FoundRoom, Pose


@dataclass(frozen=True, eq=False)
class Cad:
    """A model as a file would have it: Z up, metres, its origin at the middle of its foot."""

    id: str
    category: str
    vertices: Array
    faces: Ints
    symmetry: Literal["none", "2", "4", "inf"]


@dataclass(frozen=True, eq=False)
class Truth:
    """What is true of a room, in the terms of what is found in scans.

    Attributes:
        rooms: One for each room.
        objects: Their poses exact, without residual.
        cads: By id.
    """

    rooms: tuple[FoundRoom, ...]
    objects: tuple[FoundObject, ...]
    cads: dict[str, Cad]

    def report(self) -> dict[str, Any]:
        """The truth in the form of the report."""
        return {
            "layout": {"rooms": [room.as_dict() for room in self.rooms]},
            "alignment": {"objects": [item.as_dict() for item in self.objects]},
        }

    def moved(self, matrix: Array) -> "Truth":
        """The truth after a rigid motion (4, 4)."""
        return replace(
            self,
            rooms=tuple(_moved_room(room, matrix) for room in self.rooms),
            objects=tuple(_moved_object(item, matrix) for item in self.objects),
        )


def pose_of(matrix: Array) -> Pose:
    """The pose of an affine matrix (4, 4) without shear."""
    from scipy.spatial.transform import Rotation

    scale = np.linalg.norm(matrix[:3, :3], axis=0)
    turn = Rotation.from_matrix(matrix[:3, :3] / scale).as_quat(scalar_first=True)
    return Pose(matrix[:3, 3].copy(), turn, scale)


def _moved_room(room: FoundRoom, matrix: Array) -> FoundRoom:
    holes = tuple(replace(hole, corners=moved(matrix, hole.corners)) for hole in room.openings)
    return replace(
        room,
        normal=matrix[:3, :3] @ room.normal,
        point=moved(matrix, room.point),
        corners=moved(matrix, room.corners),
        openings=holes,
    )


def _moved_object(item: FoundObject, matrix: Array) -> FoundObject:
    moved = _moved_pose(item.pose, matrix)
    return replace(item, pose=moved, placed=moved)


def _moved_pose(at: Pose, matrix: Array) -> Pose:
    """A pose after a rigid motion (4, 4)."""
    return pose_of(matrix @ pose_matrix(at))


def pose_matrix(at: Pose) -> Array:
    """(4, 4) of a pose: R diag(scale), then the translation."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_quat(at.rotation, scalar_first=True).as_matrix()
    return pose(turn * at.scale, at.translation)


def moved(matrix: Array, points: Array) -> Array:
    """(N, 3) points after a motion (4, 4)."""
    return np.asarray(points @ matrix[:3, :3].T + matrix[:3, 3])
