"""What may be done to a view on its way: a contract, and chains.

A transform changes all that a sample has, together: pixels by what their channel is, ``K``, the
pose, hemispheres, boxes of lights. So what holds of a render holds of what comes out: depth along
the rays of ``K`` gives the positions, normals in the camera's and in the world's axes agree, lights
sum to the whole.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from openrooms_usd.loading.sample import Sample


class Transform(Protocol):
    """Makes a sample of another one; it can be pickled, and draws from the numbers it is given."""

    def __call__(self, sample: Sample, rng: np.random.Generator, /) -> Sample:
        """The new sample; the old one stays as it is.

        Raises:
            InputError: The sample cannot be changed so.
        """
        ...


@dataclass(frozen=True)
class Compose:
    """Transforms, one after the other.

    Attributes:
        steps: The transforms.
    """

    steps: Sequence[Transform]

    def __call__(self, sample: Sample, rng: np.random.Generator, /) -> Sample:
        """The sample after all of them."""
        for step in self.steps:
            sample = step(sample, rng)
        return sample
