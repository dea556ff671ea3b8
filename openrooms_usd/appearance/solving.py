"""Base colours, lights and cameras that predict photographs best, with how sure each is.

A photograph's value is ``curve(exposure * white balance * vignetting * radiance)``. Radiance is
linear in the sources and, but for interreflection, in base colours; `transport` has both. What
photographs do not tell, such as the common scale of light and exposure, is fixed by priors that
are stated below. Solved by damped Gauss-Newton steps with robust weights.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from openrooms_usd.appearance.curve import Curve
from openrooms_usd.appearance.priors import Priors
from openrooms_usd.appearance.problem import Problem, State
from openrooms_usd.appearance.transport import ROUGHNESSES, Gather, Transport
from openrooms_usd.arrays import Array
from openrooms_usd.arrays import Ints as Rows

DIELECTRIC: Final = 0.04
"""Reflectance at normal incidence of anything but metal."""

# What the gloss leaves for the diffuse part, and what it adds where light is reflected on.
BELOW_GLOSS: Final = 0.96
_GLOSS_ON: Final = 0.04
_BOUNCES: Final = 20
_DERIVED_BOUNCES: Final = 10
_ITERATIONS: Final = 14
# Standard deviations of a value: of the file and of the model, relative to the value's slope.
_VALUE_SD: Final = 0.008
_MODEL_SD: Final = 0.08
_ROBUST: Final = 2.0
# Errors of the model are alike among neighbours: so much of an observation counts as another one.
_ALONE: Final = 0.3
_LARGEST_STEP: Final = 0.7


@dataclass(frozen=True, eq=False)
class Solution:
    """What explains the photographs.

    Attributes:
        base: (P, 3) base colours by part number.
        base_sd: (P, 3) standard deviation of their logarithms; infinite where nothing was seen.
        strengths: (K, 3) nits.
        strengths_sd: (K, 3) standard deviation of their logarithms.
        exposure: (N,) per nit.
        balance: (N, 3) white-balance gains; that of green has a geometric mean of 1.
        curve: The camera's.
        vignetting: k of ``1 / (1 + k r^2)^2``.
        residual: (M, 3) value minus prediction.
        cost: Robust, of all values.
    """

    base: Array
    base_sd: Array
    strengths: Array
    strengths_sd: Array
    exposure: Array
    balance: Array
    curve: Curve
    vignetting: float
    residual: Array
    cost: float = np.inf
    history: tuple[float, ...] = field(default=())


def radiosity(transport: Transport, base: Array, metallic: Array, channel: int) -> Array:
    """(E, K) radiance of elements by a unit of each source, for one primary."""
    reflected = _reflected(transport, base, metallic)[:, channel, None]
    found = np.zeros_like(transport.between.direct)
    for _ in range(_BOUNCES):
        found = reflected * (transport.between.direct + transport.between.form @ found)
    return found


def _reflected(transport: Transport, base: Array, metallic: Array) -> Array:
    own, metal = base[transport.part], metallic[transport.part][:, None]
    return np.asarray(metal * own + (1.0 - metal) * (BELOW_GLOSS * own + _GLOSS_ON))


@dataclass(frozen=True, eq=False)
class Arrived:
    """(M, K) of one primary: what arrives at observations from a unit of each source."""

    radiance: Array
    diffuse: Array
    facing: Array
    rest: Array


def arrived(problem: Problem, base: Array, channel: int) -> Arrived:
    """What arrives at observations from a unit of each source, with all bounces."""
    transport, part = problem.transport, problem.observations.part
    radiance = radiosity(transport, base, problem.metallic, channel)
    diffuse = transport.diffuse.direct + transport.diffuse.form @ radiance
    low, share = roughness_levels(problem.roughness[part])
    facing, rest = (np.zeros_like(diffuse) for _ in range(2))
    for level in np.unique(np.concatenate([low, low + 1])):
        weight = np.where(low == level, 1.0 - share, np.where(low + 1 == level, share, 0.0))
        rows = np.flatnonzero(weight > 0.0)
        for total, lobe in zip((facing, rest), transport.glossy[level], strict=True):
            value = lobe.direct[rows] + lobe.form[rows] @ radiance
            total[rows] += weight[rows, None] * value
    return Arrived(radiance, diffuse, facing, rest)


def light_at(problem: Problem, found: "Solution", gathered: Gather) -> Array:
    """(N, 3) what arrives at places, nits.

    Args:
        problem: What was solved.
        found: Its solution.
        gathered: What the places gather.
    """
    columns = []
    for c in range(3):
        strengths = found.strengths[:, c]
        radiance = radiosity(problem.transport, found.base, problem.metallic, c) @ strengths
        columns.append(gathered.direct @ strengths + gathered.form @ radiance)
    return np.stack(columns, axis=-1)


def gloss_seen(problem: Problem, found: "Solution") -> Array:
    """(M, 3) what observations show of the mirror lobes of dielectrics, nits."""
    columns = []
    for c in range(3):
        got = arrived(problem, found.base, c)
        columns.append((DIELECTRIC * got.facing + got.rest) @ found.strengths[:, c])
    return np.stack(columns, axis=-1)


def roughness_levels(roughness: Array) -> tuple[Rows, Array]:
    """The lower of two `ROUGHNESSES` that values lie between, and the share of the upper."""
    steps = np.array(ROUGHNESSES)
    low = np.clip(np.searchsorted(steps, roughness, side="right") - 1, 0, len(steps) - 2)
    return low, np.clip((roughness - steps[low]) / (steps[low + 1] - steps[low]), 0.0, 1.0)


def solve(
    problem: Problem,
    curve: Curve | None = None,
    progress: Callable[[float], None] = lambda done: None,
    iterations: int = _ITERATIONS,
    start: Solution | None = None,
) -> Solution:
    """Find base colours, strengths of lights, exposures, white balance and curve."""
    state = State(problem)
    theta = _first(problem, state, curve or Curve()) if start is None else _again(state, start)
    prior = Priors(problem, state)
    damping = 1e-3
    rows = _linearised(problem, state, theta)
    cost = rows.cost + prior.cost(theta)
    history = [cost]
    for iteration in range(iterations):
        normal, slope = rows.normal()
        more, push = prior.normal(theta)
        normal, slope = normal + more, slope + push
        for _ in range(5):
            scaled = normal + damping * np.diag(np.diag(normal) + 1e-9)
            step = np.linalg.solve(scaled, -slope)
            step = np.clip(step, -_LARGEST_STEP, _LARGEST_STEP)
            trial = _linearised(problem, state, theta + step)
            value = trial.cost + prior.cost(theta + step)
            if value < cost:
                break
            damping *= 8.0
        else:
            break
        gain, theta, rows, cost = cost - value, theta + step, trial, value
        history.append(cost)
        damping = max(1e-6, damping / 6.0)
        progress((iteration + 1) / iterations)
        if gain < 1e-4 * cost:
            break
    normal, _ = rows.normal()
    spread = np.asarray(np.linalg.inv(normal + prior.normal(theta)[0]), dtype=np.float64)
    return _solution(problem, state, theta, spread, rows, cost, tuple(history))


@dataclass(frozen=True, eq=False)
class _Linearised:
    jacobian: Array
    residual: Array
    weight: Array
    difference: Array

    @property
    def cost(self) -> float:
        """Of Cauchy's loss."""
        scaled = self.residual / _ROBUST
        return float((self.weight * _ROBUST**2 * np.log1p(scaled**2)).sum())

    def normal(self) -> tuple[Array, Array]:
        """The normal matrix and the gradient, each row by its robust weight."""
        robust = self.weight / (1.0 + (self.residual / _ROBUST) ** 2)
        weighted = self.jacobian * robust[:, None]
        return self.jacobian.T @ weighted, weighted.T @ self.residual


def _unpacked(problem: Problem, state: State, theta: Array) -> tuple[Array, Array]:
    base = problem.base.copy()
    base[state.seen] = np.minimum(np.exp(theta[state.at["base"]].reshape(-1, 3)), 1.0)
    return base, np.exp(theta[state.at["light"]].reshape(-1, 3))


def _linearised(problem: Problem, state: State, theta: Array) -> _Linearised:
    obs = problem.observations
    base, strengths = _unpacked(problem, state, theta)
    curve = Curve(float(theta[state.at["curve"]][0]))
    k = float(theta[state.at["vignetting"]][0])
    metal = problem.metallic[obs.part]
    drift = theta[state.at["drift"]].reshape(-1, 3)
    log_camera = theta[state.at["exposure"]][obs.photograph][:, None]
    log_camera = log_camera + theta[state.at["balance"]] + drift[obs.photograph]
    log_camera = log_camera - 2.0 * np.log1p(max(k, -0.4) * obs.radius**2)[:, None]
    blocks, residuals, weights = [], [], []
    difference = np.zeros((len(obs), 3))
    for c in range(3):
        rows = np.flatnonzero(obs.usable[:, c])
        got = arrived(problem, base, c)
        own = base[obs.part, c]
        lambert = (1.0 - metal) * own * BELOW_GLOSS
        facing = DIELECTRIC * (1.0 - metal) + own * metal
        by_source = (
            lambert[:, None] * got.diffuse + facing[:, None] * got.facing + got.rest
        ) * strengths[:, c]
        radiance = np.maximum(by_source.sum(axis=1), 1e-9)
        log_x = np.log(radiance) + log_camera[:, c]
        x = np.exp(log_x)
        value, slope = curve.values(x), curve.slope(x) * x
        difference[:, c] = obs.value[:, c] - value
        sd = np.sqrt(_VALUE_SD**2 + (_MODEL_SD * np.maximum(slope, 0.02)) ** 2)
        scale = (slope / sd)[rows]
        J = np.zeros((len(rows), state.size))
        base_at = state.at["base"].start + 3 * np.arange(len(state.seen)) + c
        J[:, base_at] = _base_slopes(problem, state, base, strengths, got, lambert, c)[rows]
        straight = lambert * (got.diffuse @ strengths[:, c])
        straight += own * metal * (got.facing @ strengths[:, c])
        np.add.at(J, (np.arange(len(rows)), base_at[state.row_of[obs.part[rows]]]), straight[rows])
        light_at = state.at["light"].start + 3 * np.arange(len(strengths)) + c
        J[:, light_at] = by_source[rows]
        J *= (scale / radiance[rows])[:, None]
        photograph = obs.photograph[rows]
        J[np.arange(len(rows)), state.at["exposure"].start + photograph] = scale
        J[:, state.at["balance"].start + c] = scale
        J[np.arange(len(rows)), state.at["drift"].start + 3 * photograph + c] = scale
        J[:, state.at["curve"].start] = (curve.by_strength(x) / sd)[rows]
        r2 = obs.radius[rows] ** 2
        J[:, state.at["vignetting"].start] = -2.0 * scale * r2 / (1.0 + max(k, -0.4) * r2)
        blocks.append(J)
        residuals.append(((value - obs.value[:, c]) / sd)[rows])
        weights.append(_ALONE * obs.weight[rows])
    return _Linearised(
        np.concatenate(blocks), np.concatenate(residuals), np.concatenate(weights), difference
    )


def _base_slopes(
    problem: Problem,
    state: State,
    base: Array,
    strengths: Array,
    got: Arrived,
    lambert: Array,
    c: int,
) -> Array:
    """(M, parts) derivative of radiance by logarithms of base colours, by interreflection alone."""
    transport = problem.transport
    reflected = _reflected(transport, base, problem.metallic)[:, c]
    radiance = got.radiance @ strengths[:, c]
    arriving = transport.between.direct @ strengths[:, c] + transport.between.form @ radiance
    source = np.zeros((len(transport.part), len(state.seen)))
    row = state.row_of[transport.part]
    known = np.flatnonzero(row >= 0)
    metal = problem.metallic[transport.part]
    own = base[transport.part, c] * (metal + (1.0 - metal) * BELOW_GLOSS)
    source[known, row[known]] = (own * arriving)[known]
    moved = source
    for _ in range(_DERIVED_BOUNCES):
        moved = source + reflected[:, None] * (transport.between.form @ moved)
    return np.asarray(lambert[:, None] * (transport.diffuse.form @ moved))


def _first(problem: Problem, state: State, curve: Curve) -> Array:
    """A start: exposures by the guess, then base colours by what is left."""
    obs = problem.observations
    theta = np.zeros(state.size)
    base = problem.base.copy()
    linear = curve.linear(obs.value)
    theta[state.at["curve"]] = curve.strength
    exposure = np.zeros(problem.photographs)
    for _ in range(4):
        ratio = np.full((len(obs), 3), np.nan)
        for c in range(3):
            got = arrived(problem, base, c)
            own, metal = base[obs.part, c], problem.metallic[obs.part]
            lambert = (1.0 - metal) * own * BELOW_GLOSS
            facing = DIELECTRIC * (1.0 - metal) + own * metal
            value = lambert[:, None] * got.diffuse + facing[:, None] * got.facing + got.rest
            value = np.maximum(value @ problem.strengths[:, c], 1e-9)
            rows = obs.usable[:, c]
            ratio[rows, c] = np.log(np.maximum(linear[rows, c], 1e-4) / value[rows])
        for index in range(problem.photographs):
            here = ratio[obs.photograph == index]
            exposure[index] = np.nanmedian(here) if np.isfinite(here).any() else 0.0
        rest = ratio - exposure[obs.photograph][:, None]
        balance = np.nan_to_num(np.nanmedian(rest, axis=0))
        rest = rest - balance
        for part in state.seen:
            here = rest[obs.part == part]
            change = [
                np.median(own[np.isfinite(own)]) if np.isfinite(own).any() else 0.0
                for own in here.T
            ]
            base[part] = np.clip(base[part] * np.exp(change), 0.01, 0.85)
    theta[state.at["base"]] = np.log(base[state.seen]).ravel()
    theta[state.at["light"]] = np.log(problem.strengths).ravel()
    theta[state.at["exposure"]] = exposure
    theta[state.at["balance"]] = balance
    return theta


def _again(state: State, found: Solution) -> Array:
    """The parameters of an earlier solution."""
    theta = np.zeros(state.size)
    theta[state.at["base"]] = np.log(np.maximum(found.base[state.seen], 1e-3)).ravel()
    theta[state.at["light"]] = np.log(np.maximum(found.strengths, 1e-9)).ravel()
    theta[state.at["exposure"]] = np.log(found.exposure)
    mean = np.log(found.balance).mean(axis=0)
    theta[state.at["balance"]] = mean
    theta[state.at["drift"]] = (np.log(found.balance) - mean).ravel()
    theta[state.at["curve"]] = found.curve.strength
    theta[state.at["vignetting"]] = found.vignetting
    return theta


def _solution(
    problem: Problem,
    state: State,
    theta: Array,
    spread: Array,
    rows: _Linearised,
    cost: float,
    history: tuple[float, ...],
) -> Solution:
    base, strengths = _unpacked(problem, state, theta)
    sd = np.sqrt(np.maximum(np.diag(spread), 0.0))
    base_sd = np.full(problem.base.shape, np.inf)
    base_sd[state.seen] = sd[state.at["base"]].reshape(-1, 3)
    drift = theta[state.at["drift"]].reshape(-1, 3)
    return Solution(
        base=base,
        base_sd=base_sd,
        strengths=strengths,
        strengths_sd=sd[state.at["light"]].reshape(-1, 3),
        exposure=np.exp(theta[state.at["exposure"]]),
        balance=np.exp(theta[state.at["balance"]] + drift),
        curve=Curve(float(theta[state.at["curve"]][0])),
        vignetting=float(theta[state.at["vignetting"]][0]),
        residual=rows.difference,
        cost=cost,
        history=history,
    )
