"""Points of surfaces that light arrives at, and stratified random numbers for them."""

import math
from dataclasses import dataclass

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.arrays import Ints as Rows


@dataclass(frozen=True, eq=False)
class Places:
    """Points of surfaces, seen from somewhere; several are one place.

    Attributes:
        position: (N, J, 3) world, metres.
        normal: (N, J, 3) unit shading normals on the side that is seen.
        view: (N, J, 3) unit, towards the camera.
    """

    position: Array
    normal: Array
    view: Array

    def __len__(self) -> int:
        return len(self.position)

    def spread(self, rays: int) -> tuple[Array, Array, Array, Rows]:
        """Points, normals, views and owners of as many rays from each place, over its points."""
        many, points = self.position.shape[:2]
        owner = np.repeat(np.arange(many), rays)
        point = np.tile(np.arange(rays) % points, many)
        return (
            self.position[owner, point],
            self.normal[owner, point],
            self.view[owner, point],
            owner,
        )


def strata(rng: np.random.Generator, many: int, rays: int) -> Array:
    """(many * rays, 2) random numbers, stratified for each owner; in random order."""
    side = math.isqrt(rays)
    while rays % side:
        side -= 1
    order = np.argsort(rng.random((many, rays)), axis=1).ravel()
    cells = np.stack(np.divmod(order, rays // side), axis=-1)
    return np.asarray((cells + rng.random((many * rays, 2))) / [side, rays // side])
