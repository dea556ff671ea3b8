"""What is true of a scan, in the terms of what is found in scans."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.draws import generator
from openrooms_usd.geometry.rotations import pose
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.registration.hypotheses import Box
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
            "furniture": {"objects": [item.as_dict() for item in self.objects]},
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


# What a user knows of objects before alignment: models of another size, and rough poses.

# Standard deviations of a rough pose: metres, degrees of its heading, and a part of each axis.
PLACE, TURN, SCALE = 0.10, 10.0, 0.10
# Models come this much smaller or larger than in the room, along each axis.
SIZES: Final = (0.8, 1.25)
# Objects count that are furniture, show so many points, and are as large as this, metres.
LEAST_POINTS: Final = 300
LEAST_SIZE: Final = 0.3
HANGING: Final = frozenset(
    {"ceiling_lamp", "clock", "curtain", "picture", "pillow", "rug", "wall_lamp", "whiteboard"}
)


@dataclass(frozen=True, eq=False)
class RoughHint:
    """One object's start: a pose that is off, or a box whose heading may be off by quarters."""

    instance: int
    cad: str
    category: str
    pose: Pose | None = None
    box: Box | None = None


def stretched(truth: Truth, seed: int) -> Truth:
    """The same room, but its models have other sizes, so that true scales are not 1."""
    cads, factors = {}, {}
    for name, cad in truth.cads.items():
        factor = np.exp(generator(seed, "size", name).uniform(*np.log(SIZES), size=3))
        if cad.symmetry in ("4", "inf"):
            factor[1] = factor[0]
        factors[name] = factor
        cads[name] = replace(cad, vertices=cad.vertices / factor)
    objects = tuple(_scaled(item, factors[item.cad]) for item in truth.objects)
    return replace(truth, cads=cads, objects=objects)


def _scaled(item: FoundObject, factor: Array) -> FoundObject:
    pose = replace(item.pose, scale=item.pose.scale * factor)
    return replace(item, pose=pose, placed=pose)


def countable(truth: Truth, cloud: Cloud) -> list[FoundObject]:
    """The furniture that the scan shows enough of to be aligned."""
    assert cloud.instance is not None
    numbers, counts = np.unique(cloud.instance, return_counts=True)
    shown = dict(zip(numbers.tolist(), counts.tolist(), strict=True))
    return [
        item
        for item in truth.objects
        if item.category not in HANGING
        and shown.get(item.instance, 0) >= LEAST_POINTS
        and extent(truth.cads[item.cad], item.pose).max() >= LEAST_SIZE
    ]


def extent(cad: Cad, pose: Pose) -> Array:
    """(3,) size along the CAD's own axes, metres."""
    used = cad.vertices[np.unique(cad.faces)]
    return np.asarray(np.ptp(used, axis=0) * pose.scale)


def rough(
    items: Sequence[FoundObject], cads: dict[str, Cad], seed: int, kind: Literal["pose", "box"]
) -> list[RoughHint]:
    """Hints with the noise of `PLACE`, `TURN` and `SCALE` (normal), boxes also turned by quarters.

    Args:
        items: The true objects, in a frame with Z up.
        cads: Their models.
        seed: Decides the noise.
        kind: Which hints.
    """
    hints = []
    for item in items:
        random = generator(seed, kind, item.instance)
        shift = random.normal(0.0, PLACE, 3)
        turn = Rotation.from_euler("z", random.normal(0.0, TURN), degrees=True)
        scale = np.exp(random.normal(0.0, SCALE, 3))
        true = Rotation.from_quat(item.pose.rotation, scalar_first=True)
        R = turn * true
        if kind == "pose":
            off = Pose(
                item.pose.translation + shift, R.as_quat(scalar_first=True), item.pose.scale * scale
            )
            hints.append(RoughHint(item.instance, item.cad, item.category, pose=off))
            continue
        used = cads[item.cad].vertices[np.unique(cads[item.cad].faces)]
        middle = true.apply((used.min(axis=0) + used.max(axis=0)) / 2 * item.pose.scale)
        size = extent(cads[item.cad], item.pose) * scale
        quarter = int(random.integers(4))
        R = R * Rotation.from_euler("z", 90 * quarter, degrees=True)
        box = Box(
            item.pose.translation + middle + shift,
            size if quarter % 2 == 0 else size[[1, 0, 2]],
            R.as_quat(scalar_first=True),
        )
        hints.append(RoughHint(item.instance, item.cad, item.category, box=box))
    return hints
