"""What a renderer is asked for a lightmap: the irradiance of texels, by light."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats, Ints
from openrooms_usd.description.rendering import DEFAULT_BOUNCES, REFERENCE, Method

LIFT_M: Final = 1e-4
"""How far above a surface its rays begin: what is nearer than this is not in their way."""


@dataclass(frozen=True, eq=False)
class TexelPoints:
    """The points of surfaces that texels stand for; a texel's value is the mean over its own.

    Attributes:
        corners: (M, 3, 3) triangles in the world, metres.
        normals: (M, 3) unit, to the side that is lit.
        first: (T + 1,) the first point of each texel, and the number of all. None has no point.
        triangles: (N,) the triangle that each point is on.
        weights: (N, 2) barycentric coordinates: how much the second and the third corner count.
    """

    corners: Array
    normals: Array
    first: Ints
    triangles: NDArray[np.int32]
    weights: Floats

    def __len__(self) -> int:
        """How many texels there are."""
        return len(self.first) - 1

    def positions(self) -> Array:
        """(N, 3) the points in the world, metres."""
        second, third = self.weights.T.astype(np.float64)
        a, b, c = np.moveaxis(self.corners[self.triangles], 1, 0)
        return np.asarray(a + second[:, None] * (b - a) + third[:, None] * (c - a))


@dataclass(frozen=True, eq=False)
class IrradianceRequest:
    """What to find out.

    Attributes:
        points: Where.
        samples: Paths for each texel.
        seed: Of random numbers.
        bounces: At most this many scatterings of light, the one at the texel included.
        method: How light is computed; one of those that the session has (`MethodicalSession`).
    """

    points: TexelPoints
    samples: int
    seed: int = 0
    bounces: int = DEFAULT_BOUNCES
    method: Method = REFERENCE


@dataclass(frozen=True, eq=False)
class Irradiance:
    """What arrives at texels.

    Attributes:
        values: (L, T, 3) float32, lux from each light, by the numbers of the stage's lights.
        samples: Paths that were followed for each texel.
        seconds: What it took.
        error: Estimated robust error of the sum (see `estimates`); None for a single sample.
        replaced: Texels for which the renderer put 0 where it found no number.
    """

    values: Floats
    samples: int
    seconds: float
    error: float | None
    replaced: int = 0


@runtime_checkable
class TexelLighting(Protocol):
    """A session of a renderer that can light texels."""

    def irradiance(
        self, request: IrradianceRequest, progress: Callable[[float], None]
    ) -> Irradiance:
        """The irradiance of every light at texels, about the shading normal with its normal map.

        Raises:
            RenderError: The backend cannot.
        """
        ...
