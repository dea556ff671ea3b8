"""Incident radiance at points: its mean over each of many cells of solid angle.

What lights send straight is estimated by two techniques that the power heuristic combines (Veach
1997, section 9.2): directions that are spread evenly over each cell, and light samples, each
counted in the cell that it falls in. The first find broad light, the second the sun in a window and
small lamps. What comes by way of other surfaces is found along each of the first.
"""

from copy import copy
from typing import Any, Final, Self

import drjit as dr
import mitsuba as mi

from openrooms_usd.arrays import Floats, Ints
from openrooms_usd.geometry.hemisphere import HemisphereGrid
from orusd_mitsuba.transport.arrival import Arrival, Start, TracedArrival, reference_light_samples
from orusd_mitsuba.transport.cells import (
    CellArrays,
    CellPictures,
    Layout,
    PointArrays,
    Points,
    lattice_point,
)
from orusd_mitsuba.transport.light_index import LightIndex
from orusd_mitsuba.transport.path_tracing import power_heuristic

# Paths in flight at once; each takes some 100 bytes of memory.
_PATHS_IN_FLIGHT: Final = 1 << 21


class IncidentRadiance:
    """Estimates the radiance that arrives at points.

    Args:
        built: The Mitsuba scene of a vectorized variant.
        index: Its lights.
        cells: How directions are divided.
        points: Where.
        depth: At most this many segments of a path from a light to a point.
        arrival: How light that comes along the directions is found; None: by paths.
    """

    def __init__(
        self,
        built: Any,
        index: LightIndex,
        cells: HemisphereGrid,
        points: Points,
        depth: int,
        arrival: Arrival | None = None,
    ) -> None:
        self._built, self._index, self._points = built, index, points
        self._arrival: Arrival = arrival or TracedArrival(built, index, depth)
        self._light_samples = self._arrival.light_samples(cells.count)
        self._cells = CellArrays(cells)

    def sparse(self, which: Ints) -> Self:
        """The same at some of the points, by their numbers.

        All methods take the light samples of the reference there, so that what is compared differs
        in nothing that has no bias.
        """
        found = copy(self)
        found._points = self._points.rows(which)
        found._light_samples = reference_light_samples(self._cells.shape.count)
        return found

    def __call__(
        self, samples: int, seed: int, which: slice = slice(None), layout: Layout | None = None
    ) -> Floats:
        """Estimate once; equal seeds give equal bits.

        Args:
            samples: Directions in each cell.
            seed: Of random numbers.
            which: Of the points, all unless told otherwise; P are these.
            layout: Where their cells lie; None: one point after the other.

        Returns:
            (2, pixels, 3) what comes straight from lights, and all that comes; as the layout has
            it, 0 where no cell lies.
        """
        shape = self._cells.shape
        batch = max(1, _PATHS_IN_FLIGHT // (shape.count * samples))
        chosen = self._points.rows(which)
        pictures = CellPictures(layout or Layout.listed(len(chosen), shape), shape, 2)
        for number, start in enumerate(range(0, len(chosen), batch)):
            part = slice(start, start + batch)
            points = PointArrays(chosen.rows(part))
            split = self._light_samples_of(points, samples)
            straight, scattered = self._by_cells(points, samples, split, seed + 2 * number)
            straight += self._by_lights(points, samples, split, seed + 2 * number + 1)
            pictures.put(part, (straight, straight + scattered))
        return pictures.pixels()

    def _light_samples_of(self, points: PointArrays, samples: int) -> tuple[int, int]:
        """The threads that a point's light samples are split among, and how many each has."""
        wanted = self._light_samples * samples
        cells = points.count * self._cells.shape.count
        each = -(-wanted // min(max(1, _PATHS_IN_FLIGHT // cells), wanted))
        return -(-wanted // each), each

    def _by_cells(
        self, points: PointArrays, samples: int, split: tuple[int, int], seed: int
    ) -> tuple[Any, Any]:
        """The means over cells, by directions in each: scattered never, and the rest."""
        cells, count = self._cells, self._cells.shape.count
        each, rival = _opaque(samples, split)

        def begin(path: Any) -> Start:
            task = path // each
            point, cell = task // count, task % count
            at, frame = points.at(point)
            sample = lattice_point(path % each, samples, task, seed)
            d = frame.to_world(cells.direction(cell, sample))
            density = rival / cells.solid_angle(cell)
            return Start(at, at.spawn_ray(d), density, dr.dot(at.n, d) >= 0.0)

        found = self._arrival.arriving(begin, points.count * count * samples, seed)
        part = dr.rcp(mi.Float(each))
        straight, scattered = (
            mi.Color3f(*(_summed(plane, samples) * part for plane in color)) for color in found
        )
        return straight, scattered

    def _by_lights(
        self, points: PointArrays, samples: int, split: tuple[int, int], seed: int
    ) -> Any:
        """The means over cells of what is scattered never, by light samples."""
        cells = points.count * self._cells.shape.count
        sums = dr.zeros(mi.Float, 3 * cells * split[0])
        _, rival = _opaque(samples, split)
        _sample_lights(self._built, self._index, self._cells, points, split, rival, seed, sums)
        planes = _summed(sums, split[0])
        task = dr.arange(mi.UInt32, cells)
        stride = dr.opaque(mi.UInt32, cells)
        return mi.Color3f(*(dr.gather(mi.Float, planes, k * stride + task) for k in range(3)))


def _opaque(samples: int, split: tuple[int, int]) -> tuple[Any, Any]:
    """The directions of a cell, and how many there are for each light sample of its point.

    As variables, not as parts of the compiled code.
    """
    return dr.opaque(mi.UInt32, samples), dr.opaque(mi.Float, samples / (split[0] * split[1]))


def _summed(values: Any, count: int) -> Any:
    """The sums of so many values side by side each."""
    return values if count == 1 else dr.block_sum(values, count)


@dr.syntax
def _sample_lights(
    built: Any,
    index: LightIndex,
    cells: CellArrays,
    points: PointArrays,
    split: tuple[int, int],
    rival: Any,
    seed: int,
    sums: Any,
) -> None:
    """Add what lights send to each point to the cell that it comes through.

    Each strand has its own cells, so that no two threads add to the same place.

    Args:
        built: The Mitsuba scene.
        index: Knows the panes.
        cells: How directions are divided.
        points: Where.
        split: Strands, parts of the light samples of a point, each a thread; and how many samples
            each has.
        rival: How many directions of a cell there are for each light sample.
        seed: Of random numbers.
        sums: (3 * P * cells * strands) receives the means over the cells.
    """
    # As variables, not as parts of the compiled code: all cameras share it.
    stride, each, planes = (dr.opaque(mi.UInt32, count) for count in (*split, points.count))
    weight = 1.0 / mi.Float(each * stride)
    thread = dr.arange(mi.UInt32, points.count * split[0])
    point, strand = thread // stride, thread % stride
    at, frame = points.at(point)
    sampled = mi.UInt32(0)
    while sampled < each:
        number = sampled * stride + strand
        sample = lattice_point(number, split[0] * split[1], point, seed)
        to, incident = built.sample_emitter_direction(at, sample, True)
        cell, inside = cells.containing(frame.to_local(to.d))
        inside &= (to.pdf > 0.0) & (dr.dot(at.n, to.d) >= 0.0)
        size = cells.solid_angle(cell, inside)
        share = dr.select(to.delta, 1.0, power_heuristic(to.pdf, rival / size))
        value = incident * share * weight / size
        value *= index.through(at.spawn_ray_to(to.p), inside)
        for channel in range(3):
            place = (channel * planes + point) * cells.shape.count + cell
            dr.scatter_reduce(
                dr.ReduceOp.Add,
                sums,
                value[channel],
                place * stride + strand,
                inside,
                mode=dr.ReduceMode.NoConflicts,
            )
        sampled += 1
