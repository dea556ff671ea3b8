"""A room in its scene: where it stands there, and what of the scene is near."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.draws import generator
from openrooms_usd.library.surroundings.outside.facades import FacadeMaterials
from openrooms_usd.library.surroundings.outside.near import Near, Window, parted
from openrooms_usd.library.surroundings.outside.scenes import SCENES, PlantPalette, Scene
from openrooms_usd.library.surroundings.outside.solid import Solid, solid

STOREY_M: Final = 3.0
# Of an eye in the lowest storey above the land, and above the floor.
_EYE_M: Final = 1.75
_EYE_OVER_FLOOR_M: Final = 1.5


@dataclass(frozen=True)
class Site:
    """Where a room stands.

    Attributes:
        scene: One of `SCENES`.
        seed: Draws what stands there.
        storey: Of the room; 0 is level with the land.
        facing: Where the front of the house looks: degrees counter-clockwise from +X.
        outline: The room in plan, corners in metres; None where nothing is near.
        windows: Where it is looked out of, in plan.
    """

    scene: str
    seed: int
    storey: int = 0
    facing: float = 90.0
    outline: tuple[tuple[float, float], ...] | None = None
    windows: tuple[Window, ...] = ()

    @property
    def eye(self) -> float:
        """Height of the eye above the land, metres."""
        return _EYE_M + STOREY_M * self.storey

    def turn(self, height: int) -> int:
        """By how many columns of a panorama with so many rows the scene is turned to the left.

        The scene looks along +Y.
        """
        return round((self.facing - 90.0) / 180.0 * height)

    def world_from_scene(self, height: int, floor: float) -> Array:
        """(4, 4) from the frame of the scene, with the land at z = 0, to that of the room.

        Args:
            height: Rows of the panorama, by whole columns of which the scene is turned.
            floor: Height of the room's floor, metres.
        """
        angle = math.pi * self.turn(height) / height
        c, s = math.cos(angle), math.sin(angle)
        x, y = self._middle
        land = floor + _EYE_OVER_FLOOR_M - self.eye
        return np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, land], [0, 0, 0, 1.0]])

    @property
    def _middle(self) -> tuple[float, float]:
        corners = np.array(self.outline)
        x, y = (0.5 * (corners.min(axis=0) + corners.max(axis=0))).tolist()
        return x, y

    def surfaces(self) -> FacadeMaterials:
        """The patterns of the scene."""
        return FacadeMaterials(generator(self.seed, "outside", "surfaces"))

    def far(self, height: int) -> tuple[Scene, Scene]:
        """All that stands there, and what of it the panorama shows."""
        whole = SCENES[self.scene](self.nursery())
        return whole, whole if self.outline is None else self._parted(whole, height)[1]

    def _parted(self, whole: Scene, height: int) -> tuple[Near, Scene]:
        back = np.linalg.inv(self.world_from_scene(height, 0.0))
        turn, move = back[:2, :2], back[:2, 3]
        windows = [
            Window(*(turn @ window[:2] + move), *(turn @ window[2:])) for window in self.windows
        ]
        return parted(whole, self.eye, np.array(self.outline) @ turn.T + move, windows)

    def near(self, height: int) -> Solid:
        """What is near, as meshes."""
        near, _ = self._parted(SCENES[self.scene](self.nursery(drawn=False)), height)
        return solid(near, self.surfaces(), generator(self.seed, "outside", "near"))

    def nursery(self, *, drawn: bool = True) -> PlantPalette:
        """What the scene chooses from.

        Args:
            drawn: Whether the pictures of plants are drawn; without them the scene is the same.
        """
        rng = generator(self.seed, "outside", self.scene)
        pictures = generator(self.seed, "outside", "plants") if drawn else None
        return PlantPalette.create(rng, pictures)
