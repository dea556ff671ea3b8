"""What an OpenRooms scene file says, as plain data in its own words, axes and units."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.rotations import pose

Color = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Step:
    """One operation of a shape's way into the world; each is applied after the one before.

    Attributes:
        kind: What it does.
        matrix: (4, 4) for columns.
        values: Factors, a shift, or an angle in degrees and its axis.
    """

    kind: Literal["scale", "rotate", "translate"]
    matrix: Array
    values: tuple[float, ...] = ()

    @staticmethod
    def scale(x: float, y: float, z: float) -> "Step":
        """Factors along the axes."""
        return Step("scale", np.diag([x, y, z, 1.0]), (x, y, z))

    @staticmethod
    def rotate(degrees: float, axis: Array) -> "Step":
        """A turn about an axis through the origin, by Rodrigues' formula."""
        x, y, z = axis / np.linalg.norm(axis)
        K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        angle = np.radians(degrees)
        turn = np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K
        return Step("rotate", pose(turn), (degrees, float(x), float(y), float(z)))

    @staticmethod
    def translate(x: float, y: float, z: float) -> "Step":
        """A shift."""
        return Step("translate", pose(np.eye(3), (x, y, z)), (x, y, z))


def whole(steps: tuple[Step, ...]) -> Array:
    """(4, 4) of all steps, one after the other."""
    matrix = np.eye(4)
    for step in steps:
        matrix = step.matrix @ matrix
    return matrix


@dataclass(frozen=True)
class Bsdf:
    """A ``microfacet`` material: maps by their paths in the file, or constants, each with a factor.

    Attributes:
        id: What ``usemtl`` and ``ref`` call it.
        maps: Paths by ``albedo``, ``normal``, ``roughness`` and ``metallic``.
        albedo: Scene-linear reflectance where there is no map.
        albedo_scale: Factor of albedo.
        roughness: Perceptual roughness where there is no map.
        roughness_scale: Factor of roughness.
        metallic: Where there is no map.
        f0: Reflectance at normal incidence.
        uv_scale: Repeats in one unit of texture coordinates.
    """

    id: str
    maps: dict[str, str] = field(default_factory=dict)
    albedo: Color = (0.8, 0.8, 0.8)
    albedo_scale: Color = (1.0, 1.0, 1.0)
    roughness: float = 1.0
    roughness_scale: float = 1.0
    metallic: float = 0.0
    f0: float = 0.05
    uv_scale: float = 1.0


@dataclass(frozen=True, eq=False)
class ShapeRecord:
    """A mesh in the scene. Identifiers repeat, so it is known by its number.

    Attributes:
        number: Its position among all shapes, from 0.
        id: As it stands in the file.
        file: The path of its mesh, as it stands there.
        steps: How it comes into the world, Y up, metres.
        refs: The materials that its ``usemtl`` may name.
        radiance: What it emits; None where it does not.
    """

    number: int
    id: str
    file: str
    steps: tuple[Step, ...] = ()
    refs: tuple[str, ...] = ()
    radiance: Color | None = None


@dataclass(frozen=True, eq=False)
class SceneFile:
    """A whole scene file.

    Attributes:
        bsdfs: By identifier.
        shapes: In the order of the file.
        fov: Horizontal field of view, degrees; None where no sensor says it.
        resolution: Width and height of pictures.
        environment: The path of the panorama, as it stands there; None without one.
        environment_scale: Factor of its pixels.
        notes: What was not understood and left out, one sentence each.
    """

    bsdfs: dict[str, Bsdf]
    shapes: tuple[ShapeRecord, ...]
    fov: float | None
    resolution: tuple[int, int]
    environment: str | None
    environment_scale: float
    notes: tuple[str, ...] = ()
