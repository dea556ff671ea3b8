"""Puts CADs where a scan shows furniture: which one, where, how turned and how large."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from openrooms_usd.scan.cloud import Cloud
from openrooms_usd.scan.evidence import Evidence, gathered
from openrooms_usd.scan.hints import Box, Hint, bounds_of, corners_of
from openrooms_usd.scan.models import UPRIGHT, CadModel
from openrooms_usd.scan.registration import FINE, ROUGH, Fit, Stage, Start, energy, refined
from openrooms_usd.scan.results import FoundObject, FoundRoom
from openrooms_usd.scan.retrieval import ranked
from openrooms_usd.scan.shape import Shape, directions, posed, shaped, unposed, upright_of
from openrooms_usd.scan.starts import box_of, from_box, from_pose, stretched, true_size, varied
from openrooms_usd.scan.surroundings import Surroundings
from openrooms_usd.scan.symmetry import symmetry_of
from openrooms_usd.scan.undersides import supports
from openrooms_usd.scan.visibility import Panoramas, likely_eyes, look_around
from openrooms_usd.scan.wallsides import Walls, walls_of

Array = NDArray[np.float64]

# Objects of fewer points are not aligned.
FEWEST: Final = 60
# Points nearer to the CAD than this lie on it, metres; fits with less of either are refused.
_ON: Final = 0.05
_COVERED: Final = 0.04
_INLIERS: Final = 0.3
_COVERAGE: Final = 0.15
# How far around a hint points are looked for that have no numbers of objects, metres: neighbours
# would come along. The labels (NYU40) of what is no object: wall, floor, ceiling.
_CROPPED: Final = 0.08
_ROOM: Final = (1, 2, 22)
# Classes (NYU40) that the layout finds.
_SHELL: Final = {1: "wall", 2: "floor", 8: "door", 9: "window", 22: "ceiling"}
# Points for what was seen from where; more say the same.
_LOOK: Final = 300_000
# How starts are compared, how many variations of each are refined roughly, how many of all are
# refined finely, and how much worse than the best these may be; CADs that are tried.
_SURVEY: Final = Stage(0.12, 80, 0, 1.0)
_STRETCH: Final = Stage(0.05, 400, 0, 0.8)
_ROUGHLY: Final = 2
_FINELY: Final = 4
_HOPELESS: Final = (20.0, 1.6)
_CADS: Final = 4
# Fits whose parameters are as near to each other as this are one, metres or radians.
_SAME: Final = 0.02
# What standing on anything but the likeliest support must save.
_DOUBT: Final = 9.0
# CADs have their true size if that costs no more than this.
_TRUE: Final = 9.0


@dataclass(frozen=True)
class Rejected:
    """An object without a CAD.

    Attributes:
        instance: Its number.
        category: Where known.
        reason: A sentence for people.
    """

    instance: int
    category: str
    reason: str


@dataclass(frozen=True, eq=False)
class Alignment:
    """What was found, and what was not."""

    objects: tuple[FoundObject, ...]
    rejected: tuple[Rejected, ...]


class _RefusedError(Exception):
    """Why an object gets no CAD."""


def align(
    cloud: Cloud,
    hints: Sequence[Hint] | None,
    models: Sequence[CadModel],
    rooms: Sequence[FoundRoom] = (),
    categories: Mapping[int, Sequence[str]] | None = None,
) -> Alignment:
    """Align CADs to the objects of a scan.

    Args:
        cloud: Level: floor at z = 0, Z up, metres.
        hints: The objects; None: every labelled instance.
        models: CADs to choose from.
        rooms: Rooms in the frame of the cloud, whose walls hold hidden sides.
        categories: The CADs' categories that a label of the cloud may mean, best first.
    """
    scene = _Scene.of(cloud, models, rooms, categories or {})
    wanted = scene.instances() if hints is None else list(hints)
    found, rejected = [], []
    for hint in wanted:
        try:
            found.append(scene.aligned(hint))
        except _RefusedError as refusal:
            rejected.append(Rejected(hint.instance, hint.category or "", str(refusal)))
    return Alignment(tuple(found), tuple(rejected))


@dataclass(frozen=True, eq=False)
class _Trial:
    shape: Shape
    start: Start
    around: Surroundings
    fit: Fit


@dataclass(frozen=True, eq=False)
class _Scene:
    cloud: Cloud
    models: Sequence[CadModel]
    walls: Walls
    panoramas: Panoramas
    categories: Mapping[int, Sequence[str]]

    @classmethod
    def of(
        cls,
        cloud: Cloud,
        models: Sequence[CadModel],
        rooms: Sequence[FoundRoom],
        categories: Mapping[int, Sequence[str]],
    ) -> "_Scene":
        points = cloud.points[:: max(len(cloud) // _LOOK, 1)]
        eyes = cloud.eyes if cloud.eyes is not None and len(cloud.eyes) else likely_eyes(points)
        return cls(cloud, models, walls_of(rooms), look_around(points, eyes), categories)

    def instances(self) -> list[Hint]:
        if self.cloud.instance is None:
            return []
        numbers = np.unique(self.cloud.instance)
        return [Hint(int(number)) for number in numbers[numbers > 0]]

    def aligned(self, hint: Hint) -> FoundObject:
        rows = self._rows(hint)
        bounds = bounds_of(hint, self.models)
        evidence = gathered(self.cloud.points[rows], bounds, self.walls)
        if len(evidence.points) < FEWEST:
            raise _RefusedError(
                f"only {len(evidence.points)} points (at 1.2 cm) belong to it; {FEWEST} are needed"
            )
        corners = corners_of(hint, self.models)
        bottom = None if corners is None else float(corners[:, 2].min())
        possible = supports(self.cloud, rows, evidence, bottom)
        box = hint.box or box_of(evidence, possible[0])
        chosen = self._candidates(hint, rows, evidence, box)
        trials = [
            trial
            for model, upright in chosen
            for rank, support in enumerate(possible)
            for trial in self._tried(
                hint, model, upright, evidence, box, support, _DOUBT * (rank > 0)
            )
        ]
        best = _finished(trials, evidence)
        return _found(hint, best, evidence)

    def _rows(self, hint: Hint) -> NDArray[np.intp]:
        """The points of an object, by its number or else by its place."""
        if self.cloud.instance is not None:
            rows = np.flatnonzero(self.cloud.instance == hint.instance)
            if len(rows):
                return rows
        corners = corners_of(hint, self.models)
        if corners is None:
            raise _RefusedError(
                "the scan has no points of this instance, and no box or pose is given"
            )
        inside = (self.cloud.points > corners.min(axis=0) - _CROPPED).all(axis=1)
        inside &= (self.cloud.points < corners.max(axis=0) + _CROPPED).all(axis=1)
        cropped = np.flatnonzero(inside)
        if self.cloud.label is None:
            return cropped
        label = self.cloud.label[cropped]
        meant = [k for k, names in self.categories.items() if hint.category in names]
        alike = cropped[np.isin(label, meant)]
        return alike if len(alike) >= FEWEST else cropped[~np.isin(label, _ROOM)]

    def _candidates(
        self, hint: Hint, rows: NDArray[np.intp], evidence: Evidence, box: Box
    ) -> list[tuple[CadModel, Array]]:
        """CADs with the ways in which they may stand upright, most similar first."""
        if hint.cad is not None:
            fitting = [model for model in self.models if model.id == hint.cad]
            if not fitting:
                raise _RefusedError(f"there is no CAD {hint.cad!r}")
        else:
            wanted = self._wanted(hint, rows)
            fitting = [model for model in self.models if model.category in wanted]
            if not fitting:
                raise _RefusedError(self._unknown(wanted, rows))
        if hint.pose is not None and hint.cad is not None:
            rotation = Rotation.from_quat(hint.pose.rotation, scalar_first=True).as_matrix()
            return [(fitting[0], upright_of(rotation))]
        standing = [(model, upright) for model in fitting for upright in _uprights(model)]
        if len(standing) > _CADS:
            order = ranked([m for m, _ in standing], [u for _, u in standing], evidence, box)
            standing = [standing[row] for row in order[:_CADS]]
        return standing

    def _wanted(self, hint: Hint, rows: NDArray[np.intp]) -> Sequence[str]:
        if hint.category is not None:
            return (hint.category,)
        if self.cloud.label is None:
            return sorted({model.category for model in self.models})
        return self.categories.get(self._label(rows), ())

    def _label(self, rows: NDArray[np.intp]) -> int:
        """The class of most points of an object; 0 without labels."""
        if self.cloud.label is None:
            return 0
        return int(np.bincount(np.maximum(self.cloud.label[rows], 0)).argmax())

    def _unknown(self, wanted: Sequence[str], rows: NDArray[np.intp]) -> str:
        """Why there is no CAD to choose."""
        if wanted:
            return f"there is no CAD of the category {' or '.join(wanted)}"
        label = self._label(rows)
        if label in _SHELL:
            return f"its points are labelled {_SHELL[label]}, which the layout finds"
        return f"there is no CAD of the category that its points' label means (NYU40: {label})"

    def _tried(
        self,
        hint: Hint,
        model: CadModel,
        upright: Array,
        evidence: Evidence,
        box: Box,
        support: float | None,
        doubt: float,
    ) -> list[_Trial]:
        """The best starts of one CAD, roughly refined."""
        if hint.pose is not None and hint.cad is not None:
            shape = shaped(model, upright, hint.pose.scale)
            starts = from_pose(shape, hint.pose)
        else:
            shape = shaped(model, upright, _reference(model, upright, box))
            starts = from_box(shape, box, given=hint.box is not None)
        radius = 0.5 * float(np.linalg.norm(shape.size[:2]))
        around = Surroundings(
            self.panoramas, support, self.walls.near(starts[0].parameters, radius), doubt
        )
        return [trial for start in starts for trial in _roughly(shape, evidence, around, start)]


def _roughly(shape: Shape, evidence: Evidence, around: Surroundings, start: Start) -> list[_Trial]:
    """The best of what varies one start, roughly refined."""
    surveyed: list[tuple[float, int, Array]] = []
    for parameters in varied(start):
        if around.support is not None:
            parameters[2] = around.support
        cost = energy(shape, evidence, around, start, parameters, _SURVEY)
        surveyed.append((cost, len(surveyed), parameters))
    return [
        _Trial(shape, start, around, refined(shape, evidence, around, start, parameters, ROUGH))
        for _, _, parameters in sorted(surveyed)[:_ROUGHLY]
    ]


def _finished(trials: Sequence[_Trial], evidence: Evidence) -> _Trial:
    """The best trial, finely refined, and at its true size if that fits about as well."""
    order = _different(trials, sorted(range(len(trials)), key=lambda row: trials[row].fit.energy))
    limit = _HOPELESS[0] + _HOPELESS[1] * trials[order[0]].fit.energy
    hopeful = [row for row in order[:_FINELY] if trials[row].fit.energy < limit]
    fine = [_settled(trials[row], evidence) for row in hopeful]
    return min(fine, key=lambda trial: trial.fit.energy)


def _different(trials: Sequence[_Trial], order: Sequence[int]) -> list[int]:
    """Those rows that lead elsewhere than an earlier one of the same start."""
    kept: list[int] = []
    for row in order:
        trial = trials[row]
        same = [
            other
            for other in kept
            if trials[other].start is trial.start
            and np.abs(trials[other].fit.parameters - trial.fit.parameters).max() < _SAME
        ]
        if not same:
            kept.append(row)
    return kept


def _settled(trial: _Trial, evidence: Evidence) -> _Trial:
    t = trial
    begins = [t.fit.parameters, *stretched(t.shape, t.fit.parameters)]
    costs = [energy(t.shape, evidence, t.around, t.start, begin, _STRETCH) for begin in begins]
    begin = begins[int(np.argmin(costs))]
    fit = refined(t.shape, evidence, t.around, t.start, begin, FINE)
    true = true_size(t.start)
    if true is not None:
        at = t.start.at(true)
        begin = np.concatenate([fit.parameters[:4], true])
        same = refined(t.shape, evidence, t.around, at, begin, FINE)
        cost = energy(t.shape, evidence, t.around, t.start, same.parameters, FINE[-1])
        if cost < fit.energy + _TRUE:
            fit = Fit(same.parameters, cost - _TRUE)
    return replace(t, fit=fit)


def _found(hint: Hint, best: _Trial, evidence: Evidence) -> FoundObject:
    shape, parameters = best.shape, best.fit.parameters
    places = posed(shape.points, parameters)
    normals = directions(shape.normals, parameters)
    _, nearest = shape.tree.query(unposed(evidence.points, parameters))
    offset = evidence.points - places[nearest]
    across = np.abs(np.einsum("ij,ij->i", offset, normals[nearest]))
    far = np.sqrt(np.einsum("ij,ij->i", offset, offset))
    distance: Array = np.maximum(across, far - shape.spacing)
    on = distance < _ON
    assert best.around.panoramas is not None
    visible = best.around.panoramas.visible(places, normals, shape.two_sided)
    reached: Array = np.asarray(evidence.tree.query(places)[0])
    limit = max(_COVERED, evidence.spacing)
    coverage = float((reached[visible] < limit).mean()) if visible.any() else 0.0
    if on.mean() < _INLIERS or coverage < _COVERAGE:
        raise _RefusedError(
            f"the CAD {shape.model.id} does not fit: {100 * on.mean():.0f} % of the points lie on "
            f"it, and {100 * coverage:.0f} % of what must have been seen of it has points"
        )
    return FoundObject(
        instance=hint.instance,
        category=hint.category or shape.model.category,
        cad=shape.model.id,
        pose=shape.pose(parameters),
        residual=float(np.sqrt(np.mean(distance[on] ** 2))),
        coverage=coverage,
        symmetry=shape.model.symmetry or symmetry_of(shape.model, shape.upright),
    )


def _uprights(model: CadModel) -> list[Array]:
    return [UPRIGHT[model.up]] if model.up else [UPRIGHT["Y"], UPRIGHT["Z"]]


def _reference(model: CadModel, upright: Array, box: Box) -> Array:
    """(3,) scale along a CAD's axes at which it fills a box, whichever side is its front."""
    _, size, _ = box.upright()
    own = np.abs(upright) @ np.ptp(model.extent, axis=0)
    level = float(np.sqrt(np.prod(size[:2]) / max(float(np.prod(own[:2])), 1e-12)))
    scale = np.array([level, level, size[2] / max(float(own[2]), 1e-6)])
    return np.asarray(np.abs(upright).T @ scale)
