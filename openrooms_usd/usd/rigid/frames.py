"""Rigid frames of the prims of a stage, in metres with Z up."""

from collections.abc import Collection, Iterator, Sequence
from functools import cached_property

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdPhysics

from openrooms_usd.arrays import Array
from openrooms_usd.physics.world import STANDARD_GRAVITY
from openrooms_usd.usd.bodies import frame_and_scale
from openrooms_usd.usd.places.frames import TIME, matrix, meters_per_unit, world_from_stage


class Frames:
    """Frames of the prims of one stage.

    Args:
        stage: The composed stage, in any unit and with any axis up.
    """

    def __init__(self, stage: Usd.Stage) -> None:
        self.stage = stage
        self._cache = UsdGeom.XformCache(TIME)

    @cached_property
    def metres(self) -> float:
        """Metres for one unit of the stage."""
        return meters_per_unit(self.stage)

    @cached_property
    def kilograms(self) -> float:
        """Kilograms for one unit of the stage."""
        return float(UsdPhysics.GetStageKilogramsPerUnit(self.stage))

    @cached_property
    def turn(self) -> Array:
        """(3, 3) from the stage's axes to Z up."""
        return np.asarray(world_from_stage(self.stage)[:3, :3] / self.metres)

    def world(self, prim: Usd.Prim) -> Array:
        """(4, 4) from a prim's own frame, with its scale, to the world."""
        placed = matrix(self._cache.GetLocalToWorldTransform(prim))
        return np.asarray(world_from_stage(self.stage) @ placed)

    def rigid(self, path: Sdf.Path) -> Array:
        """(4, 4) from the rigid frame of a prim to the world."""
        prim = self.stage.GetPrimAtPath(path)
        found, _ = frame_and_scale(self._cache.GetLocalToWorldTransform(prim))
        return self.placed(found)

    def placed(self, stage_from_body: Array) -> Array:
        """A rigid frame in the stage's units and axes as one in the world's."""
        frame = np.eye(4)
        frame[:3, :3] = self.turn @ stage_from_body[:3, :3]
        frame[:3, 3] = self.metres * (self.turn @ stage_from_body[:3, 3])
        return frame

    def ordered(self, paths: Collection[Sdf.Path]) -> Iterator[Sdf.Path]:
        """Paths of prims in the order of the stage."""
        waiting = set(paths)
        for prim in Usd.PrimRange(self.stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()):
            if not waiting:
                return
            if prim.GetPath() in waiting:
                waiting.discard(prim.GetPath())
                yield prim.GetPath()
        yield from sorted(waiting)

    def gravity(self, scenes: Sequence[UsdPhysics.SceneDesc]) -> Array:
        """(3,) gravity of the first scene, m/s2; the earth's where none is authored."""
        down, pull = np.array([0.0, 0.0, -1.0]), STANDARD_GRAVITY
        for scene in scenes[:1]:
            given = np.array(scene.gravityDirection, dtype=np.float64)
            if np.linalg.norm(given) > 0.0:
                down = self.turn @ (given / np.linalg.norm(given))
            # Negative stands for that of the earth, and the number is a single-precision one.
            if 0.0 <= scene.gravityMagnitude < np.inf:
                pull = round(scene.gravityMagnitude * self.metres, 6)
        return np.asarray(down * pull)
