"""Prior knowledge of an object: its instance number, category, CAD, pose or box."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

from openrooms_usd.arrays import Array
from openrooms_usd.scan.models.cad import CadModel
from openrooms_usd.scan.results import Pose

# Margin around a hint for points of its instance: metres, plus share of its size.
_AROUND_HINT_M: Final = 0.2
_AROUND_HINT_SHARE: Final = 0.15
_CORNERS: Final = np.array(
    [[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
)


@dataclass(frozen=True, eq=False)
class Box:
    """An upright box around an object, whose front may be any of its sides.

    Attributes:
        center: (3,) metres.
        size: (3,) full lengths along its own axes, metres.
        rotation: (4,) unit quaternion w, x, y, z.
    """

    center: Array
    size: Array
    rotation: Array

    def upright(self) -> tuple[Array, Array, float]:
        """Middle of its base (3,); lengths along its level axes, and height (3,); yaw, radians."""
        axes = Rotation.from_quat(self.rotation, scalar_first=True).as_matrix()
        k = int(np.abs(axes[2]).argmax())
        right = axes[:, (k + 1) % 3]
        size = self.size[[(k + 1) % 3, (k + 2) % 3, k]]
        base = self.center - [0.0, 0.0, 0.5 * float(size[2])]
        return base, size, float(np.arctan2(right[1], right[0]))

    def moved(self, matrix: Array) -> "Box":
        """The box after a rigid motion (4, 4)."""
        return Box(
            matrix[:3, :3] @ self.center + matrix[:3, 3], self.size, _turned(self.rotation, matrix)
        )


@dataclass(frozen=True, eq=False)
class Hint:
    """Prior knowledge of one object.

    Attributes:
        instance: Its number in the cloud; where the cloud has no such points, those around the
            pose or the box are taken.
        category: Of the CADs to choose from; None: by the points' labels.
        cad: The CAD's id; None: one of the category.
        pose: Initial pose of the CAD.
        box: A box around it, whose yaw is known up to quarter turns.
        support: Its support: ``floor``, ``wall``, ``ceiling`` or the number of an instance, as
            text; empty where that is to be found.
        word: The source's own word for it; empty where there is none.
        choices: Categories of CADs to choose from where none is given, in groups of equals, the
            better groups first. A box stands for it where none of them has its size. None: by the
            points' labels.
    """

    instance: int
    category: str | None = None
    cad: str | None = None
    pose: Pose | None = None
    box: Box | None = None
    support: str = ""
    word: str = ""
    choices: tuple[tuple[str, ...], ...] | None = None

    def moved(self, matrix: Array) -> "Hint":
        """The hint after a rigid motion (4, 4)."""
        return replace(
            self,
            pose=None if self.pose is None else moved_pose(self.pose, matrix),
            box=None if self.box is None else self.box.moved(matrix),
        )


def moved_pose(pose: Pose, matrix: Array) -> Pose:
    """A pose after a rigid motion (4, 4)."""
    return Pose(
        matrix[:3, :3] @ pose.translation + matrix[:3, 3],
        _turned(pose.rotation, matrix),
        pose.scale,
    )


def corners_of(hint: Hint, models: Sequence[CadModel]) -> Array | None:
    """(8, 3) corners of the box of a hint, or of its CAD in its pose; None without either."""
    if hint.box is not None:
        turn = Rotation.from_quat(hint.box.rotation, scalar_first=True).as_matrix()
        return np.asarray(hint.box.center + (_CORNERS * hint.box.size) @ turn.T)
    model = next((model for model in models if model.id == hint.cad), None)
    if hint.pose is None or model is None:
        return None
    turn = Rotation.from_quat(hint.pose.rotation, scalar_first=True).as_matrix()
    own = model.extent.mean(axis=0) + _CORNERS * np.ptp(model.extent, axis=0)
    return np.asarray(hint.pose.translation + (own * hint.pose.scale) @ turn.T)


def bounds_of(hint: Hint, models: Sequence[CadModel]) -> Array | None:
    """(2, 3) bounds of a hinted object's points; None: anywhere."""
    corners = corners_of(hint, models)
    if corners is None:
        return None
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = _AROUND_HINT_M + _AROUND_HINT_SHARE * (high - low)
    return np.stack([low - margin, high + margin])


def _turned(quaternion: Array, matrix: Array) -> Array:
    turn = Rotation.from_matrix(matrix[:3, :3])
    turned = (turn * Rotation.from_quat(quaternion, scalar_first=True)).as_quat(scalar_first=True)
    return np.asarray(turned * (1.0 if turned[0] >= 0.0 else -1.0))
