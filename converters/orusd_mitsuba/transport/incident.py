"""Incident radiance at points: its mean over each of many cells of solid angle.

What lights send straight is estimated by two techniques that the power heuristic combines (Veach
1997, section 9.2): directions that are spread evenly over each cell, and light samples, each
counted in the cell that it falls in. The first find broad light, the second the sun in a window and
small lamps. What comes by way of other surfaces is found by one path along each of the first.
"""

from copy import copy
from dataclasses import dataclass
from typing import Any, Final, Self

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.hemisphere import Cells
from openrooms_usd.render.scene.pictures import Array
from orusd_mitsuba.transport.lattice import TEA_ROUNDS
from orusd_mitsuba.transport.light_index import LightIndex
from orusd_mitsuba.transport.path_tracing import PathAccumulator, power_heuristic
from orusd_mitsuba.transport.paths import Paths, TracedPaths

# Paths in flight at once; each takes some 100 bytes of memory.
_PATHS_IN_FLIGHT: Final = 1 << 21
# Light samples of a point for each path from it: they cost a tenth of the paths.
_LIGHT_SAMPLES_PER_PATH: Final = 2
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

    def rows(self, which: slice | NDArray[np.int64]) -> "Points":
        """Some of the points."""
        return Points(self.position[which], self.frames[which], self.geometric[which])


class IncidentRadiance:
    """Estimates the radiance that arrives at points.

    Args:
        built: The Mitsuba scene of a vectorized variant.
        index: Its lights.
        cells: How directions are divided.
        points: Where.
        depth: At most this many segments of a path from a light to a point.
        light_samples: For each direction that is spread over the cells.
        paths: How they are followed; None: to their end.
    """

    def __init__(
        self, built: Any, index: LightIndex, cells: Cells, points: Points, depth: int,
        light_samples: int = _LIGHT_SAMPLES_PER_PATH, paths: Paths | None = None,
    ) -> None:  # fmt: skip
        self._built, self._points = built, points
        self._paths = paths or TracedPaths(built, index, depth)
        self._light_samples = light_samples * cells.count
        self._cells = _Cells(cells)

    def sparse(self, which: NDArray[np.int64]) -> Self:
        """The same at some of the points, by their numbers."""
        found = copy(self)
        found._points = self._points.rows(which)
        return found

    def __call__(self, samples: int, seed: int, which: slice = slice(None)) -> NDArray[np.float32]:
        """Estimate once; equal seeds give equal bits.

        Args:
            samples: Directions in each cell.
            seed: Of random numbers.
            which: Of the points, all unless told otherwise; P are these.

        Returns:
            (2, P, rows, columns, 3) what comes straight from lights, and all that comes.
        """
        shape = self._cells.shape
        batch = max(1, _PATHS_IN_FLIGHT // (shape.count * samples))
        chosen = self._points.rows(which)
        found = np.zeros((2, len(chosen), shape.rows, shape.columns, 3), dtype=np.float32)
        for number, start in enumerate(range(0, len(chosen), batch)):
            part = slice(start, start + batch)
            points = _Gathered(chosen.rows(part))
            spread = self._by_cells(points, samples, seed + 2 * number)
            found[0, part] = spread[0] + self._by_lights(points, samples, seed + 2 * number + 1)
            found[1, part] = found[0, part] + spread[1] + spread[2]
        return found

    def _by_cells(self, points: "_Gathered", samples: int, seed: int) -> NDArray[np.float32]:
        """(3, P, rows, columns, 3) by directions in every cell: scattered never, once, more."""
        cells = self._cells
        tasks = points.count * cells.shape.count
        path = dr.arange(mi.UInt32, tasks * samples)
        each = dr.opaque(mi.UInt32, samples)
        task = path // each
        point, cell = task // cells.shape.count, task % cells.shape.count
        at, frame = points.at(point)
        d = frame.to_world(cells.direction(cell, _lattice(path % each, samples, task, seed)))
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed & 0xFFFFFFFF, tasks * samples)
        accumulator = PathAccumulator(tasks * samples, None)
        density = 1.0 / (self._light_samples * cells.solid_angle(cell))
        ahead = dr.dot(at.n, d) >= 0.0
        self._paths.follow(sampler, at.spawn_ray(d), accumulator, active=ahead, begun=(at, density))
        sums = dr.block_sum(accumulator.kinds, samples)
        return cells.image(sums, points.count) / np.float32(samples)

    def _by_lights(self, points: "_Gathered", samples: int, seed: int) -> NDArray[np.float32]:
        """(P, rows, columns, 3) what is scattered never, by light samples."""
        cells = points.count * self._cells.shape.count
        strands = min(max(1, _PATHS_IN_FLIGHT // cells), self._light_samples * samples)
        sums = dr.zeros(mi.Float, 3 * cells * strands)
        each, rival = self._light_samples * samples // strands, 1.0 / self._light_samples
        _sample_lights(self._built, self._cells, points, each, strands, rival, seed, sums)
        return np.asarray(self._cells.image(dr.block_sum(sums, strands), points.count)[0])


@dr.syntax
def _sample_lights(
    built: Any,
    cells: "_Cells",
    points: "_Gathered",
    light_samples: int,
    strands: int,
    rival: float,
    seed: int,
    sums: Any,
) -> None:
    """Add what lights send to each point to the cell that it comes through.

    Each strand has its own cells, so that no two threads add to the same place.

    Args:
        built: The Mitsuba scene.
        cells: How directions are divided.
        points: Where.
        light_samples: For each strand.
        strands: Parts of the light samples of a point, each a thread.
        rival: How many directions of a cell there are for each light sample.
        seed: Of random numbers.
        sums: (3 * P * cells * strands) receives the means over the cells.
    """
    # As variables, not as parts of the compiled code: all cameras share it.
    stride, each, planes = (
        dr.opaque(mi.UInt32, count) for count in (strands, light_samples, points.count)
    )
    weight = 1.0 / mi.Float(each * stride)
    thread = dr.arange(mi.UInt32, points.count * strands)
    point, strand = thread // stride, thread % stride
    at, frame = points.at(point)
    sampled = mi.UInt32(0)
    while sampled < each:
        sample = _lattice(sampled * stride + strand, light_samples * strands, point, seed)
        to, incident = built.sample_emitter_direction(at, sample, True)
        cell, inside = cells.containing(frame.to_local(to.d))
        inside &= (to.pdf > 0.0) & (dr.dot(at.n, to.d) >= 0.0)
        size = cells.solid_angle(cell, inside)
        share = dr.select(to.delta, 1.0, power_heuristic(to.pdf, rival / size))
        value = incident * share * weight / size
        for channel in range(3):
            place = (channel * planes + point) * cells.shape.count + cell
            dr.scatter_reduce(
                dr.ReduceOp.Add, sums, value[channel], place * stride + strand, inside,
                mode=dr.ReduceMode.NoConflicts,
            )  # fmt: skip
        sampled += 1


class _Gathered:
    """`Points` as arrays of the active variant."""

    def __init__(self, points: Points) -> None:
        self.count = len(points)
        self._position = mi.Point3f(*_columns(points.position))
        self._geometric = mi.Normal3f(*_columns(points.geometric))
        self._axes = [mi.Vector3f(*_columns(points.frames[:, row])) for row in range(3)]

    def at(self, point: Any) -> tuple[Any, "_Frame"]:
        """The interactions at some of the points, and the frames there."""
        found = dr.zeros(mi.SurfaceInteraction3f, dr.width(point))
        found.p = dr.gather(mi.Point3f, self._position, point)
        found.n = dr.gather(mi.Normal3f, self._geometric, point)
        return found, _Frame(*(dr.gather(mi.Vector3f, axis, point) for axis in self._axes))


class _Frame:
    """Three unit vectors, of either handedness, which Mitsuba's own frames have not.

    No dataclass: Dr.Jit would carry its arrays through loops.
    """

    def __init__(self, x: Any, y: Any, z: Any) -> None:
        self.x, self.y, self.z = x, y, z

    def to_world(self, d: Any) -> Any:
        return self.x * d.x + self.y * d.y + self.z * d.z

    def to_local(self, d: Any) -> Any:
        return mi.Vector3f(dr.dot(d, self.x), dr.dot(d, self.y), dr.dot(d, self.z))


class _Cells:
    """`Cells` as arrays of the active variant."""

    def __init__(self, cells: Cells) -> None:
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

    def image(self, sums: Any, points: int) -> NDArray[np.float32]:
        """(N, P, rows, columns, 3) from the planes of red, green and blue of each of N."""
        shape = -1, 3, points, self.shape.rows, self.shape.columns
        return np.moveaxis(np.asarray(sums.numpy()).reshape(shape), 1, -1)


def _lattice(number: Any, count: int, key: Any, seed: int) -> Any:
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
