"""What is found in a scan, in the scan's own frame (metres), and its report."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from openrooms_usd.arrays import Array


def _points(matrix: Array, points: Array) -> Array:
    return np.asarray(points @ matrix[:3, :3].T + matrix[:3, 3])


@dataclass(frozen=True, eq=False)
class FoundOpening:
    """A door or window in a wall.

    Attributes:
        type: What it is.
        corners: (4, 3) seen from inside counter-clockwise, from the bottom left.
        confidence: From 0 to 1.
        wall: The number of its wall: from corner i of the room to the next one.
    """

    type: Literal["door", "window"]
    corners: Array
    confidence: float
    wall: int

    def moved(self, matrix: Array) -> "FoundOpening":
        """The opening after a rigid motion (4, 4)."""
        return replace(self, corners=_points(matrix, self.corners))

    def as_dict(self) -> dict[str, Any]:
        """The opening in the form of the report."""
        return {
            "type": self.type,
            "corners": self.corners.tolist(),
            "confidence": self.confidence,
            "wall": self.wall,
        }


@dataclass(frozen=True, eq=False)
class FoundRoom:
    """One room.

    Attributes:
        normal: (3,) unit, of the floor, upwards.
        point: (3,) a point of the floor.
        corners: (N, 3) on the floor at the walls' inner faces, counter-clockwise from above.
        guessed: Numbers of the walls that the scan does not show.
        ceiling: Height above the floor, metres; None where the scan shows none.
        openings: What is in the walls.
        measures: Coverage, residuals and the like, for people.
        slopes: Planes of a ceiling that is not level: normal (3,) into the room, and a point (3,).
        doubtful: Openings that are less likely than not.
    """

    normal: Array
    point: Array
    corners: Array
    guessed: tuple[int, ...] = ()
    ceiling: float | None = None
    openings: tuple[FoundOpening, ...] = ()
    measures: Mapping[str, float] = field(default_factory=dict)
    slopes: tuple[tuple[Array, Array], ...] = ()
    doubtful: tuple[FoundOpening, ...] = ()

    def moved(self, matrix: Array) -> "FoundRoom":
        """The room after a rigid motion (4, 4)."""
        return replace(
            self,
            normal=matrix[:3, :3] @ self.normal,
            point=_points(matrix, self.point),
            corners=_points(matrix, self.corners),
            openings=tuple(opening.moved(matrix) for opening in self.openings),
            doubtful=tuple(opening.moved(matrix) for opening in self.doubtful),
            slopes=tuple((matrix[:3, :3] @ n, _points(matrix, p)) for n, p in self.slopes),
        )

    def as_dict(self) -> dict[str, Any]:
        """The room in the form of the report."""
        return {
            "floor": {"normal": self.normal.tolist(), "point": self.point.tolist()},
            "corners": self.corners.tolist(),
            "guessed_walls": list(self.guessed),
            "ceiling_height": self.ceiling,
            "ceiling_planes": [{"normal": n.tolist(), "point": p.tolist()} for n, p in self.slopes],
            "openings": [o.as_dict() for o in self.openings],
            "doubtful_openings": [o.as_dict() for o in self.doubtful],
            "measures": dict(self.measures),
        }


@dataclass(frozen=True, eq=False)
class Pose:
    """A CAD in the scan: p = R diag(scale) p_cad + translation.

    Attributes:
        translation: (3,) metres.
        rotation: (4,) unit quaternion w, x, y, z.
        scale: (3,) along the CAD's axes.
    """

    translation: Array
    rotation: Array
    scale: Array

    @property
    def matrix(self) -> Array:
        """(4, 4) from the CAD's frame, scale included."""
        from scipy.spatial.transform import Rotation

        made = np.eye(4)
        made[:3, :3] = Rotation.from_quat(self.rotation, scalar_first=True).as_matrix() * self.scale
        made[:3, 3] = self.translation
        return made

    def moved(self, matrix: Array) -> "Pose":
        """The pose after a rigid motion (4, 4)."""
        from scipy.spatial.transform import Rotation

        turned = Rotation.from_matrix(matrix[:3, :3]) * Rotation.from_quat(
            self.rotation, scalar_first=True
        )
        return Pose(
            _points(matrix, self.translation),
            turned.as_quat(canonical=True, scalar_first=True),
            self.scale,
        )

    def as_dict(self) -> dict[str, Any]:
        """The pose in the form of the report."""
        return {
            "translation": self.translation.tolist(),
            "rotation_wxyz": self.rotation.tolist(),
            "scale": self.scale.tolist(),
        }


@dataclass(frozen=True, eq=False)
class FoundObject:
    """A CAD that was aligned to an instance of the scan.

    Attributes:
        instance: The number of the instance.
        category: One of the library's, or the source's own.
        cad: The CAD's id.
        pose: As measured.
        residual: Root mean squared distance of the instance's inliers to the CAD, metres.
        coverage: The part of the CAD's visible surface that points lie on, from 0 to 1.
        symmetry: About the CAD's vertical.
        placed: The pose after placement, its scale that of ``pose``; None before it.
        support: ``floor``, ``wall``, ``ceiling``, or the instance that it stands on, as text.
        word: The source's own word for it; empty where there is none.
        fitted: (3,) by how much it was shortened along the CAD's axes so that it has a place; the
            pose's scale has it in. None: not at all.
    """

    instance: int
    category: str
    cad: str
    pose: Pose
    residual: float
    coverage: float
    symmetry: Literal["none", "2", "4", "inf"] = "none"
    placed: Pose | None = None
    support: str = ""
    word: str = ""
    fitted: Array | None = None

    def moved(self, matrix: Array) -> "FoundObject":
        """The object after a rigid motion (4, 4)."""
        placed = self.placed and self.placed.moved(matrix)
        return replace(self, pose=self.pose.moved(matrix), placed=placed)

    def as_dict(self) -> dict[str, Any]:
        """The object in the form of the report."""
        placed = self.placed or self.pose
        moved = placed.as_dict()
        del moved["scale"]
        return {
            "instance": self.instance,
            "category": self.category,
            "word": self.word,
            "cad": self.cad,
            **self.pose.as_dict(),
            "residual": self.residual,
            "coverage": self.coverage,
            "symmetry": self.symmetry,
            "support": self.support,
            "placed": moved,
            **({} if self.fitted is None else {"fitted": self.fitted.tolist()}),
        }


def as_text(report: Mapping[str, Any]) -> str:
    """A report as JSON; numbers to a micrometre or a millionth, NaN and infinity as null."""
    return json.dumps(_rounded(report), indent=2, sort_keys=True, allow_nan=False) + "\n"


def _rounded(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _rounded(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(item) for item in value]
    if isinstance(value, float | np.floating):
        return round(float(value), 6) + 0.0 if np.isfinite(value) else None
    return value
