"""What is to be explained by base colours, lights and cameras, and the vector of these."""

from dataclasses import dataclass

import numpy as np

from openrooms_usd.appearance.observations import Observations
from openrooms_usd.appearance.transport import Transport
from openrooms_usd.arrays import Array


@dataclass(frozen=True)
class ColorPrior:
    """What a part's base colour is expected to be: its logarithms, and their spread.

    Most things of rooms are a little warm: wood, skin, paper.
    """

    level: float = 0.35
    level_sd: float = 1.0
    chroma: tuple[float, float, float] = (0.25, 0.0, -0.25)
    chroma_sd: float = 1.0


@dataclass(frozen=True, eq=False)
class Problem:
    """What is to be explained.

    Attributes:
        observations: Pixels.
        transport: How light reaches them.
        photographs: How many there are.
        lamps: How many of the sources are lamps; the rest are `ELEVATIONS`.
        base: (P, 3) first guess of base colours by part number.
        roughness: (P,) and
        metallic: (P,) taken as they are.
        priors: By part number.
        strengths: (K, 3) first guess, nits.
        sky: The number that stands for the surroundings.
    """

    observations: Observations
    transport: Transport
    photographs: int
    lamps: int
    base: Array
    roughness: Array
    metallic: Array
    priors: dict[int, ColorPrior]
    strengths: Array
    sky: int = -1


class State:
    """Parameters, as logarithms, in one vector with named parts."""

    def __init__(self, problem: Problem) -> None:
        self.seen = np.setdiff1d(problem.observations.part, [problem.sky])
        parts, sources, many = len(self.seen), len(problem.strengths), problem.photographs
        sizes = {
            "base": 3 * parts,
            "light": 3 * sources,
            "exposure": many,
            "balance": 3,
            "drift": 3 * many,
            "curve": 1,
            "vignetting": 1,
        }
        ends = np.cumsum([0, *sizes.values()])
        self.at = {
            name: slice(int(a), int(b))
            for name, a, b in zip(sizes, ends[:-1], ends[1:], strict=True)
        }
        self.size = int(ends[-1])
        self.row_of = np.full(len(problem.base), -1)
        self.row_of[self.seen] = np.arange(parts)
