"""Do photographs and a room belong together, and which motion brings them together?

Phones move their world while they scan, files get mixed up, and poses are a little off. Depth maps
are laid on the room's geometry where photographs have them; else lines of geometry are laid on
lines of the photographs. One rigid motion comes first, then a small one of each photograph.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np

from openrooms_usd.appearance import depthfit, linefit
from openrooms_usd.appearance.depthfit import Range, differences, range_of, share_on
from openrooms_usd.appearance.lines import Drawing, agreement, distances, drawing
from openrooms_usd.appearance.motions import motion_size
from openrooms_usd.appearance.views import Geometry, Photograph, geometry_of
from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.rotations import inverse

Verdict = Literal["fits", "moved", "refused"]
Unit = Literal["m", "px"]

# Motions up to this are the noise of poses: the photographs' own corrections take care of them.
_STILL_M: Final = 0.03
_STILL_DEG: Final = 1.0
# A photograph's own correction is at most this.
_SMALL_M: Final = 0.06
_SMALL_DEG: Final = 3.0
# Depth: least share on geometry, and what a motion has to add to it. Another room reached 0.38.
_LEAST_ON: Final = 0.5
_GAIN_ON: Final = 0.05
# Lines: pixels of tolerance, and how much they have to agree above chance. Other rooms reached
# 0.07, a coarse scan of the right one 0.17, exact models 0.55.
_TOLERANCE_PX: Final = 4.0
_LEAST_AGREEMENT: Final = 0.1
# What a motion has to add, as a share; both in standard errors over the photographs.
_GAIN_SHARE: Final = 0.2
_LEAST_ERRORS: Final = 4.0
# Photographs are read at about this width.
_WIDTH: Final = 480


@dataclass(frozen=True, eq=False)
class FrameRegistration:
    """What became of one photograph.

    Attributes:
        correction: (4, 4) its small motion in the world, after the one of all.
        before: Median distance as the pose is said, in ``unit``; None where nothing is comparable.
        after: The same with all corrections.
        unit: "m" of depth from geometry, or "px" of the geometry's lines from the photograph's.
    """

    correction: Array
    before: float | None
    after: float | None
    unit: Unit


@dataclass(frozen=True, eq=False)
class Registration:
    """How photographs and a room belong together.

    Attributes:
        correction: (4, 4) one rigid motion of all cameras in the world; identity unless "moved".
        frames: The photographs, in their order.
        verdict: "fits", "moved", or "refused" where no motion brings them together.
        sentence: The verdict for people, with its figures.
    """

    correction: Array
    frames: tuple[FrameRegistration, ...]
    verdict: Verdict
    sentence: str

    def poses(self, photographs: Sequence[Photograph]) -> list[Array]:
        """The corrected world_from_camera (4, 4) of each photograph."""
        return [
            frame.correction @ self.correction @ one.world_from_camera
            for frame, one in zip(self.frames, photographs, strict=True)
        ]


def register(photographs: Sequence[Photograph], geometry: Geometry) -> Registration:
    """Check the photographs' poses against a room's geometry, and correct them.

    A motion of all is found within 0.7 m and 17 degrees about the vertical.

    Args:
        photographs: With poses in the room's world; some or all with depth maps.
        geometry: What cameras see of the room.

    Raises:
        InputError: There is no photograph, or a pose is not finite.
    """
    if not photographs:
        raise InputError("there are no photographs to register")
    for number, one in enumerate(photographs):
        if not (np.isfinite(one.world_from_camera).all() and np.isfinite(one.K).all()):
            raise InputError(f"the camera of photograph {number} is not finite")
    pivot = np.mean([one.world_from_camera[:3, 3] for one in photographs], axis=0)
    evidence = [
        range_of(one) or drawing(*one.reduced(_WIDTH), one.world_from_camera) for one in photographs
    ]
    if ranges := [one for one in evidence if isinstance(one, Range)]:
        verdict, correction, sentence = _by_depth(ranges, geometry, pivot)
    else:
        drawings = [one for one in evidence if isinstance(one, Drawing)]
        verdict, correction, sentence = _by_lines(drawings, geometry, pivot)
    frames = []
    for seen in evidence:
        own = correction if verdict == "refused" else _own(seen, geometry, correction)
        frames.append(_frame(seen, geometry, correction, own))
    return Registration(correction, tuple(frames), verdict, sentence)


def register_stage(stage: Path, photographs: Sequence[Photograph]) -> Registration:
    """`register` against the surfaces of a stage.

    Raises:
        InputError: The stage is unreadable, or as `register` says.
    """
    from openrooms_usd.usd.files.layers import open_stage
    from openrooms_usd.usd.shapes.meshes import read_meshes, world_triangles

    surfaces = read_meshes(open_stage(stage), outside=False, bare=True)
    return register(photographs, geometry_of(*world_triangles(surfaces)))


def _by_depth(
    ranges: Sequence[Range], geometry: Geometry, pivot: Array
) -> tuple[Verdict, Array, str]:
    found = depthfit.search(ranges, geometry, pivot)
    before, after = (share_on(differences(ranges, geometry, m)) for m in (np.eye(4), found))
    shares = f"{before:.0%} of the depth lies on the room as the poses are said"
    if max(before, after) < _LEAST_ON:
        best = f"{shares}, {after:.0%} after the best motion"
        return "refused", np.eye(4), f"The photographs are not of this room: {best}."
    if _is_within(found, pivot, _STILL_M, _STILL_DEG) or after - before < _GAIN_ON:
        return "fits", np.eye(4), f"The photographs fit the room: {shares}."
    return "moved", found, f"{_moved_words(found, pivot)}: {shares}, {after:.0%} after it."


def _by_lines(
    drawings: Sequence[Drawing], geometry: Geometry, pivot: Array
) -> tuple[Verdict, Array, str]:
    found = linefit.search(drawings, geometry, pivot)
    before, after = (_agreements(drawings, geometry, m) for m in (np.eye(4), found))
    if before.mean() >= after.mean():
        found, after = np.eye(4), before
    figures = (
        f"lines agree by {before.mean():.2f} above chance as the poses are said, "
        f"by {after.mean():.2f} after the best motion"
    )
    if not _is_clear(after, _LEAST_AGREEMENT):
        return "refused", np.eye(4), f"The photographs are not of this room: {figures}."
    is_alike = before.mean() >= (1.0 - _GAIN_SHARE) * after.mean()
    is_clear = _is_clear(after - before, _GAIN_SHARE * float(after.mean()))
    if is_clear and not _is_within(found, pivot, _STILL_M, _STILL_DEG):
        return "moved", found, f"{_moved_words(found, pivot)}: {figures}."
    if is_alike or _settled(drawings, geometry) >= (1.0 - _GAIN_SHARE) * after.mean():
        return "fits", np.eye(4), f"The photographs fit the room: {figures}."
    return "refused", np.eye(4), f"It is not clear where the photographs were taken: {figures}."


def _settled(drawings: Sequence[Drawing], geometry: Geometry) -> float:
    """By how much lines agree after small motions of each photograph alone."""
    own = [_own(one, geometry, np.eye(4)) for one in drawings]
    pairs = zip(drawings, own, strict=True)
    return float(np.mean([_agreements([one], geometry, m)[0] for one, m in pairs]))


def _own(one: Range | Drawing, geometry: Geometry, moved: Array) -> Array:
    """The motion of one photograph's camera; that of all where its own is not small and better."""
    eye = (moved @ one.pose)[:3, 3]
    if isinstance(one, Range):
        own = depthfit.refine([one], geometry, moved, eye, origin=moved)
        before, after = (share_on(differences([one], geometry, m)) for m in (moved, own))
    else:
        own = linefit.refine_one(one, geometry, moved)
        before, after = (_agreements([one], geometry, m)[0] for m in (moved, own))
    is_small = _is_within(own @ inverse(moved), eye, _SMALL_M, _SMALL_DEG)
    return own if is_small and after >= before else moved


def _frame(one: Range | Drawing, geometry: Geometry, moved: Array, own: Array) -> FrameRegistration:
    before, after = (_residual(one, geometry, m) for m in (np.eye(4), own))
    unit: Unit = "m" if isinstance(one, Range) else "px"
    return FrameRegistration(own @ inverse(moved), before, after, unit)


def _residual(one: Range | Drawing, geometry: Geometry, moved: Array) -> float | None:
    if isinstance(one, Range):
        off = differences([one], geometry, moved)[0]
    else:
        off = distances(one, linefit.lines_of([one], geometry, moved)[0], moved @ one.pose)
    near = np.abs(off[np.isfinite(off)])
    return float(np.median(near)) if len(near) else None


def _agreements(drawings: Sequence[Drawing], geometry: Geometry, moved: Array) -> Array:
    """(F,) by which the lines of each photograph agree after a motion."""
    lines = linefit.lines_of(drawings, geometry, moved)
    return agreement(drawings, lines, [moved @ one.pose for one in drawings], _TOLERANCE_PX)


def _is_clear(values: Array, least: float) -> bool:
    """Whether the mean over photographs is large, and large beside its standard error."""
    error = float(values.std(ddof=1)) / np.sqrt(len(values)) if len(values) > 1 else 0.0
    return bool(values.mean() >= max(least, _LEAST_ERRORS * error))


def _is_within(rigid: Array, at: Array, metres: float, degrees: float) -> bool:
    shift, turn = motion_size(rigid, at)
    return shift <= metres and turn <= degrees


def _moved_words(rigid: Array, pivot: Array) -> str:
    shift, turn = motion_size(rigid, pivot)
    return f"The photographs' world is {100 * shift:.0f} cm and {turn:.1f} degrees off the room's"
