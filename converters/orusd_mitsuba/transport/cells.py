"""Points, the cells of solid angle about them, and pictures of these, for the active variant."""

from dataclasses import dataclass
from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.arrays import Array, Floats, Ints
from openrooms_usd.geometry.hemisphere import HemisphereGrid
from orusd_mitsuba.transport.lattice import TEA_ROUNDS

# 2^32 over the golden ratio: steps of it are spread evenly, however many they are.
_GOLDEN_STEP: Final = 2654435769
_BELOW_ONE: Final = 1.0 - 2.0**-24


@dataclass(frozen=True, eq=False)
class Points:
    """Where light arrives.

    Attributes:
        position: (P, 3) metres, relative to Mitsuba's origin.
        frames: (P, 3, 3) rows: unit vectors of the frames of the cells, in the world.
        geometric: (P, 3) unit normal of the surface, on the side that receives: from behind it
            nothing arrives; 0 in free space.
    """

    position: Array
    frames: Array
    geometric: Array

    def __len__(self) -> int:
        return len(self.position)

    def rows(self, which: slice | Ints) -> "Points":
        """Some of the points."""
        return Points(self.position[which], self.frames[which], self.geometric[which])


@dataclass(frozen=True, eq=False)
class Layout:
    """Where the cells of points lie in a picture, whose pixels are numbered row by row.

    Attributes:
        first: (P,) the pixel of each point's first cell.
        stride: Pixels from one row of cells to the next.
        size: Pixels of the picture.
    """

    first: Ints
    stride: int
    size: int

    @staticmethod
    def listed(points: int, cells: HemisphereGrid) -> "Layout":
        """One point after the other."""
        return Layout(np.arange(points) * cells.count, cells.columns, points * cells.count)


class PointArrays:
    """`Points` as arrays of the active variant.

    Args:
        points: Where.

    Attributes:
        count: How many there are.
    """

    def __init__(self, points: Points) -> None:
        self.count = len(points)
        self._position = mi.Point3f(*_columns(points.position))
        self._geometric = mi.Normal3f(*_columns(points.geometric))
        self._axes = [mi.Vector3f(*_columns(points.frames[:, row])) for row in range(3)]

    def at(self, point: Any) -> tuple[Any, "AxisTriple"]:
        """The interactions at some of the points, and the frames there."""
        found = dr.zeros(mi.SurfaceInteraction3f, dr.width(point))
        found.p = dr.gather(mi.Point3f, self._position, point)
        found.n = dr.gather(mi.Normal3f, self._geometric, point)
        return found, AxisTriple(*(dr.gather(mi.Vector3f, axis, point) for axis in self._axes))


class AxisTriple:
    """Three unit vectors, of either handedness, which Mitsuba's own frames have not.

    No dataclass: Dr.Jit would carry its arrays through loops.
    """

    def __init__(self, x: Any, y: Any, z: Any) -> None:
        self.x, self.y, self.z = x, y, z

    def to_world(self, d: Any) -> Any:
        """A vector of the frame in the world."""
        return self.x * d.x + self.y * d.y + self.z * d.z

    def to_local(self, d: Any) -> Any:
        """A vector of the world in the frame."""
        return mi.Vector3f(dr.dot(d, self.x), dr.dot(d, self.y), dr.dot(d, self.z))


class CellArrays:
    """`HemisphereGrid` as arrays of the active variant.

    Args:
        cells: How directions are divided.

    Attributes:
        shape: The same.
    """

    def __init__(self, cells: HemisphereGrid) -> None:
        self.shape = cells
        self._edges = mi.Float(1.0 - cells.edges)
        self._solid_angles = mi.Float(cells.solid_angles)

    def solid_angle(self, cell: Any, active: Any = True) -> Any:
        """Of a cell, steradian."""
        return dr.gather(mi.Float, self._solid_angles, cell // self.shape.columns, active)

    def direction(self, cell: Any, sample: Any) -> Any:
        """A unit vector of a cell, even by solid angle, in the cells' frame."""
        row, column = cell // self.shape.columns, cell % self.shape.columns
        # One minus the cosine: near the pole the cosine itself has few digits.
        low, high = (dr.gather(mi.Float, self._edges, row + side) for side in (0, 1))
        versine = dr.lerp(low, high, sample.x)
        sine = dr.sqrt(dr.maximum(0.0, versine * (2.0 - versine)))
        phi = ((column + sample.y) / self.shape.columns - 0.5) * dr.two_pi
        return mi.Vector3f(sine * dr.cos(phi), sine * dr.sin(phi), 1.0 - versine)

    def containing(self, d: Any) -> tuple[Any, Any]:
        """The cell of a unit vector in the cells' frame, and whether it is in any."""
        rows, columns = self.shape.rows, self.shape.columns
        theta = dr.atan2(dr.sqrt(d.x * d.x + d.y * d.y), d.z)
        turn = dr.atan2(d.y, d.x) / dr.two_pi + 0.5
        row = dr.minimum(mi.UInt32(theta * (rows / self.shape.extent)), rows - 1)
        column = dr.minimum(mi.UInt32(turn * columns), columns - 1)
        return row * columns + column, theta <= self.shape.extent


class CellPictures:
    """Pictures of the cells of many points, which are put in batch by batch.

    Args:
        layout: Where the cells lie.
        cells: How directions are divided.
        count: Of pictures.
    """

    def __init__(self, layout: Layout, cells: HemisphereGrid, count: int) -> None:
        self._layout, self._cells = layout, cells
        self._pixels = dr.zeros(mi.Float, count * 3 * layout.size)

    def put(self, points: slice, colors: tuple[Any, ...]) -> None:
        """Put in the cells of some points.

        Args:
            points: Which, of those that the layout is for.
            colors: For each picture, in the order of points and then of cells.
        """
        first = mi.UInt32(self._layout.first[points].astype(np.uint32))
        task = dr.arange(mi.UInt32, dr.width(first) * self._cells.count)
        point, cell = task // self._cells.count, task % self._cells.count
        row, column = cell // self._cells.columns, cell % self._cells.columns
        pixel = dr.gather(mi.UInt32, first, point) + column
        pixel += row * dr.opaque(mi.UInt32, self._layout.stride)
        for number, color in enumerate(colors):
            corner = 3 * (pixel + dr.opaque(mi.UInt32, number * self._layout.size))
            for channel in range(3):
                dr.scatter(self._pixels, color[channel], corner + channel)
        dr.eval(self._pixels)

    def pixels(self) -> Floats:
        """(N, size, 3) what was put in, 0 elsewhere."""
        return np.asarray(self._pixels.numpy()).reshape(-1, self._layout.size, 3)


def lattice_point(number: Any, count: int, key: Any, seed: int) -> Any:
    """Point ``number`` of ``count`` that are spread evenly over a square.

    They are shifted at random, by ``key`` and seed, so that each by itself is even over the square.
    """
    # As variables, not as parts of the compiled code.
    drawn: Any = mi.sample_tea_32
    shift = drawn(key, dr.opaque(mi.UInt32, seed & 0xFFFFFFFF), TEA_ROUNDS)
    across = number * dr.opaque(mi.UInt32, (1 << 32) // count & 0xFFFFFFFF) + shift[0]
    along = number * mi.UInt32(_GOLDEN_STEP) + shift[1]
    return mi.Point2f(*(dr.minimum(mi.Float(u) * 2.0**-32, _BELOW_ONE) for u in (across, along)))


def _columns(vectors: Array) -> list[Any]:
    # Each for itself: parts of one array would be taken out by code that knows how long they are.
    return [mi.Float(np.ascontiguousarray(column, dtype=np.float32)) for column in vectors.T]
