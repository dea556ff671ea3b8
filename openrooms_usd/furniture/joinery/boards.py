"""What furniture is made of: boards, legs, posts, and the fit into its box.

The object frame: metres, Z up, origin in the middle of the base, width along X, depth along Y,
front towards -Y.
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import with_normals
from openrooms_usd.geometry.solids import frustum, rounded_box
from openrooms_usd.geometry.sweeps import extrude
from openrooms_usd.geometry.vectors import unit

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
class Order:
    """What is ordered with a piece that is made to fit others.

    Attributes:
        fronts: How its doors and drawers look; None: as the seed draws it.
        cutouts: Holes for what is let into it.
    """

    fronts: Fronts | None = None
    cutouts: tuple[Cutout, ...] = ()


NOTHING_ORDERED: Final = Order()

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


# Drawn in (a, b) and extruded along c: where these axes point in the object frame.
SIDE: Final = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # a: Y, b: Z, c: X
FRONT: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # a: X, b: Z, c: -Y


def numbered(part: str, meshes: Iterable[Mesh]) -> Parts:
    """Instances of one part: ``leg_0``, ``leg_1`` ..."""
    return {f"{part}_{i}": mesh for i, mesh in enumerate(meshes)}


def part_of(mesh_name: str) -> str:
    """The semantic part of a mesh: ``leg`` of ``leg_2``."""
    return re.sub(r"_\d+$", "", mesh_name)


def board(low: ArrayLike, high: ArrayLike, edge: float = 0.002) -> Mesh:
    """A board between two opposite corners, its edges rounded by ``edge`` metres."""
    a, b = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    return rounded_box(b - a, edge, center=0.5 * (a + b))


def wall_plate(size: Size, thick: float) -> Mesh:
    """A cover with eased edges, ``thick`` metres, flat on the wall behind the box."""
    x, y, height = 0.5 * size[0], 0.5 * size[1], size[2]
    return board((-x, y - thick, 0.0), (x, y, height), 0.002)


def profiled(polygon: ArrayLike, width: float, frame: NDArray[np.float64], bevel: float) -> Mesh:
    """A board of a given outline, drawn in `SIDE` or `FRONT` view, centred in its width."""
    return extrude(polygon, width, bevel=bevel, base=-0.5 * width).transformed(frame)


def strip(line: ArrayLike, thickness: float, end: float | None = None) -> NDArray[np.float64]:
    """The outline of a band along a 2D polyline, tapering from ``thickness`` to ``end``."""
    axis = np.asarray(line, dtype=np.float64)
    along = np.gradient(axis, axis=0)
    side = unit(np.stack([-along[:, 1], along[:, 0]], axis=1))
    half = 0.5 * np.linspace(thickness, thickness if end is None else end, len(axis))[:, None]
    return np.concatenate([axis + half * side, (axis - half * side)[::-1]])


def bent_post(
    corners: ArrayLike,
    thickness: float,
    width: float,
    *,
    bend: float = 0.5,
    end: float | None = None,
) -> Mesh:
    """A post bent in the side view (Y, Z), cut level with the floor at its foot."""
    axis = filleted(corners, bend, segments=6)
    post = profiled(strip(axis, thickness, end), width, SIDE, 0.004)
    points = post.points.copy()
    points[:, 2] = np.clip(points[:, 2], axis[0, 1], axis[-1, 1])
    return replace(post, points=points)


def square_leg(top: float, bottom: float, height: float, edge: float = 0.004) -> Mesh:
    """A square leg that tapers downwards, its foot in the origin."""
    plain = rounded_box((top, top, height), edge, center=(0.0, 0.0, 0.5 * height))
    scale = bottom / top + (1.0 - bottom / top) * plain.points[:, 2:] / height
    points = np.concatenate([plain.points[:, :2] * scale, plain.points[:, 2:]], axis=1)
    return with_normals(replace(plain, points=points), crease=60.0)


def round_leg(top: float, bottom: float, height: float, segments: int = 20) -> Mesh:
    """A turned leg that tapers from radius ``top`` to ``bottom``, its foot in the origin."""
    return frustum(bottom, top, height, bevel=0.002, segments=segments)


def splayed(leg: Mesh, foot: ArrayLike, head: ArrayLike) -> Mesh:
    """Stand a leg so that its foot and its head come to two points (x, y), metres."""
    low, high = np.asarray(foot, dtype=np.float64), np.asarray(head, dtype=np.float64)
    height = float(leg.extent[1, 2])
    shear = np.eye(4)
    shear[:2, 2] = (high - low) / height
    shear[:2, 3] = low
    return leg.transformed(shear)


def corners(x: float, y: float) -> tuple[tuple[float, float], ...]:
    """The four points (+-x, +-y), front left first, counter-clockwise."""
    return (-x, -y), (x, -y), (x, y), (-x, y)


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


def _stretched(joint: Joint, scale: NDArray[np.float64], offset: NDArray[np.float64]) -> Joint:
    x, y, z = (scale * joint.origin + offset).tolist()
    axis = np.asarray(joint.axis) * scale
    length = float(np.linalg.norm(axis))
    a, b, c = (axis / length).tolist()
    # A slanted axis is nobody's; along the frame's axes a slide stretches with the object.
    travel = length if joint.kind == "rail" else 1.0
    limits = (joint.limits[0] * travel, joint.limits[1] * travel)
    return replace(joint, origin=(x, y, z), axis=(a, b, c), limits=limits)
