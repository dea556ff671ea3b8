"""What builders make: parts as meshes, how some of them move, and the fit into the box.

The object frame: metres, Z up, origin in the middle of the base, width along X, depth along Y,
front towards -Y.
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.mesh import Mesh

Size: TypeAlias = tuple[float, float, float]
Parts: TypeAlias = dict[str, Mesh]


@dataclass(frozen=True)
class Joint:
    """How some parts move together against the rest: a door on its hinge, a drawer on its rails.

    Attributes:
        name: Of the moving group, such as ``door_0``; its semantic part is the name without number.
        kind: ``hinge`` turns about the axis, ``rail`` slides along it.
        meshes: The parts that move.
        origin: A point of the axis in the object frame, metres.
        axis: Unit vector; hinges turn counter-clockwise about it.
        limits: The range of the movement from how it is built, degrees or metres.
    """

    name: str
    kind: Literal["hinge", "rail"]
    meshes: tuple[str, ...]
    origin: tuple[float, float, float]
    axis: tuple[float, float, float]
    limits: tuple[float, float]


@dataclass(frozen=True)
class Furniture:
    """An object: its parts, and how some of them move.

    Attributes:
        parts: Meshes by part; instances of one part are numbered (``leg_0``, ``leg_1``).
        joints: No mesh is in two of them.
    """

    parts: Parts
    joints: tuple[Joint, ...] = ()


Fronts: TypeAlias = Literal["slab", "shaker", "handleless"]
"""How the doors and drawers of fitted furniture look."""
Cutout: TypeAlias = tuple[float, float, float, float]
"""A hole from above: x and y of its middle in the object frame, its width and depth; metres."""


@dataclass(frozen=True)
class FitOptions:
    """What is ordered with a piece that is made to fit others.

    Attributes:
        fronts: How its doors and drawers look; None: as the seed draws it.
        cutouts: Holes for what is let into it.
    """

    fronts: Fronts | None = None
    cutouts: tuple[Cutout, ...] = ()


NOTHING_ORDERED: Final = FitOptions()

# Takes a size, a generator and, where the style is made to order, an order.
Build: TypeAlias = Callable[..., Parts | Furniture]


@dataclass(frozen=True)
class Style:
    """One way to build a category.

    Attributes:
        build: Makes the parts for a size, metres, with a generator and perhaps an order.
        suits: Whether a size, metres, is natural for it; any size can be built.
        size: Its usual width, depth and height, metres, where they differ from its category's.
        takes: What may be ordered with it.
        mass_range: Kilograms, lightest and heaviest, where they differ from its category's.
        weight: How often rooms from nothing have it, beside the other styles of its category.
        rooms: The room types that have it, apart by blanks; all by default.
    """

    build: Build
    suits: Callable[[Size], bool] = lambda size: True
    size: Size | None = None
    takes: tuple[Literal["fronts", "cutouts"], ...] = ()
    mass_range: tuple[float, float] | None = None
    weight: float = 1.0
    rooms: str = ""

    def is_of(self, room_type: str) -> bool:
        """Whether rooms of a type have it."""
        return not self.rooms or room_type in self.rooms.split()


def numbered(part: str, meshes: Iterable[Mesh]) -> Parts:
    """Instances of one part: ``leg_0``, ``leg_1`` ..."""
    return {f"{part}_{i}": mesh for i, mesh in enumerate(meshes)}


def part_of(mesh_name: str) -> str:
    """The semantic part of a mesh: ``leg`` of ``leg_2``."""
    return re.sub(r"_\d+$", "", mesh_name)


def fitted(made: Parts | Furniture, size: Size) -> Furniture:
    """Stretch an object so that its bounding box is exactly the one asked for.

    The builders plan for the size, so this takes up what a curve or a slant left over.
    """
    furniture = made if isinstance(made, Furniture) else Furniture(made)
    extents = np.stack([mesh.extent for mesh in furniture.parts.values()])
    low, high = extents[:, 0].min(axis=0), extents[:, 1].max(axis=0)
    scale = np.asarray(size) / (high - low)
    offset = -scale * [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2]]
    fit = np.eye(4)
    fit[:3, :3], fit[:3, 3] = np.diag(scale), offset
    return Furniture(
        {name: mesh.transformed(fit) for name, mesh in furniture.parts.items()},
        tuple(_stretched(joint, scale, offset) for joint in furniture.joints),
    )


def _stretched(joint: Joint, scale: Array, offset: Array) -> Joint:
    x, y, z = (scale * joint.origin + offset).tolist()
    axis = np.asarray(joint.axis) * scale
    length = float(np.linalg.norm(axis))
    a, b, c = (axis / length).tolist()
    # Slanted axes do not occur; along the frame's axes a slide stretches with the object.
    travel = length if joint.kind == "rail" else 1.0
    limits = (joint.limits[0] * travel, joint.limits[1] * travel)
    return replace(joint, origin=(x, y, z), axis=(a, b, c), limits=limits)
