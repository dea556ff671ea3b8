"""Selects the points of a hinted object and the CADs that may fit it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.furniture.registry import record
from openrooms_usd.scan.models.cad import UPRIGHT, CadModel
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.planindex import PlanIndex
from openrooms_usd.scan.registration.evidence import Evidence
from openrooms_usd.scan.registration.hints import Box, Hint, corners_of
from openrooms_usd.scan.registration.scalelimits import is_natural, turns_of
from openrooms_usd.scan.registration.template import upright_of

Rows = NDArray[np.intp]

# Objects of fewer points are not aligned.
MIN_OBJECT_POINTS: Final = 60
# Margin of the crop around a hint in clouds without instances, metres: small, or neighbours would
# be cropped, too; and the labels (NYU40) that are cut away: wall, floor, ceiling.
_CROP_MARGIN_M: Final = 0.08
_ROOM_LABELS: Final = (1, 2, 22)
# Classes (NYU40) that belong to the layout.
_LAYOUT_LABELS: Final = {1: "wall", 2: "floor", 8: "door", 9: "window", 22: "ceiling"}
# Of what hangs above nothing only the top may have been seen: cells of the plan, the part of them
# that may have other objects below, and where these begin above the floor, metres.
_PLAN_CELL_M: Final = 0.05
_MAX_COVERED_SHARE: Final = 0.1
_FLOOR_M: Final = 0.05
# CADs that are fitted to one object.
_MAX_CADS: Final = 4
# Bins of the descriptor over distance from the vertical axis and height, relative to the box.
_RADIAL_BINS: Final = 6
_HEIGHT_BINS: Final = 10
# Log ratio of lengths that weighs as much as a wholly different descriptor.
_LENGTH_RATIO_LOG: Final = 0.5


class RefusedError(Exception):
    """Why an object gets no CAD."""


@dataclass(frozen=True, eq=False)
class CadSelection:
    """Points and CADs to select from.

    Attributes:
        cloud: Level: floor at z = 0, Z up, metres.
        models: CADs.
        categories: The CADs' categories that a label of the cloud may mean, best first.
    """

    cloud: Cloud
    models: Sequence[CadModel]
    categories: Mapping[int, Sequence[str]]

    @cached_property
    def plan(self) -> PlanIndex:
        """The plan of the points."""
        return PlanIndex(self.cloud.points)

    @cached_property
    def _by_instance(self) -> tuple[NDArray[np.int32], Rows]:
        """The instances in order, with the row of each."""
        assert self.cloud.instance is not None
        order = np.argsort(self.cloud.instance, kind="stable")
        return self.cloud.instance[order], order

    def rows(self, hint: Hint) -> Rows:
        """Rows of an object's points, by its instance number or else by its pose or box.

        Raises:
            RefusedError: No points have this number, and there is neither a pose nor a box.
        """
        if self.cloud.instance is not None:
            numbers, order = self._by_instance
            begin, end = np.searchsorted(numbers, [hint.instance, hint.instance + 1])
            if end > begin:
                return order[begin:end]
        corners = corners_of(hint, self.models)
        if corners is None:
            raise RefusedError(
                "the scan has no points of this instance, and no box or pose is given"
            )
        inside = (self.cloud.points > corners.min(axis=0) - _CROP_MARGIN_M).all(axis=1)
        inside &= (self.cloud.points < corners.max(axis=0) + _CROP_MARGIN_M).all(axis=1)
        cropped = np.flatnonzero(inside)
        if self.cloud.label is None:
            return cropped
        label = self.cloud.label[cropped]
        kinds = {hint.category, *(hint.choices[0] if hint.choices else ())}
        meant = [k for k, names in self.categories.items() if kinds & {*names}]
        alike = cropped[np.isin(label, meant)]
        return alike if len(alike) >= MIN_OBJECT_POINTS else cropped[~np.isin(label, _ROOM_LABELS)]

    def candidates(
        self, hint: Hint, rows: Rows, evidence: Evidence, box: Box
    ) -> list[tuple[CadModel, Array]]:
        """CADs with their possible upright orientations, the most similar first.

        Empty where a box shall stand for the object, because no CAD may have its size.

        Raises:
            RefusedError: There is none.
        """
        if hint.cad is not None:
            fitting = [model for model in self.models if model.id == hint.cad]
            if not fitting:
                raise RefusedError(f"there is no CAD {hint.cad!r}")
        elif hint.choices is not None:
            return self._chosen(hint.choices, evidence, box)
        else:
            wanted = self._wanted(hint, rows)
            fitting = [model for model in self.models if model.category in wanted]
            if not fitting:
                raise RefusedError(self._unknown(wanted, rows))
        if hint.pose is not None and hint.cad is not None:
            rotation = Rotation.from_quat(hint.pose.rotation, scalar_first=True).as_matrix()
            return [(fitting[0], upright_of(rotation))]
        return _most_alike(_standing(fitting), evidence, box)

    def of_top(
        self, hint: Hint, rows: Rows, evidence: Evidence, box: Box
    ) -> list[tuple[CadModel, Array]]:
        """The same for what stands on the floor alone, and above nothing: only its top was seen.

        Args:
            hint: The object.
            rows: Its points.
            evidence: The same without outliers.
            box: Around them, down to the floor.
        """
        standing = [group for group in map(_standing_on_floor, hint.choices or ()) if group]
        if not standing or self.cloud.instance is None:
            return []
        if self._covered(rows, evidence) > _MAX_COVERED_SHARE:
            return []
        return self._chosen(standing, evidence, box)

    def _covered(self, rows: Rows, evidence: Evidence) -> float:
        """The share of an object's plan that has points of other instances below it."""
        assert self.cloud.instance is not None
        low = np.quantile(evidence.points, 0.02, axis=0)
        places = evidence.points[:, :2]
        near = self.plan.rows(places.min(axis=0) - _PLAN_CELL_M, places.max(axis=0) + _PLAN_CELL_M)
        own, other = self.cloud.instance[rows[0]], self.cloud.instance[near]
        below = (other > 0) & (other != own)
        if self.cloud.label is not None:
            below &= ~np.isin(self.cloud.label[near], _ROOM_LABELS)
        heights = self.cloud.points[near, 2]
        below &= (heights > _FLOOR_M) & (heights < low[2])
        cells = {tuple(cell) for cell in _cells(evidence.points).tolist()}
        others = {tuple(cell) for cell in _cells(self.cloud.points[near[below]]).tolist()}
        return len(cells & others) / max(len(cells), 1)

    def _chosen(
        self, choices: Sequence[Sequence[str]], evidence: Evidence, box: Box
    ) -> list[tuple[CadModel, Array]]:
        """CADs of the first group of categories of which some may have the object's size.

        People's own come before those that the library would build.
        """
        _, size, _ = box.upright()
        for group in choices:
            for built in (False, True):
                ours = [
                    model
                    for model in self.models
                    if model.category in group and (model.sizes is not None) == built
                ]
                fitting = [
                    (model, up) for model, up in _standing(ours) if turns_of(model, up, size)
                ]
                if fitting:
                    natural = [(model, up) for model, up in fitting if is_natural(model, up, size)]
                    return _most_alike(natural or fitting, evidence, box)
        return []

    def _wanted(self, hint: Hint, rows: Rows) -> Sequence[str]:
        if hint.category is not None:
            return (hint.category,)
        if self.cloud.label is None:
            return sorted({model.category for model in self.models})
        return self.categories.get(self._label(rows), ())

    def _label(self, rows: Rows) -> int:
        """The majority class of an object's points; 0 without labels."""
        if self.cloud.label is None:
            return 0
        return int(np.bincount(np.maximum(self.cloud.label[rows], 0)).argmax())

    def _unknown(self, wanted: Sequence[str], rows: Rows) -> str:
        """Why there is no CAD to choose."""
        if wanted:
            return f"there is no CAD of the category {' or '.join(wanted)}"
        label = self._label(rows)
        if label in _LAYOUT_LABELS:
            return f"its points are labelled {_LAYOUT_LABELS[label]}, which the layout reconstructs"
        return f"no CAD has the category of its points' class {label}"


def _standing_on_floor(group: Sequence[str]) -> tuple[str, ...]:
    """Those of some categories that stand on the floor and nowhere else."""
    known = ((kind, record(kind)) for kind in group)
    return tuple(
        k for k, told in known if told and told.support == "floor" and not told.alternative_supports
    )


def _cells(points: Array) -> Ints:
    """(K, 2) the cells of the plan that have points."""
    return np.unique(np.floor(points[:, :2] / _PLAN_CELL_M).astype(np.int64), axis=0)


def _standing(models: Sequence[CadModel]) -> list[tuple[CadModel, Array]]:
    return [(model, upright) for model in models for upright in _uprights(model)]


def _most_alike(
    standing: list[tuple[CadModel, Array]], evidence: Evidence, box: Box
) -> list[tuple[CadModel, Array]]:
    if len(standing) <= _MAX_CADS:
        return standing
    order = ranked([m for m, _ in standing], [u for _, u in standing], evidence, box)
    return [standing[row] for row in order[:_MAX_CADS]]


def _uprights(model: CadModel) -> list[Array]:
    return [UPRIGHT[model.up]] if model.up else [UPRIGHT["Y"], UPRIGHT["Z"]]


def ranked(
    models: Sequence[CadModel], uprights: Sequence[Array], evidence: Evidence, box: Box
) -> list[int]:
    """Rows of the models, the most similar first.

    Args:
        models: Candidates.
        uprights: (3, 3) of each, to Z up.
        evidence: The points of the object.
        box: Around the points.
    """
    base, size, _ = box.upright()
    seen = _descriptor(evidence.points - base, size)
    costs = [
        _unlike(model, upright, size, seen) for model, upright in zip(models, uprights, strict=True)
    ]
    return [int(row) for row in np.argsort(costs, kind="stable")]


def _unlike(model: CadModel, upright: Array, size: Array, seen: Array) -> float:
    low, high = np.sort(model.extent @ upright.T, axis=0)
    own = high - low
    # Proportions, plus a bounded penalty of the scale: a CAD may come without a unit.
    ratio = np.log(np.maximum(_level_sorted(own), 1e-9) / np.maximum(_level_sorted(size), 1e-9))
    lengths = float(np.abs(ratio - np.median(ratio)).mean() + min(abs(np.median(ratio)), 0.5))
    base = np.array([0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2]])
    shape = _descriptor(model.surface.points @ upright.T - base, own)
    return lengths / _LENGTH_RATIO_LOG + float(np.abs(shape - seen).sum())


def _level_sorted(size: Array) -> Array:
    return np.array([*np.sort(size[:2]), size[2]])


def _descriptor(points: Array, size: Array) -> Array:
    """(R * L,) histogram of the surface over distance from the vertical axis and height.

    Invariant under rotations about the vertical.
    """
    radius = np.linalg.norm(points[:, :2], axis=1) / max(0.5 * float(np.hypot(*size[:2])), 1e-9)
    height = points[:, 2] / max(float(size[2]), 1e-9)
    ring = np.clip((radius * _RADIAL_BINS).astype(np.intp), 0, _RADIAL_BINS - 1)
    layer = np.clip((height * _HEIGHT_BINS).astype(np.intp), 0, _HEIGHT_BINS - 1)
    counts = np.bincount(layer * _RADIAL_BINS + ring, minlength=_RADIAL_BINS * _HEIGHT_BINS)
    return np.asarray(counts / max(len(points), 1))
