"""Roughness, and what is metal, by how pixels of a part change with the view.

Each part is explained by its diffuse light and the mirror lobe of each roughness, once as a
dielectric and once as a metal. What fits decides, together with what the part was expected to be.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from openrooms_usd.appearance.problem import Problem
from openrooms_usd.appearance.solving import BELOW_GLOSS, DIELECTRIC, Solution, radiosity
from openrooms_usd.appearance.transport import ROUGHNESSES, Gather
from openrooms_usd.arrays import Array, Mask

_LEAST_VALUES: Final = 30
# Neighbours err alike: so much of the evidence is independent.
_ALONE: Final = 0.02
_ROUGHNESS_SD: Final = 0.15
# Roughness of what turns out to be a dielectric, or a metal, against expectation.
_USUAL: Final = (0.5, 0.25)
# Elements blur what metals mirror, which costs them about so much where there is evidence.
_BLUR: Final = 3.0
# What counts for a metal where one was expected.
_EXPECTED: Final = 2.0
_UNEXPECTED: Final = -0.6
# Photographs that tell nothing of metals, and so many more that tell all.
_FEW_VIEWS: Final = 2
_MANY_VIEWS: Final = 6
_LEAST_OF_A_PRIMARY: Final = 4
_FLOOR: Final = 0.08
_SPREADS: Final = (0.07, 0.1, 0.16, 0.25, 0.4)
_STEPS: Final = 6

# Metals reflect about so much, and dielectrics no more than that.
_METAL_LEVEL: Final = 0.65
_METAL_SD: Final = 0.3
_MOST_DIFFUSE: Final = 0.85


@dataclass(frozen=True, eq=False)
class _Part:
    """What is seen of a part: (n, 3) each, with lobes by roughness in front."""

    radiance: Array
    usable: Mask
    weight: Array
    diffuse: Array
    facing: Array
    rest: Array
    noise: Array


def tell_gloss(problem: Problem, found: Solution, expected: Problem) -> Problem:
    """The problem with roughness and metals as the photographs have them.

    Args:
        problem: As it was solved.
        found: Its solution.
        expected: The problem before any gloss was found: the expected colours of parts.
    """
    obs = problem.observations
    camera = found.exposure[obs.photograph][:, None] * found.balance[obs.photograph]
    camera = camera / (1.0 + found.vignetting * obs.radius**2)[:, None] ** 2
    radiance = found.curve.linear(obs.value) / camera
    diffuse, facing, rest, noise = _arriving(problem, found)
    roughness, metallic = problem.roughness.copy(), problem.metallic.copy()
    for part in np.setdiff1d(obs.part, [problem.sky]):
        rows = np.flatnonzero(obs.part == part)
        if obs.usable[rows].sum() < _LEAST_VALUES:
            continue
        seen = _Part(
            radiance[rows],
            obs.usable[rows],
            obs.weight[rows],
            diffuse[rows],
            facing[:, rows],
            rest[:, rows],
            noise[:, rows],
        )
        views = len(np.unique(obs.photograph[rows]))
        usual = float(expected.roughness[part]), bool(expected.metallic[part] > 0.5)
        roughness[part], metallic[part] = _told(seen, views, *usual)
    return replace(problem, roughness=roughness, metallic=metallic, base=found.base)


def _told(seen: _Part, views: int, usual: float, was_metal: bool) -> tuple[float, float]:
    """Roughness and metallic of a part, of which that many photographs exist."""
    fine = np.linspace(ROUGHNESSES[0], 0.95, 60)
    totals = []
    for metal in (False, True):
        costs = [_cost(seen, level, metal) for level in range(len(ROUGHNESSES))]
        center = usual if metal == was_metal else _USUAL[metal]
        prior = ((fine - center) / _ROUGHNESS_SD) ** 2
        totals.append(np.interp(fine, ROUGHNESSES, costs) + prior)
    evidence = min(max(views - _FEW_VIEWS, 0) / _MANY_VIEWS, 1.0)
    totals[1] -= _BLUR * evidence + (_EXPECTED if was_metal else _UNEXPECTED)
    metal = bool(totals[1].min() < totals[0].min())
    weight = np.exp(-0.5 * (totals[metal] - totals[metal].min()))
    return float((fine * weight).sum() / weight.sum()), float(metal)


def _arriving(problem: Problem, found: Solution) -> tuple[Array, Array, Array, Array]:
    """(M, 3) diffuse light, (levels, M, 3) of both parts of mirror lobes, and its variance."""
    transport = problem.transport
    diffuse: list[Array] = []
    lobes: list[tuple[list[Array], ...]] = []
    for c in range(3):
        strengths = found.strengths[:, c]
        radiance = radiosity(transport, found.base, problem.metallic, c) @ strengths
        diffuse.append(transport.diffuse.direct @ strengths + transport.diffuse.form @ radiance)
        both = [
            [
                pair[index].direct @ strengths + pair[index].form @ radiance
                for pair in transport.glossy
            ]
            for index in (0, 1)
        ]
        noise = [_variance(facing, strengths, radiance) for facing, _ in transport.glossy]
        lobes.append((*both, noise))
    facing, rest, variance = (np.stack([one[i] for one in lobes], axis=-1) for i in range(3))
    return np.stack(diffuse, axis=-1), facing, rest, variance


def _variance(lobe: Gather, strengths: Array, radiance: Array) -> Array:
    """(M,) about the variance of what few rays gather."""
    squares = lobe.form.multiply(lobe.form) @ radiance**2
    return np.asarray(squares + np.square(lobe.direct * strengths).sum(axis=1))


def _cost(seen: _Part, level: int, metal: bool) -> float:
    """Robust cost of explaining a part, with what the model errs by as it suits best."""
    return min(_fit(seen, level, metal, spread) for spread in _SPREADS)


def _fit(seen: _Part, level: int, metal: bool, spread: float) -> float:
    """The same, if the model errs by some share of what is seen."""
    facing, rest = seen.facing[level], seen.rest[level]
    slope = facing if metal else BELOW_GLOSS * seen.diffuse
    offset = rest if metal else DIELECTRIC * facing + rest
    floor = _FLOOR * np.median(np.maximum(seen.radiance, 0.0), axis=0) + 1e-9
    total, colors = 0.0, []
    for c in range(3):
        rows = seen.usable[:, c]
        if rows.sum() < _LEAST_OF_A_PRIMARY:
            continue
        value, weight = seen.radiance[rows, c], seen.weight[rows]
        usual, variance = (
            (share * np.maximum(value, 0.0) + floor[c]) ** 2 for share in (_SPREADS[0], spread)
        )
        color, cost = _color(
            value - offset[rows, c],
            slope[rows, c],
            weight,
            variance,
            seen.noise[level, rows, c],
            metal,
        )
        colors.append(color)
        total += float(cost - (weight * np.log(usual)).sum())
    total *= _ALONE
    level_log = float(np.log(max(float(np.mean(colors)), 1e-3))) if colors else 0.0
    if metal:
        return total + float(((level_log - np.log(_METAL_LEVEL)) / _METAL_SD) ** 2)
    return total + float((max(level_log - np.log(_MOST_DIFFUSE), 0.0) / 0.1) ** 2)


def _color(
    value: Array, slope: Array, weight: Array, variance: Array, noise: Array, metal: bool
) -> tuple[float, float]:
    """The factor of ``slope`` that explains values best, and the cost of the rest."""
    color, robust = 0.5, np.ones(len(value))
    for _ in range(_STEPS):
        own = color if metal else DIELECTRIC
        total = variance + own**2 * noise
        q = weight * robust / total
        color = float((q * slope * value).sum() / max(float((q * slope * slope).sum()), 1e-30))
        color = min(max(color, 0.003), 1.5)
        residual = (value - color * slope) / np.sqrt(total)
        robust = 1.0 / (1.0 + (residual / 2.0) ** 2)
    loss = 4.0 * np.log1p((residual / 2.0) ** 2) + np.log(total)
    return color, float((weight * loss).sum())
