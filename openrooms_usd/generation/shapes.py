"""The real form of library objects, as far as arranging them asks: their parts and tops."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Final, TypeAlias

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.draws import generator
from openrooms_usd.furniture import NOTHING_ORDERED, FitOptions, Size, make
from openrooms_usd.geometry.mesh import Mesh

Foot: TypeAlias = tuple[float, float, float, float]
"""Least x and y and greatest x and y, metres."""

# Parts of furniture that one sees through.
_PANES: Final = ("pane",)
# A box around a part that is higher than this is cut into slices, metres.
_SLICE_HEIGHT_M: Final = 0.15
# An object stands on its points below this height, metres.
_FOOT_HEIGHT_M: Final = 0.0065


@dataclass(frozen=True, eq=False)
class BuiltForm:
    """An object of the library as it will be built.

    Attributes:
        meshes: Its parts, in the object frame.
        names: Of the parts, where they are known.
    """

    meshes: tuple[Mesh, ...]
    names: tuple[str, ...] = ()

    def named(self, word: str) -> Iterator[Mesh]:
        """The parts of a kind: ``hook`` gives ``hook_0``, ``hook_1`` ..."""
        pairs = zip(self.names, self.meshes, strict=False)
        return (mesh for name, mesh in pairs if name.rsplit("_", 1)[0] == word or name == word)

    @cached_property
    def corners(self) -> Array:
        """(T, 3, 3) the corners of all triangles, metres."""
        found = []
        for mesh in self.meshes:
            triangles, _ = mesh.triangles()
            found.append(mesh.points[mesh.indices[triangles]])
        return np.concatenate(found)

    @cached_property
    def opaque(self) -> Array:
        """(T, 3, 3) likewise, without those of panes that one sees through."""
        panes = {id(mesh) for word in _PANES for mesh in self.named(word)}
        kept = [mesh for mesh in self.meshes if id(mesh) not in panes]
        return BuiltForm(tuple(kept)).corners if panes else self.corners

    @cached_property
    def foot(self) -> Foot:
        """What it stands on: the reach of its lowest points."""
        points = np.concatenate([mesh.points for mesh in self.meshes])
        low = points[points[:, 2] < _FOOT_HEIGHT_M, :2]
        (x0, y0), (x1, y1) = low.min(axis=0).tolist(), low.max(axis=0).tolist()
        return x0, y0, x1, y1

    @cached_property
    def slices(self) -> Array:
        """(B, 8) upright boxes in the object frame that together hold all of it."""
        rows = [row for mesh in self.meshes for row in _sliced(mesh)]
        return np.array(rows)

    def highest(self, area: Array) -> float:
        """Height of its highest point within the plan of (8,) a box, metres; -inf without any."""
        points = self.corners.reshape(-1, 3)
        dx, dy = points[:, 0] - area[0], points[:, 1] - area[1]
        within = np.abs(area[2] * dx + area[3] * dy) <= area[4]
        within &= np.abs(area[2] * dy - area[3] * dx) <= area[5]
        return float(points[within, 2].max(initial=-np.inf))

    def tops(self, x: Array, y: Array) -> Array:
        """(N,) where vertical lines meet it last, metres; -inf where they miss it."""
        return tops(self.corners, x, y)


def tops(corners: Array, x: Array, y: Array) -> Array:
    """(N,) where vertical lines meet triangles last, metres; -inf where they miss all.

    Args:
        corners: (T, 3, 3) metres.
        x: (N,) metres.
        y: (N,) metres.
    """
    low, high = corners[..., :2].min(axis=1), corners[..., :2].max(axis=1)
    near = (low[:, 0] <= x.max()) & (high[:, 0] >= x.min())
    near &= (low[:, 1] <= y.max()) & (high[:, 1] >= y.min())
    a, b, c = np.moveaxis(corners[near], 1, 0)
    e, f = b - a, c - a
    px, py = x[:, None] - a[:, 0], y[:, None] - a[:, 1]
    area = e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        v = (px * f[:, 1] - py * f[:, 0]) / area
        w = (e[:, 0] * py - e[:, 1] * px) / area
        hit = (area != 0.0) & (v >= -1e-9) & (w >= -1e-9) & (v + w <= 1.0 + 1e-9)
        heights = np.where(hit, a[:, 2] + v * e[:, 2] + w * f[:, 2], -np.inf)
    return np.asarray(heights.max(axis=1, initial=-np.inf))


def _sliced(mesh: Mesh) -> list[Array]:
    """Boxes around a part: one for a low part, one a slice for a high one that leans or tapers."""
    (x0, y0, z0), (x1, y1, z1) = mesh.extent.tolist()
    count = int((z1 - z0) / _SLICE_HEIGHT_M) if z1 - z0 > 2 * _SLICE_HEIGHT_M else 1
    if count == 1:
        return [_row(x0, y0, z0, x1, y1, z1)]
    triangles, _ = mesh.triangles()
    corners = mesh.points[mesh.indices[triangles]]
    low, high = corners[..., 2].min(axis=1), corners[..., 2].max(axis=1)
    edges = np.linspace(z0, z1, count + 1)
    rows = []
    for a, b in pairwise(edges.tolist()):
        points = _between(corners[(low <= b) & (high >= a)], a, b)
        if len(points):
            (px0, py0), (px1, py1) = points.min(axis=0), points.max(axis=0)
            rows.append(_row(px0, py0, a, px1, py1, b))
    return rows


def _between(corners: Array, low: float, high: float) -> Array:
    """(P, 2) the plan of the corners of triangles, cut off below and above two heights."""
    following = np.roll(corners, -1, axis=1)
    points = []
    for start, end in ((corners, following),):
        rise = end[..., 2] - start[..., 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            for height in (low, high):
                t = (height - start[..., 2]) / rise
                crossed = (t >= 0.0) & (t <= 1.0) & (rise != 0.0)
                cut = start[..., :2] + t[..., None] * (end - start)[..., :2]
                points.append(cut[crossed])
    kept = (corners[..., 2] >= low) & (corners[..., 2] <= high)
    points.append(corners[..., :2][kept])
    return np.concatenate(points)


def _row(x0: float, y0: float, z0: float, x1: float, y1: float, z1: float) -> Array:
    return np.array(
        [0.5 * (x0 + x1), 0.5 * (y0 + y1), 1.0, 0.0, 0.5 * (x1 - x0), 0.5 * (y1 - y0), z0, z1]
    )


@dataclass
class Shapes:
    """Builds each distinct object once, just as the alignment step will.

    Attributes:
        seed: The room's.
    """

    seed: int
    _known: dict[tuple[str, Size, str, FitOptions], BuiltForm] = field(default_factory=dict)

    def know(self, category: str, size: Size, style: str, shape: BuiltForm) -> None:
        """Take the form of an object of people's own."""
        self._known[category, size, style, NOTHING_ORDERED] = shape

    def of(
        self, category: str, size: Size, style: str, order: FitOptions = NOTHING_ORDERED
    ) -> BuiltForm:
        """The form of an object."""
        key = (category, size, style, order)
        if key not in self._known:
            # The key of the alignment step: the same draws give the same details.
            rng = generator(self.seed, "alignment", "details", category, repr(size), style)
            parts = make(category, size, style, rng, order).parts
            self._known[key] = BuiltForm(tuple(parts.values()), tuple(parts))
        return self._known[key]
