"""Aligns CADs to all objects of a scan: retrieval, pose search, and a test of the result."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.spatial import KDTree

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.registry import record
from openrooms_usd.geometry.rotations import about_z
from openrooms_usd.progress import Progress, silent
from openrooms_usd.scan.models.cad import CadModel, Symmetry, scattered
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.visibility import Panoramas, likely_sensor_origins, look_around
from openrooms_usd.scan.registration.evidence import Evidence, gathered
from openrooms_usd.scan.registration.fitting import Fit
from openrooms_usd.scan.registration.hints import Box, Hint, bounds_of, corners_of
from openrooms_usd.scan.registration.hypotheses import (
    Survey,
    along_wall,
    best_sizes,
    box_of,
    from_box,
    from_pose,
    rough_candidates,
    surveyed,
)
from openrooms_usd.scan.registration.scalelimits import Candidate, Sizes, sized
from openrooms_usd.scan.registration.selection import MIN_OBJECT_POINTS, CadSelection, RefusedError
from openrooms_usd.scan.registration.supportheights import supports
from openrooms_usd.scan.registration.surroundings import (
    NO_WALLS,
    ObjectSurroundings,
    Walls,
    walls_of,
)
from openrooms_usd.scan.registration.template import directions, posed, template_of, unposed
from openrooms_usd.scan.results import FoundObject, FoundRoom
from openrooms_usd.threads import mapped

# Inlier distances, from points to the CAD and from the CAD's visible surface to points, metres; and
# the least share of inliers each way.
_ON_CAD_M: Final = 0.05
_COVERED_M: Final = 0.04
_MIN_INLIER_SHARE: Final = 0.3
_MIN_COVERAGE_SHARE: Final = 0.15
# Points of the range panoramas; more change nothing.
_MAX_VISIBILITY_POINTS: Final = 300_000
# Least points of a thing for which a given box may stand.
_MIN_BOX_POINTS: Final = 10
# Energy of the prior against any support but the likeliest.
_OTHER_SUPPORT_ENERGY: Final = 9.0
# Classes (NYU40) of what stands with its back to a wall.
_AT_WALLS: Final = ("bookshelf", "cabinet", "dresser", "refridgerator", "shelves")
# Samples of the surface that rotated samples are compared with.
_DENSE_POINTS: Final = 16000
# A rotated surface is the same if this share of it is within this share of its size: about a
# centimetre of a chair, which scanners do not resolve.
_MIN_SAME_SHARE: Final = 0.985
_SAME_SIZE_SHARE: Final = 0.012
# Rotations such that only solids of revolution are symmetric under all, no polygons of up to eight
# corners.
_ODD_TURNS_RAD: Final = tuple(np.deg2rad([17.0, 31.0, 53.0, 72.0, 101.0, 127.0, 149.0]))


@dataclass(frozen=True)
class Rejected:
    """An object without a CAD.

    Attributes:
        instance: Its number.
        category: Empty where it is not known.
        reason: A sentence for people.
    """

    instance: int
    category: str
    reason: str


@dataclass(frozen=True, eq=False)
class Alignment:
    """Aligned objects, and those without a CAD."""

    objects: tuple[FoundObject, ...]
    rejected: tuple[Rejected, ...]


def align(
    cloud: Cloud,
    hints: Sequence[Hint] | None,
    models: Sequence[CadModel],
    rooms: Sequence[FoundRoom] = (),
    categories: Mapping[int, Sequence[str]] | None = None,
    workers: int = 1,
    progress: Progress = silent,
) -> Alignment:
    """Align CADs to the objects of a scan.

    Args:
        cloud: Level: floor at z = 0, Z up, metres.
        hints: The objects; None: every labelled instance.
        models: CADs to choose from.
        rooms: Rooms in the frame of the cloud; hidden sides are drawn to their walls.
        categories: The CADs' categories that a label of the cloud may mean, best first.
        workers: Threads; the result never depends on it.
        progress: Called with every object, and the finished fraction.
    """
    scene = _Scene.of(cloud, models, rooms, categories or {})
    wanted = scene.instances() if hints is None else list(hints)
    fitted, found, rejected = [], [], []
    for hint, fit in scene.each_fitted(wanted, workers, progress):
        if isinstance(fit, RefusedError):
            rejected.append(Rejected(hint.instance, hint.word or hint.category or "", str(fit)))
        else:
            fitted.append((hint, *fit))
    for (hint, evidence, _), best in zip(fitted, sized([each[2] for each in fitted]), strict=True):
        try:
            found.append(_found(hint, best, evidence))
        except RefusedError as refusal:
            stand_in = scene.boxed(hint, evidence, best.around)
            if stand_in is not None:
                found.append(_found(hint, stand_in, evidence))
            else:
                rejected.append(
                    Rejected(hint.instance, hint.word or hint.category or "", str(refusal))
                )
    return Alignment(tuple(found), tuple(rejected))


@dataclass(frozen=True, eq=False)
class _Scene:
    selection: CadSelection
    walls: Walls
    panoramas: Panoramas

    @classmethod
    def of(
        cls,
        cloud: Cloud,
        models: Sequence[CadModel],
        rooms: Sequence[FoundRoom],
        categories: Mapping[int, Sequence[str]],
    ) -> "_Scene":
        points = cloud.points[:: max(len(cloud) // _MAX_VISIBILITY_POINTS, 1)]
        sensor_origins = (
            cloud.sensor_origins
            if cloud.sensor_origins is not None and len(cloud.sensor_origins)
            else likely_sensor_origins(points)
        )
        selection = CadSelection(cloud, models, categories)
        return cls(selection, walls_of(rooms), look_around(points, sensor_origins))

    def instances(self) -> list[Hint]:
        cloud = self.selection.cloud
        if cloud.instance is None:
            return []
        numbers = np.unique(cloud.instance)
        return [Hint(int(number)) for number in numbers[numbers > 0]]

    def each_fitted(
        self, hints: Sequence[Hint], workers: int, progress: Progress
    ) -> Iterator[tuple[Hint, tuple[Evidence, Sizes] | RefusedError]]:
        """All objects in their order, by so many threads, each fitted or refused."""

        def fitted(hint: Hint) -> tuple[Evidence, Sizes] | RefusedError:
            try:
                return self.fitted(hint)
            except RefusedError as refusal:
                return refusal

        fits = mapped(fitted, hints, workers)
        for done, (hint, fit) in enumerate(zip(hints, fits, strict=True), 1):
            progress(f"object {done} of {len(hints)}", done / len(hints))
            yield hint, fit

    def fitted(self, hint: Hint) -> tuple[Evidence, Sizes]:
        """The points of an object, and its best fits of free and of true size."""
        cloud, models = self.selection.cloud, self.selection.models
        rows = self.selection.rows(hint)
        bounds = bounds_of(hint, models)
        evidence = gathered(cloud.points[rows], bounds, self.walls)
        few = len(evidence.points) < MIN_OBJECT_POINTS
        too_few = RefusedError(f"fewer than {MIN_OBJECT_POINTS} points, 1.2 cm apart, belong to it")
        # A box that is given needs no fit.
        if few and (hint.box is None or len(evidence.points) < _MIN_BOX_POINTS):
            raise too_few
        corners = corners_of(hint, models)
        bottom = None if corners is None else float(corners[:, 2].min())
        possible = supports(cloud, self.selection.plan, rows, evidence, bottom)
        box = hint.box or box_of(evidence, possible[0])
        chosen = []
        if possible[0] != 0.0 and hint.box is None:
            down = box_of(evidence, 0.0)
            if chosen := self.selection.of_top(hint, rows, evidence, down):
                box, possible = down, (0.0,)
        chosen = chosen or self.selection.candidates(hint, rows, evidence, box)
        if few and chosen:
            raise too_few
        if not chosen:
            around = ObjectSurroundings(self.panoramas, possible[0], NO_WALLS)
            if (stand_in := self.boxed(hint, evidence, around)) is None:
                raise RefusedError("there is no CAD of its size")
            return evidence, Sizes(stand_in)
        surveys = [
            survey
            for model, upright in chosen
            for rank, support in enumerate(possible)
            for survey in self._surveys(
                hint, model, upright, evidence, box, support, _OTHER_SUPPORT_ENERGY * (rank > 0)
            )
        ]
        best = best_sizes(rough_candidates(surveys, evidence), evidence)
        if hint.box is None and hint.pose is None and _stands_at_walls(best.any.template.model):
            best = replace(best, any=along_wall(best.any, evidence))
        return evidence, best

    def boxed(self, hint: Hint, evidence: Evidence, around: ObjectSurroundings) -> Candidate | None:
        """A box that fills the object; None where none may stand for it."""
        model = next((one for one in self.selection.models if _is_stand_in(one)), None)
        if model is None or hint.choices is None:
            return None
        box = hint.box or box_of(evidence, around.support)
        template = template_of(model, np.eye(3), np.ones(3))
        hypothesis = from_box(template, box, given=hint.box is not None, limited=True)[0]
        return Candidate(template, hypothesis, around, Fit(hypothesis.parameters, 0.0))

    def _surveys(
        self,
        hint: Hint,
        model: CadModel,
        upright: Array,
        evidence: Evidence,
        box: Box,
        support: float | None,
        doubt: float,
    ) -> list[Survey]:
        """Scored pose hypotheses of one CAD."""
        if hint.pose is not None and hint.cad is not None:
            template = template_of(model, upright, hint.pose.scale)
            hypotheses = from_pose(template, hint.pose)
        else:
            template = template_of(model, upright, _reference(model, upright, box))
            limited = hint.cad is None and hint.choices is not None
            hypotheses = from_box(template, box, given=hint.box is not None, limited=limited)
        radius = 0.5 * float(np.linalg.norm(template.size[:2]))
        around = ObjectSurroundings(
            self.panoramas, support, self.walls.near(hypotheses[0].parameters, radius), doubt
        )
        return [surveyed(template, evidence, around, hypothesis) for hypothesis in hypotheses]


def _found(hint: Hint, best: Candidate, evidence: Evidence) -> FoundObject:
    template, parameters = best.template, best.fit.parameters
    places = posed(template.points, parameters)
    normals = directions(template.normals, parameters)
    _, nearest = template.tree.query(unposed(evidence.points, parameters))
    offset = evidence.points - places[nearest]
    across = np.abs(np.einsum("ij,ij->i", offset, normals[nearest]))
    far = np.sqrt(np.einsum("ij,ij->i", offset, offset))
    distance: Array = np.maximum(across, far - template.spacing)
    on = distance < _ON_CAD_M
    assert best.around.panoramas is not None
    visible = best.around.panoramas.visible(places, normals, template.two_sided)
    reached: Array = np.asarray(evidence.tree.query(places)[0])
    limit = max(_COVERED_M, evidence.spacing)
    coverage = float((reached[visible] < limit).mean()) if visible.any() else 0.0
    stand_in = _is_stand_in(template.model)
    if not stand_in and (on.mean() < _MIN_INLIER_SHARE or coverage < _MIN_COVERAGE_SHARE):
        raise RefusedError(
            f"the CAD {template.model.id} does not fit: {100 * on.mean():.0f} % of the points lie "
            f"on it, and {100 * coverage:.0f} % of its visible surface has points"
        )
    return FoundObject(
        instance=hint.instance,
        category=template.model.category if stand_in else hint.category or template.model.category,
        cad=template.model.id,
        pose=template.pose(parameters),
        residual=float(np.sqrt(np.mean(distance[on] ** 2))) if on.any() else _ON_CAD_M,
        coverage=coverage,
        symmetry=template.model.symmetry or symmetry_of(template.model, template.upright),
        word=hint.word,
    )


def _stands_at_walls(model: CadModel) -> bool:
    """Whether the library builds it, and people stand it with its back to a wall."""
    known = record(model.category) if model.sizes is not None else None
    return known is not None and known.classes.nyu40 in _AT_WALLS


def _is_stand_in(model: CadModel) -> bool:
    """Whether it is the box that stands for what no CAD can stand for."""
    return model.category == "box" and model.sizes is not None


def _reference(model: CadModel, upright: Array, box: Box) -> Array:
    """(3,) scale along a CAD's axes at which it fills a box, whichever side is its front."""
    _, size, _ = box.upright()
    own = np.abs(upright) @ np.ptp(model.extent, axis=0)
    level = float(np.sqrt(np.prod(size[:2]) / max(float(np.prod(own[:2])), 1e-12)))
    scale = np.array([level, level, size[2] / max(float(own[2]), 1e-6)])
    return np.asarray(np.abs(upright).T @ scale)


def symmetry_of(model: CadModel, upright: Array) -> Symmetry:
    """The symmetry of a CAD about the vertical through the middle of its box.

    Args:
        model: The CAD; what it states is not asked.
        upright: (3, 3) signed permutation to Z up.
    """
    low, high = np.sort(model.extent @ upright.T, axis=0)
    middle = 0.5 * (low + high)
    points = model.surface.points @ upright.T - middle
    whole, _, area = scattered(model.vertices[model.faces], _DENSE_POINTS)
    tree: KDTree[None] = KDTree(whole @ upright.T - middle)
    limit = max(
        _SAME_SIZE_SHARE * float(np.linalg.norm(high - low)),
        1.6 * float(np.sqrt(area / _DENSE_POINTS)),
    )

    def same(angle: float) -> bool:
        distance, _ = tree.query(points @ about_z(-angle), distance_upper_bound=limit)
        return bool(np.isfinite(distance).mean() >= _MIN_SAME_SHARE)

    if all(same(angle) for angle in _ODD_TURNS_RAD):
        return "inf"
    if not same(np.pi):
        return "none"
    return "4" if same(0.5 * np.pi) else "2"
