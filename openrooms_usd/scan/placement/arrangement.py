"""The state of a placement: each object's body, motion and support so far."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.rotations import about_point, pose
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.scan.models.cad import CadModel
from openrooms_usd.scan.placement.bodies import Body, solid
from openrooms_usd.scan.placement.enclosure import Enclosure
from openrooms_usd.scan.placement.penetration import Penetration, penetration
from openrooms_usd.scan.placement.support import Support, is_rug
from openrooms_usd.scan.results import FoundObject, FoundRoom, Pose

# Half the size of the enclosure of objects without a room, metres.
_OPEN_SPACE_M = 1000.0


@dataclass(eq=False)
class Arrangement:
    """The state of a placement; rows are objects.

    Attributes:
        objects: As measured, but for what was shortened.
        bodies: In their present poses.
        motions: (4, 4) each, rigid, from an object's measured pose to its present one.
        rooms: Enclosure of each.
        given: Known supports, by rows.
        supports: Support of each, once it is found.
        notes: What people should know, one sentence each.
        overlaps: Penetrations that were measured before, by pair and how: the two bodies, and what
            was found; true while the bodies are still these.
    """

    objects: list[FoundObject]
    bodies: list[Body]
    motions: list[Array]
    rooms: list[Enclosure]
    given: Mapping[int, Support] = field(default_factory=dict)
    supports: list[Support] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    overlaps: dict[tuple[int, int, float, int], tuple[Body, Body, Penetration | None]] = field(
        default_factory=dict
    )

    def overlap(self, i: int, j: int, tolerated: float, lines: int) -> Penetration | None:
        """The penetration of two objects in their present poses, measured once for these.

        Args:
            i: The row of the one.
            j: The row of the other.
            tolerated: Less than this is ignored, metres.
            lines: How finely to measure.
        """
        key, a, b = (i, j, tolerated, lines), self.bodies[i], self.bodies[j]
        known = self.overlaps.get(key)
        if known is None or known[0] is not a or known[1] is not b:
            known = self.overlaps[key] = a, b, penetration(a, b, tolerated, lines)
        return known[2]

    def __len__(self) -> int:
        return len(self.objects)

    def copy(self) -> "Arrangement":
        """The same state, to try what may be undone."""
        return replace(
            self,
            objects=list(self.objects),
            bodies=list(self.bodies),
            motions=list(self.motions),
            supports=list(self.supports),
            notes=list(self.notes),
            overlaps=dict(self.overlaps),
        )

    def has_moved(self, row: int) -> bool:
        """Whether an object's motion is not the identity."""
        return not np.array_equal(self.motions[row], np.eye(4))

    def moved(self, row: int) -> float:
        """How far the middle of an object is in the plan from where it was measured, metres."""
        body, motion = self.bodies[row], self.motions[row]
        middle = 0.5 * (body.low + body.high)
        before = motion[:3, :3].T @ (middle - motion[:3, 3])
        return float(np.linalg.norm((middle - before)[:2]))

    def shift(self, row: int, by: Array) -> None:
        """Move one object by (3,), metres."""
        self.bodies[row] = self.bodies[row].moved(by)
        motion = pose(np.eye(3), by)
        self.motions[row] = motion @ self.motions[row]

    def turn(self, row: int, rotation: Array) -> None:
        """Rotate one object about its middle by (3, 3)."""
        body = self.bodies[row]
        motion = about_point(rotation, 0.5 * (body.low + body.high))
        self.bodies[row] = body.turned(rotation)
        self.motions[row] = motion @ self.motions[row]

    def carrier(self, row: int) -> int:
        """The row of the object whose motion carries another one; -1: none, as a rug does not."""
        under = self.supports[row].number
        return -1 if under < 0 or is_rug(self.bodies[under], self.rooms[under].floor) else under

    def carried(self, row: int) -> Iterator[int]:
        """The rows of all objects on an object, directly or indirectly."""
        for other in range(len(self.supports)):
            if self.carrier(other) == row:
                yield other
                yield from self.carried(other)

    def weight(self, row: int) -> float:
        """The weight of an object's motion: larger for large and for well measured ones."""
        body = self.bodies[row]
        size = float(np.cbrt(np.prod(np.maximum(body.high - body.low, 0.01))))
        return max(size * self.trust(row), 1e-3)

    def trust(self, row: int) -> float:
        """How well an object was measured, up to 1."""
        found = self.objects[row]
        seen = float(np.clip(found.coverage, 0.1, 1.0))
        return seen * 0.02 / (0.02 + max(found.residual, 0.0))

    def ancestry(self) -> Array:
        """(N, N) 1 where the object of the row moves with that of the column, itself included."""
        found = np.eye(len(self))
        for row in range(len(self)):
            for other in self.carried(row):
                found[other, row] = 1.0
        return found


def arranged(
    objects: Sequence[FoundObject], models: Mapping[str, CadModel], rooms: Sequence[FoundRoom]
) -> Arrangement:
    """The initial state: objects in their measured poses."""
    bodies = [_body(found, models[found.cad]) for found in objects]
    enclosures = [_enclosure(room) for room in rooms] or [_nowhere()]
    homes = [
        min(enclosures, key=lambda room: room.distance(0.5 * (body.low + body.high)[:2]))
        for body in bodies
    ]
    return Arrangement(list(objects), bodies, [np.eye(4) for _ in bodies], homes)


def _body(found: FoundObject, model: CadModel) -> Body:
    turn = rotation_of(found.pose)
    points = (model.vertices * found.pose.scale) @ turn.T + found.pose.translation
    # The two axes of the CAD nearest to the horizontal.
    level = np.delete(turn.T, int(np.argmax(np.abs(turn[2]))), axis=0)[:, :2]
    return Body(solid(points, model.faces), unit(level))


def _enclosure(room: FoundRoom) -> Enclosure:
    floor = float(room.point[2])
    return Enclosure(room.corners[:, :2], floor, room.ceiling and floor + room.ceiling)


def _nowhere() -> Enclosure:
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return Enclosure(_OPEN_SPACE_M * square, 0.0, None)


def rotation_of(pose: Pose) -> Array:
    """(3, 3) the rotation of a pose."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_quat(pose.rotation, scalar_first=True).as_matrix())


def posed(pose: Pose, motion: Array) -> Pose:
    """A pose after a rigid motion (4, 4), its scale unchanged."""
    from scipy.spatial.transform import Rotation

    turned = motion[:3, :3] @ rotation_of(pose)
    rotation = Rotation.from_matrix(turned).as_quat(canonical=True, scalar_first=True)
    translation = motion[:3, :3] @ pose.translation + motion[:3, 3]
    return Pose(translation, np.asarray(rotation), pose.scale)
