"""What rooms, lamps, skies and cameras usually are: it decides what photographs leave open."""

from typing import Final

import numpy as np

from openrooms_usd.appearance.directions import ELEVATIONS
from openrooms_usd.appearance.problem import ColorPrior, Problem, State
from openrooms_usd.arrays import Array

_MOST_REFLECTED: Final = 0.92


class Priors:
    """Linear priors: rows of (coefficients, expected, standard deviation)."""

    def __init__(self, problem: Problem, state: State) -> None:
        rows: list[tuple[dict[int, float], float, float]] = []
        start = state.at["base"].start
        for index, part in enumerate(state.seen):
            prior = problem.priors.get(int(part), ColorPrior())
            own = [start + 3 * index + c for c in range(3)]
            mean = dict.fromkeys(own, 1.0 / 3.0)
            rows.append((mean, np.log(prior.level), prior.level_sd))
            for one in own:
                off = dict.fromkeys(own, -1.0 / 3.0)
                off[one] += 1.0
                rows.append((off, 0.0, prior.chroma_sd))
        self._base = slice(state.at["base"].start, state.at["base"].stop)
        start = state.at["light"].start
        for index, guess in enumerate(problem.strengths):
            own = [start + 3 * index + c for c in range(3)]
            is_lamp = index < problem.lamps
            mean = dict.fromkeys(own, 1.0 / 3.0)
            rows.append((mean, float(np.log(guess).mean()), 2.5))
            # Hues of lamps lie along the black bodies, from candles to cool white.
            hue = _LAMP if is_lamp else _DAYLIGHT
            along, across = (0.45, 0.08) if is_lamp else (0.12, 0.04)
            red, green, blue = own
            rows.append(({red: 0.5, blue: -0.5}, 0.5 * (hue[0] - hue[2]), along))
            middle = {red: 0.5, blue: 0.5, green: -1.0}
            rows.append((middle, 0.5 * (hue[0] + hue[2]) - hue[1], across))
        for index in range(problem.lamps, len(problem.strengths) - 1):
            for c in range(3):
                step = {start + 3 * index + c: -1.0, start + 3 * (index + 1) + c: 1.0}
                low, high = ELEVATIONS[index - problem.lamps : index - problem.lamps + 2]
                # The sky changes slowly; at the horizon anything may stand.
                rows.append((step, 0.0, 1.5 if low < 0.0 < high else 0.3))
        start = state.at["balance"].start
        rows.append(({start + 1: 1.0}, 0.0, 0.001))
        rows += [({start + c: 1.0}, 0.0, 0.4) for c in (0, 2)]
        start = state.at["drift"].start
        for index in range(3 * problem.photographs):
            rows.append(({start + index: 1.0}, 0.0, 0.02))
        for c in range(3):
            every = {start + 3 * i + c: 1.0 for i in range(problem.photographs)}
            rows.append((every, 0.0, 0.001))
        rows.append(({state.at["curve"].start: 1.0}, 0.0, 0.25))
        rows.append(({state.at["vignetting"].start: 1.0}, 0.0, 0.1))
        self._A = np.zeros((len(rows), state.size))
        for number, (row, _, sd) in enumerate(rows):
            for place, value in row.items():
                self._A[number, place] = value / sd
        self._b = np.array([expected / sd for _, expected, sd in rows])

    def _over(self, theta: Array) -> Array:
        """How far base colours lie above what reflects."""
        return np.asarray(np.maximum(theta[self._base] - np.log(_MOST_REFLECTED), 0.0) / 0.03)

    def cost(self, theta: Array) -> float:
        """The sum of squares."""
        return float(((self._A @ theta - self._b) ** 2).sum() + (self._over(theta) ** 2).sum())

    def normal(self, theta: Array) -> tuple[Array, Array]:
        """The normal matrix and the gradient."""
        matrix, slope = self._A.T @ self._A, self._A.T @ (self._A @ theta - self._b)
        over = self._over(theta)
        places = np.arange(self._base.start, self._base.stop)
        matrix[places, places] += (over > 0.0) / 0.03**2
        slope[places] += over / 0.03
        return matrix, slope


# Logarithms of linear Rec.709 primaries of a black body of 3000 K and of daylight of 6500 K.
_LAMP: Final = tuple(np.log([1.0, 0.69, 0.41]))
_DAYLIGHT: Final = (0.0, 0.0, 0.0)
