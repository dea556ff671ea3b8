"""Rigid motions of what stands in a translated stage: the same triangles, elsewhere."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.triangles import Triangles
from openrooms_usd.usd.places.ancestry import above

# Entries of a motion that differ by less, metres or ratios, are the same: an engine's noise at
# rest moves nothing.
_SAME_PLACE: Final = 1e-6


class MovingScene:
    """A translated stage, and where its prims have gone since.

    Args:
        scene: As the stage was translated.

    Attributes:
        scene: As it stands now. What has not moved is shared with the scene of before: a patch is
            another object only where one of its triangles has moved. Labels, surfaces and lights
            keep their numbers.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._rest = scene
        self._parts = [scene.legend.part.get(piece.part, "") for piece in scene.pieces]
        self._motions: dict[str, Array] = {}

    def move(self, motions: Mapping[str, Array]) -> bool:
        """Move prims.

        Args:
            motions: (4, 4) rigid by prim path, of the world to the world, metres, since the stage
                was translated. A motion holds for all that stands below its prim, up to prims that
                have one of their own; prims that are not named stay where they are.

        Returns:
            Whether anything stands elsewhere now.
        """
        changed = {path for path, M in motions.items() if not self._is_there(path, M)}
        if not changed:
            return False
        self._motions |= {path: np.array(motions[path]) for path in changed}
        moved_by = [self._nearest(path) for path in self._parts]
        touched = np.array([path in changed for path in moved_by])
        rest, now = ((*scene.patches, *scene.panes) for scene in (self._rest, self.scene))
        pairs = zip(rest, now, strict=True)
        self.scene = self.scene.placed(
            [
                self._placed(before.triangles, moved_by)
                if touched[before.triangles.pieces].any()
                else after.triangles
                for before, after in pairs
            ]
        )
        return bool(touched.any())

    def _is_there(self, path: str, motion: Array) -> bool:
        return bool(np.abs(motion - self._motions.get(path, np.eye(4))).max() < _SAME_PLACE)

    def _nearest(self, path: str) -> str:
        """The prim whose motion a part follows: itself, or the nearest above; else nothing."""
        while path and path not in self._motions:
            path = above(path)
        return path

    def _placed(self, triangles: Triangles, moved_by: list[str]) -> Triangles:
        """Triangles of the scene at rest with the motions of their pieces."""
        pieces = np.unique(triangles.pieces).tolist()
        return triangles.moved(
            {piece: self._motions[moved_by[piece]] for piece in pieces if moved_by[piece]}
        )
