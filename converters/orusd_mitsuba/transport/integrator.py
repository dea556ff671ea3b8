"""What estimates pictures of one camera, a batch of samples at a time."""

from typing import Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Floats, Mask


class Integrator(Protocol):
    """Renders batches of samples of one camera, in strips of rows."""

    planes: int
    """Pictures that a batch gives."""

    size: tuple[int, int]
    """Height and width of each, pixels or texels."""

    broken: Mask
    """(height, width) where a batch gave no number."""

    def strips(self, samples: int) -> list[slice]:
        """Rows to render at once, from the top, where a batch shall have so many samples.

        They depend on what is rendered alone, not on the machine: random numbers go by the strip.
        """
        ...

    def most_in(self, rows: slice) -> int:
        """Samples of each pixel that one batch of a strip may have."""
        ...

    def strip(self, rows: slice, samples: int, seed: int) -> Floats:
        """(planes, rows, width, 3) means of one batch; equal seeds give equal bits."""
        ...


@runtime_checkable
class SparseIntegrator(Integrator, Protocol):
    """One that can render some pixels, or some tiles of its pictures, side by side."""

    def sparse(self, pixels: NDArray[np.uint32]) -> Self:
        """The same for those alone, by their numbers row by row."""
        ...
