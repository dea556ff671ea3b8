"""From a scene's ordered steps to poses: as an object was measured, and the fixes that follow.

Furniture has ``scale rotate translate`` of Scan2CAD, then up to two shifts by which it was put
where it can be: down to what carries it, and out of the walls. What was fitted to the layout
(doors, windows, curtains, ceiling lamps) has its own three and then the layout's.

Our world is the frame of the layout's mesh, Z up with the floor at 0, so that the layout's steps
cancel.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.rotations import is_rotation, nearest_rotation, pose
from orusd_openrooms.scenes.records import Step, whole

Array = NDArray[np.float64]

# From their world, Y up, to ours where no layout says it.
_UPRIGHT: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
# Files have six decimals; what a scale between two rotations shears more than this is told.
_SHEAR: Final = 1e-4
_TILT: Final = 1e-3


@dataclass(frozen=True, eq=False)
class Pose:
    """Where an object stands in our world.

    Attributes:
        measured: (4, 4) from the model's axes: scale, rotation, translation.
        fixes: (3,) each, the shifts that follow, metres.
        shear: By how much the file's matrix is more than these, relative; 0 as a rule.
    """

    measured: Array
    fixes: tuple[Array, ...]
    shear: float

    @property
    def final(self) -> Array:
        """(4, 4) after all shifts."""
        moved = self.measured.copy()
        moved[:3, 3] += sum(self.fixes, np.zeros(3))
        return moved


def scene_frame(layout: tuple[Step, ...] | None) -> Array:
    """(4, 4) from our world to the scene's: that of the layout where it stands upright."""
    if layout is not None:
        matrix = whole(layout)
        up = matrix[:3, 2]
        if is_rotation(matrix[:3, :3], _TILT) and np.abs(up - [0.0, 1.0, 0.0]).max() < _TILT:
            return pose(nearest_rotation(matrix[:3, :3]), matrix[:3, 3])
    return pose(_UPRIGHT.T)


def pose_of(steps: tuple[Step, ...], world_from_scene: Array) -> Pose:
    """Where steps take a model.

    Args:
        steps: Of its shape.
        world_from_scene: (4, 4) rigid.
    """
    first = next((i for i, step in enumerate(steps) if step.kind == "translate"), len(steps))
    own, later = steps[: first + 1], steps[first + 1 :]
    if any(step.kind != "translate" for step in later):
        own, later = steps, ()
    measured = world_from_scene @ whole(own)
    fixes = tuple(world_from_scene[:3, :3] @ step.matrix[:3, 3] for step in later)
    scale = np.linalg.norm(measured[:3, :3], axis=0)
    turn = nearest_rotation(measured[:3, :3] / scale)
    squared = measured.copy()
    squared[:3, :3] = turn * scale
    shear = float(np.abs(squared[:3, :3] - measured[:3, :3]).max() / scale.max())
    return Pose(squared, tuple(fix for fix in fixes if fix.any()), shear if shear > _SHEAR else 0.0)
