"""From a stage and photographs of it to what its parts are made of, its lights and the cameras."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from openrooms_usd.appearance.charts import charts_of, probes_of
from openrooms_usd.appearance.directions import ELEVATIONS
from openrooms_usd.appearance.gloss import tell_gloss
from openrooms_usd.appearance.observations import Observations, observe
from openrooms_usd.appearance.places import Places
from openrooms_usd.appearance.problem import ColorPrior, Problem
from openrooms_usd.appearance.solving import BELOW_GLOSS, Solution, solve
from openrooms_usd.appearance.textures import Painted, paint
from openrooms_usd.appearance.transport import (
    Gather,
    Transport,
    lamps_of,
    sample_transport,
    sky_seen,
)
from openrooms_usd.arrays import Array
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.errors import InputError
from openrooms_usd.progress import Progress, nested, silent
from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.pictures import Picture, Value
from openrooms_usd.rendering.scene.sources import sources_of

# The first guess, before anything was seen.
_GREY: Final = 0.4
_LAMP_NITS: Final = 1500.0
_SKY_NITS: Final = 500.0
_ROUNDS: Final = 3
_FIRST_STEPS: Final = 14
_NEXT_STEPS: Final = 6
# What surfaces are by habit: the scale that photographs leave open rests on these. Ceilings are
# painted white (reflectance 0.75 to 0.85); frames of windows and doors mostly are.
_NEUTRAL: Final = (0.0, 0.0, 0.0)
_CEILING: Final = ColorPrior(0.8, 0.05, _NEUTRAL, 0.03)
_FRAME: Final = ColorPrior(0.7, 0.3, _NEUTRAL, 0.1)
_CEILING_NYU40: Final = 22
_FRAME_NYU40: Final = frozenset({8, 9})
# Spread of the logarithm of colours that are known from alike parts alone.
_UNSEEN_SD: Final = 0.5
# Of 1: darker values of the surroundings say nothing.
_DARK: Final = 0.02


@dataclass(frozen=True, eq=False)
class Appearance:
    """What was found.

    Attributes:
        problem: What was to be explained, with the gloss that was found.
        solution: What explains it.
        parts: Prim path by part number, of those that are known: seen, or like one that is.
        lamps: Prim paths of lamps, in the order of the sources.
        emitters: By lamp: the prims of its emitting meshes.
        frames: The photographs that show something of the stage.
        painted: Pictures of base colours.
    """

    problem: Problem
    solution: Solution
    parts: dict[int, str]
    lamps: tuple[str, ...]
    emitters: tuple[tuple[str, ...], ...]
    frames: tuple[CapturedFrame, ...]
    painted: tuple[Painted, ...] = ()

    @property
    def sky(self) -> Array:
        """(elevations, 3) nits of the surroundings at `ELEVATIONS`; 0 where they light nothing."""
        seen = self.problem.transport.diffuse.direct[:, len(self.lamps) :].any()
        return float(seen) * self.solution.strengths[len(self.lamps) :]

    def as_dict(self) -> dict[str, Any]:
        """As plain data: parts, lights and photographs, each with how sure it is."""
        found, problem = self.solution, self.problem
        seen = np.bincount(problem.observations.part, minlength=len(found.base))
        worst = np.abs(found.residual).mean(axis=1)
        by_part = np.bincount(problem.observations.part, worst, len(found.base))
        by_photograph = np.bincount(problem.observations.photograph, worst, len(self.frames))
        taken = np.bincount(problem.observations.photograph, minlength=len(self.frames))
        return {
            "parts": [
                {
                    "path": path,
                    "base_color": _rounded(found.base[number]),
                    "base_color_sd": _rounded(found.base[number] * found.base_sd[number]),
                    "roughness": round(float(problem.roughness[number]), 3),
                    "metallic": float(problem.metallic[number]),
                    "places": int(seen[number]),
                    "residual": round(float(by_part[number] / max(seen[number], 1)), 4),
                }
                for number, path in self.parts.items()
            ],
            "lamps": [
                {
                    "path": path,
                    "radiance": _rounded(found.strengths[index]),
                    "radiance_sd": _rounded(found.strengths[index] * found.strengths_sd[index]),
                }
                for index, path in enumerate(self.lamps)
            ],
            "surroundings": [
                {"elevation": degrees, "radiance": _rounded(radiance)}
                for degrees, radiance in zip(ELEVATIONS, self.sky, strict=True)
            ],
            "photographs": [
                {
                    "id": frame.id,
                    "exposure": float(f"{found.exposure[index]:.5g}"),
                    "white_balance": _rounded(found.balance[index]),
                    "residual": round(float(by_photograph[index] / max(taken[index], 1)), 4),
                }
                for index, frame in enumerate(self.frames)
            ],
            "curve": round(found.curve.strength, 4),
            "vignetting": round(found.vignetting, 4),
        }


def recover(
    context: RenderContext,
    frames: Sequence[CapturedFrame],
    pictures: Sequence[NDArray[np.uint8]],
    seed: int = 0,
    progress: Progress = silent,
) -> Appearance:
    """Find what a stage's parts are made of and what its lights send.

    Args:
        context: The stage, open for a renderer. What its materials say of roughness and metals is
            where the search begins; its base colours and strengths do not count.
        frames: Cameras of the photographs, without distortion, in the stage's world.
        pictures: (H, W, 3) of each.
        seed: Of directions and places.
        progress: Called with the step and the finished fraction.

    Raises:
        InputError: The photographs see nothing of the stage.
    """
    scene, tracer = context.scene, context.tracer
    sources = sources_of(scene)
    progress("looking at photographs", 0.0)
    observations = observe(scene, tracer, frames, pictures, seed)
    telling = np.unique(observations.photograph[observations.usable.any(axis=1)])
    if not len(telling):
        raise InputError(
            "the photographs show nothing of this stage that is neither dark nor saturated",
            place=str(context.path),
            remedy="check their poses, and that they are of this room",
        )
    if len(telling) < len(frames):
        frames, pictures = ([some[i] for i in telling] for some in (frames, pictures))
        observations = observe(scene, tracer, frames, pictures, seed)
    progress("following light", 0.1)
    charts = charts_of(scene, observations.triangles, np.random.default_rng(seed))
    places = _joined(observations.places, probes_of(charts))
    transport = sample_transport(scene, tracer, sources, places, seed)
    transport, lit = _apart(transport, len(observations))
    if not transport.diffuse.direct.any():
        raise InputError(
            "no lamp and no opening of this stage lights what the photographs show",
            place=str(context.path),
            remedy="give the stage its lamps, as meshes that emit, and its windows",
        )
    lamps = lamps_of(sources)
    roughness, metallic = _gloss_of(scene)
    sky = len(roughness)
    observations, transport = _with_sky(scene, frames, observations, transport, sky)
    roughness, metallic = np.append(roughness, 0.5), np.append(metallic, 0.0)
    base = np.full((sky + 1, 3), _GREY)
    base[sky] = 1.0 / BELOW_GLOSS
    strengths = np.full((len(lamps) + len(ELEVATIONS), 3), _SKY_NITS)
    strengths[: len(lamps)] = _LAMP_NITS
    first = Problem(
        observations,
        transport,
        len(frames),
        len(lamps),
        base,
        roughness,
        metallic,
        _priors(scene),
        strengths,
        sky,
    )
    problem, found = first, None
    for round_ in range(_ROUNDS):
        share = nested(
            progress, "solving", 0.4 + 0.6 * round_ / _ROUNDS, 0.4 + 0.6 * (round_ + 1) / _ROUNDS
        )
        if found is not None:
            problem = tell_gloss(problem, found, first)
        found = solve(
            problem,
            iterations=_NEXT_STEPS if found else _FIRST_STEPS,
            start=found,
            progress=partial(share, ""),
        )
    assert found is not None
    problem, found = _with_unseen(scene, problem, found)
    legend = scene.legend.part
    known = np.flatnonzero(np.isfinite(found.base_sd).all(axis=1))
    parts = {int(n): legend[int(n)] for n in known if int(n) in legend}
    emitters = tuple(
        tuple(
            dict.fromkeys(
                legend[scene.pieces[int(piece)].part]
                for patch in lamp.patches
                for piece in np.unique(scene.patches[patch].triangles.pieces)
            )
        )
        for lamp in lamps
    )
    return Appearance(
        problem,
        found,
        parts,
        tuple(lamp.path for lamp in lamps),
        emitters,
        tuple(frames),
        tuple(paint(scene, tracer, frames, pictures, charts, lit, problem, found)),
    )


def _with_unseen(scene: Scene, problem: Problem, found: Solution) -> tuple[Problem, Solution]:
    """Parts that no photograph shows as those that the stage makes of the same material."""
    # A mesh without a material gives its surface itself, and so tells nothing of others.
    bare = {id(one) for path, one in scene.owners if path in scene.legend.part.values()}
    alike: dict[int, set[int]] = {}
    for patch in scene.patches:
        if patch.radiance is None and id(patch.surface) not in bare:
            numbers = {scene.pieces[int(p)].part for p in np.unique(patch.triangles.pieces)}
            alike.setdefault(id(patch.surface), set()).update(numbers)
    base, spread = found.base.copy(), found.base_sd.copy()
    roughness, metallic = problem.roughness.copy(), problem.metallic.copy()
    is_seen = np.asarray(np.isfinite(spread).all(axis=1))
    for group in alike.values():
        members = np.array(sorted(group))
        shown, rest = members[is_seen[members]], members[~is_seen[members]]
        if len(shown) and len(rest):
            base[rest] = np.median(base[shown], axis=0)
            spread[rest] = _UNSEEN_SD
            roughness[rest] = np.median(roughness[shown])
            metallic[rest] = float(np.median(metallic[shown]) > 0.5)
    same = replace(problem, roughness=roughness, metallic=metallic)
    return same, replace(found, base=base, base_sd=spread)


def _joined(some: Places, more: Places) -> Places:
    """Places one after the other; those of one point have it several times."""
    points = some.position.shape[1]
    pairs = (
        (getattr(some, name), np.repeat(getattr(more, name), points, axis=1))
        for name in ("position", "normal", "view")
    )
    return Places(*(np.concatenate(pair) for pair in pairs))


def _apart(transport: Transport, count: int) -> tuple[Transport, Gather]:
    """The operator of the first places, and what arrives at the others."""

    def first(gather: Gather) -> Gather:
        return Gather(gather.direct[:count], gather.form[:count])

    rest = Gather(transport.diffuse.direct[count:], transport.diffuse.form[count:])
    glossy = tuple((first(a), first(b)) for a, b in transport.glossy)
    return replace(transport, diffuse=first(transport.diffuse), glossy=glossy), rest


def _with_sky(
    scene: Scene,
    frames: Sequence[CapturedFrame],
    seen: Observations,
    transport: Transport,
    number: int,
) -> tuple[Observations, Transport]:
    """Pixels that see the surroundings as observations of their own, of a part of that number."""
    sky = seen.sky
    eyes = np.array([frame.world_from_camera[:3, 3] for frame in frames])[sky.photograph]
    columns = transport.diffuse.direct.shape[1]
    direct = np.zeros((len(eyes), columns))
    direct[:, columns - len(ELEVATIONS) :] = sky_seen(scene, eyes, sky.direction)
    dark = np.zeros_like(direct)
    nothing = sparse.csr_array((len(eyes), transport.diffuse.form.shape[1]))

    def below(upper: Gather, lower: Array) -> Gather:
        form = sparse.vstack([upper.form, nothing], format="csr")
        return Gather(np.concatenate([upper.direct, lower]), sparse.csr_array(form))

    more = replace(
        transport,
        diffuse=below(transport.diffuse, direct),
        glossy=tuple((below(a, dark), below(b, dark)) for a, b in transport.glossy),
    )
    # Saturated values count, too: the prediction saturates where it is above.
    usable = sky.value > _DARK
    every = replace(
        seen,
        photograph=np.concatenate([seen.photograph, sky.photograph]),
        part=np.concatenate([seen.part, np.full(len(eyes), number)]),
        value=np.concatenate([seen.value, sky.value]),
        usable=np.concatenate([seen.usable, usable]),
        radius=np.concatenate([seen.radius, sky.radius]),
        weight=np.concatenate([seen.weight, np.ones(len(eyes))]),
    )
    return every, more


def _gloss_of(scene: Scene) -> tuple[Array, Array]:
    """(P,) roughness and metallic of parts, as their materials have them in the mean."""
    count = max(scene.legend.part, default=0) + 1
    roughness, metallic = np.full(count, 0.5), np.zeros(count)
    for patch in scene.patches:
        for piece in np.unique(patch.triangles.pieces):
            part = scene.pieces[int(piece)].part
            roughness[part] = _mean(patch.surface.roughness)
            metallic[part] = float(_mean(patch.surface.metallic) > 0.5)
    return roughness, metallic


def _mean(value: Value) -> float:
    return float(np.mean(value.pixels if isinstance(value, Picture) else value, dtype=float))


def _priors(scene: Scene) -> dict[int, ColorPrior]:
    found = {}
    for piece in scene.pieces:
        path = scene.legend.part.get(piece.part, "")
        if piece.semantic_nyu40 == _CEILING_NYU40:
            found[piece.part] = _CEILING
        elif piece.semantic_nyu40 in _FRAME_NYU40 and not path.endswith(_LEAVES):
            found[piece.part] = _FRAME
    return found


# Parts of doors that have any colour.
_LEAVES: Final = ("Panel", "Handle", "Glass")


def _rounded(values: Array) -> list[float]:
    return [float(f"{value:.5g}") for value in values]
