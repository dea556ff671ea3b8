"""What estimates pictures of one camera, a batch of samples at a time."""

from typing import Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray


class Integrator(Protocol):
    """Renders batches of samples of one camera."""

    planes: int
    """Pictures that a batch gives."""

    size: tuple[int, int]
    """Height and width of each, pixels or texels."""

    most: int
    """Samples that one batch may have at most."""

    broken: NDArray[np.bool_]
    """(height, width) where a batch gave no number."""

    def __call__(self, samples: int, seed: int) -> NDArray[np.float32]:
        """(planes, height, width, 3) means of one batch."""
        ...


@runtime_checkable
class SparseIntegrator(Integrator, Protocol):
    """One that can render some pixels, or some tiles of its pictures, side by side."""

    def sparse(self, pixels: NDArray[np.uint32]) -> Self:
        """The same for those alone, by their numbers row by row."""
        ...
