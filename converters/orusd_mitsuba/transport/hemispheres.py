"""Environment maps at a coarse grid of pixels: incident radiance at the surface, by direction."""

from copy import copy
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats, Mask
from openrooms_usd.geometry.hemisphere import HEMISPHERE, surface_frames
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.first_hits import Hits, first_hits
from openrooms_usd.rendering.scene.ground_truth import GroundTruth
from openrooms_usd.rendering.scene.rays import RayTracer
from openrooms_usd.usd.cameras import PinholeCamera
from orusd_mitsuba.transport.arrival import Arrival
from orusd_mitsuba.transport.cells import Layout, Points
from orusd_mitsuba.transport.incident import IncidentRadiance
from orusd_mitsuba.transport.light_index import LightIndex
from orusd_mitsuba.transport.strips import most_samples, strips

PLANES: Final = ("environment_direct", "environment")
_SAMPLES_A_BATCH: Final = 1 << 23


class HemisphereIntegrator:
    """Renders batches of samples of the hemispheres of one camera.

    Args:
        scene: The arrays.
        built: The Mitsuba scene of a vectorized variant.
        index: Its lights.
        tracer: Finds what the pixels see.
        camera: The camera, its intrinsics for pictures of ``grid``'s size: `coarse`.
        grid: Columns and rows of hemispheres.
        depth: At most this many segments of a path from a light to the camera, as of a
            `PathIntegrator`: the last one leads from the hemisphere's point to the camera.
        arrival: How light that comes to the points is found; None: by paths.

    Attributes:
        planes: 2, `PLANES`.
        size: Height and width of each.
        broken: (height, width) bool, cells in which a batch gave no number.
    """

    def __init__(
        self,
        scene: Scene,
        built: Any,
        index: LightIndex,
        tracer: RayTracer,
        camera: PinholeCamera,
        grid: tuple[int, int],
        depth: int,
        arrival: Arrival | None = None,
    ) -> None:
        columns, rows = grid
        hits = first_hits(scene, tracer, camera, columns, rows)
        self._pixels = hits.pixels
        points = surface_points(scene, camera, hits)
        self._incident = IncidentRadiance(built, index, HEMISPHERE, points, depth - 1, arrival)
        self.planes = len(PLANES)
        self._fit(rows, columns)

    def sparse(self, pixels: NDArray[np.uint32]) -> Self:
        """The same for some points of the grid alone: what it gives is one row of hemispheres.

        Args:
            pixels: Their numbers, row by row of the grid.
        """
        found = copy(self)
        seen = np.isin(pixels, self._pixels)
        found._pixels = np.flatnonzero(seen)
        found._incident = self._incident.sparse(np.searchsorted(self._pixels, pixels[seen]))
        found._fit(1, len(pixels))
        return found

    def _fit(self, rows: int, columns: int) -> None:
        self._grid = rows, columns
        self.size = rows * HEMISPHERE.rows, columns * HEMISPHERE.columns
        self.broken = np.zeros(self.size, dtype=bool)

    def __call__(self, samples: int, seed: int) -> Floats:
        """Render one batch of all of them; equal seeds give equal bits.

        Args:
            samples: Directions in each cell.
            seed: Of random numbers.

        Returns:
            (2, rows elevations, columns azimuths, 3); 0 where nothing is seen.
        """
        return self.strip(slice(0, self.size[0]), samples, seed)

    def strips(self, samples: int) -> list[slice]:
        """Rows to render at once, of whole hemispheres; see `Integrator`."""
        return strips(self.size, self.planes, samples, _SAMPLES_A_BATCH, HEMISPHERE.rows)

    def most_in(self, rows: slice) -> int:
        """Samples of each cell that one batch of a strip may have."""
        return most_samples(rows, self.size[1], _SAMPLES_A_BATCH)

    def strip(self, rows: slice, samples: int, seed: int) -> Floats:
        """Render one batch of some rows of whole hemispheres; equal seeds give equal bits.

        Args:
            rows: Of cells.
            samples: Directions in each cell.
            seed: Of random numbers.

        Returns:
            (2, rows, columns azimuths, 3); 0 where nothing is seen.
        """
        above, below = rows.start // HEMISPHERE.rows, rows.stop // HEMISPHERE.rows
        columns, width = self._grid[1], self.size[1]
        first, last = np.searchsorted(self._pixels, [above * columns, below * columns])
        row, column = np.divmod(self._pixels[first:last], columns)
        corners = (row - above) * HEMISPHERE.rows * width + column * HEMISPHERE.columns
        layout = Layout(corners, width, (rows.stop - rows.start) * width)
        found = self._incident(samples, seed, slice(first, last), layout)
        found = found.reshape(self.planes, -1, width, 3)
        # No number in a sum tells of it wherever it is, for little time.
        if not np.isfinite(found.sum()):
            finite: Mask = np.isfinite(found)
            self.broken[rows] |= ~np.all(finite, axis=(0, -1))
            found = np.where(finite, found, np.float32(0.0))
        return found


def coarse(camera: PinholeCamera, size: tuple[int, int], grid: tuple[int, int]) -> Array:
    """(3, 3) intrinsics of the same view as a picture of another size.

    Args:
        camera: With intrinsics for pictures of ``size``.
        size: Width and height, pixels.
        grid: Columns and rows.
    """
    scale = [grid[0] / size[0], grid[1] / size[1], 1.0]
    return np.asarray(np.diag(scale) @ camera.K)


def surface_points(scene: Scene, camera: PinholeCamera, hits: Hits) -> Points:
    """Where pixels' centres meet surfaces, with the frames that their hemispheres have.

    Args:
        scene: The arrays.
        camera: What sees them.
        hits: What it sees.
    """
    truth = GroundTruth(scene, camera, hits)
    normals, geometric = (
        unit(truth.channel(name).reshape(-1, 3)[hits.pixels].astype(np.float64))
        for name in ("normal", "normal_geometric")
    )
    R = camera.world_from_camera[:3, :3]
    frames = surface_frames(normals, -R[:, 1], R[:, 2])
    return Points(hits.position - scene.origin, frames, geometric)
