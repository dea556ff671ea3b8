"""Rooms and furniture that are built from boxes, for scans whose difficulty is known."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.scan.rooms import GLASS, MIRROR, OPAQUE, Part, SimulatedRoom
from benchmarks.scan.symmetry import symmetry_of
from benchmarks.scan.truth import Cad, Truth, moved, pose_matrix
from openrooms_usd import names
from openrooms_usd.geometry.polygons import triangulated
from openrooms_usd.scan.results import FoundObject, FoundOpening, FoundRoom, Pose
from openrooms_usd.usd.semantics import class_of, number_of

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Box = tuple[tuple[float, float, float], tuple[float, float, float]]

_DEPTH: Final = 0.2
# A pane or mirror lies this far behind or before its wall's face, metres.
_PANE, _BEFORE = 0.1, 0.01


class Hole(NamedTuple):
    """A rectangle in wall ``wall``: from ``left`` metres from its first corner on."""

    wall: int
    left: float
    width: float
    low: float
    high: float
    type: str = "door"
    optics: int = OPAQUE


class Placed(NamedTuple):
    """A model that stands somewhere."""

    cad: str
    at: tuple[float, float, float]
    yaw: float = 0.0
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


@dataclass
class _Soup:
    """Triangles that are gathered part by part."""

    corners: list[Array]
    owner: list[Ints]
    parts: list[Part]

    def add(self, triangles: Array, part: Part) -> None:
        self.owner.append(np.full(len(triangles), len(self.parts)))
        self.corners.append(triangles)
        self.parts.append(part)

    def room(self, truth: Truth) -> SimulatedRoom:
        corners = np.concatenate(self.corners)
        rows = np.arange(3 * len(corners)).reshape(-1, 3)
        owner = np.concatenate(self.owner)
        return SimulatedRoom(corners.reshape(-1, 3), rows, owner, tuple(self.parts), truth)


def built(
    outline: Sequence[tuple[float, float]],
    height: float = 2.5,
    holes: Sequence[Hole] = (),
    things: Sequence[Placed] = (),
) -> SimulatedRoom:
    """A room of an outline, counter-clockwise, with holes and furniture.

    Args:
        outline: (x, y) of its corners, metres.
        height: Of the ceiling.
        holes: Doors, windows (with panes) and mirrors, which are no openings.
        things: Of `CADS`; instances are numbered from 1.
    """
    corners = np.column_stack([np.array(outline, float), np.zeros(len(outline))])
    soup = _Soup([], [], [])
    flat = np.pad(triangulated(corners[:, :2]), ((0, 0), (0, 0), (0, 1)))
    soup.add(flat, Part(_nyu("floor"), 0))
    soup.add(flat + np.array([0, 0, height]), Part(_nyu("ceiling"), 0))
    openings = []
    for wall in range(len(corners)):
        own = [hole for hole in holes if hole.wall == wall]
        cut = [hole for hole in own if hole.optics != MIRROR]
        frame = _wall_frame(corners, wall)
        soup.add(_wall(frame, height, cut), Part(_nyu("wall"), 0, wall=wall))
        for hole in cut:
            soup.add(_reveal(frame, hole), Part(_nyu(hole.type), 0, wall=wall))
            openings.append(_opening(frame, hole))
        for hole in own:
            if hole.optics != OPAQUE:
                away = _PANE if hole.optics == GLASS else -_BEFORE
                pane = _quad(frame, hole.left, hole.width, hole.low, hole.high, away)
                soup.add(pane, Part(_nyu("window"), 0, hole.optics, wall))
    found = tuple(_found(thing, number) for number, thing in enumerate(things, 1))
    for item in found:
        cad = CADS[item.cad]
        soup.add(
            moved(pose_matrix(item.pose), cad.vertices)[cad.faces],
            Part(_nyu(cad.category), item.instance),
        )
    up = np.array([0.0, 0.0, 1.0])
    room = FoundRoom(up, corners[0], corners, (), height, tuple(openings))
    return soup.room(Truth((room,), found, {item.cad: CADS[item.cad] for item in found}))


def _nyu(category: str) -> int:
    return number_of(class_of(category, names.NYU40), names.NYU40)


def _found(thing: Placed, number: int) -> FoundObject:
    half = np.radians(thing.yaw) / 2
    turn = np.array([np.cos(half), 0, 0, np.sin(half)])
    pose = Pose(np.array(thing.at), turn, np.array(thing.scale))
    cad = CADS[thing.cad]
    return FoundObject(number, cad.category, cad.id, pose, 0.0, 1.0, cad.symmetry, pose)


def _wall_frame(corners: Array, wall: int) -> tuple[Array, Array, Array, float]:
    """A wall's first corner, unit vectors along it and outwards, and its length."""
    a, b = corners[wall], corners[(wall + 1) % len(corners)]
    length = float(np.linalg.norm(b - a))
    along = (b - a) / length
    return a, along, np.array([along[1], -along[0], 0.0]), length


def _quad(
    frame: tuple[Array, Array, Array, float], left: float, width: float, low: float, high: float,
    away: float = 0.0,
) -> Array:  # fmt: skip
    """(2, 3, 3) triangles of a rectangle in a wall's plane, or parallel to it further out."""
    origin, along, outward, _ = frame
    ring = [(left, low), (left, high), (left + width, high), (left + width, low)]
    a, b, c, d = (origin + u * along + away * outward + np.array([0.0, 0.0, v]) for u, v in ring)
    return np.array([[a, b, c], [a, c, d]])


def _wall(frame: tuple[Array, Array, Array, float], height: float, holes: Sequence[Hole]) -> Array:
    """(F, 3, 3) triangles of a wall: the cells between the holes' edges that are in no hole."""
    us = sorted({0.0, frame[3], *(e for h in holes for e in (h.left, h.left + h.width))})
    vs = sorted({0.0, height, *(e for h in holes for e in (h.low, h.high))})
    cells = []
    for left, right in pairwise(us):
        for low, high in pairwise(vs):
            u, v = (left + right) / 2, (low + high) / 2
            if not any(0 < u - h.left < h.width and h.low < v < h.high for h in holes):
                cells.append(_quad(frame, left, right - left, low, high))
    return np.concatenate(cells)


def _reveal(frame: tuple[Array, Array, Array, float], hole: Hole) -> Array:
    """(8, 3, 3) the sides of a hole through the wall's thickness."""
    near = _quad(frame, hole.left, hole.width, hole.low, hole.high)
    far = _quad(frame, hole.left, hole.width, hole.low, hole.high, _DEPTH)
    (a, b, c), d = near[0], near[1, 2]
    (e, f, g), h = far[0], far[1, 2]
    sides = [(a, b, f, e), (b, c, g, f), (c, d, h, g), (d, a, e, h)]
    return np.array([t for p, q, r, s in sides for t in ((p, q, r), (p, r, s))])


def _opening(frame: tuple[Array, Array, Array, float], hole: Hole) -> FoundOpening:
    """From bottom left as seen from inside: the left is at the wall's far end."""
    origin, along, _, _ = frame
    right, left = hole.left, hole.left + hole.width
    ring = [(left, hole.low), (right, hole.low), (right, hole.high), (left, hole.high)]
    corners = np.array([origin + u * along + np.array([0.0, 0.0, v]) for u, v in ring])
    return FoundOpening("window" if hole.type == "window" else "door", corners, 1.0, hole.wall)


def _cad(name: str, category: str, boxes: Sequence[Box]) -> Cad:
    """A model of axis-aligned boxes, each from its lowest to its highest corner."""
    rows = np.array([(i >> 2 & 1, i >> 1 & 1, i & 1) for i in range(8)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))])
    points = [np.take_along_axis(np.array(box), rows, axis=0) for box in boxes]
    vertices = np.concatenate(points)
    triangles = np.concatenate([faces + 8 * i for i in range(len(boxes))])
    return Cad(name, category, vertices, triangles, symmetry_of(vertices, triangles))


def _legs(x: float, y: float, height: float, thick: float) -> list[Box]:
    """Four legs inside of the rectangle from -x to x and -y to y."""
    lows = [(a, b) for a in (-x, x - thick) for b in (-y, y - thick)]
    return [((a, b, 0.0), (a + thick, b + thick, height)) for a, b in lows]


def _models() -> Mapping[str, Cad]:
    shelf: list[Box] = [((-0.4, -0.15, z), (0.4, 0.15, z + 0.02)) for z in (0, 0.33, 0.66, 0.98)]
    shelf += [((x, -0.15, 0), (x + 0.02, 0.15, 1.0)) for x in (-0.4, 0.38)]
    shelf += [((-0.4, 0.14, 0), (0.4, 0.15, 1.0))]
    chair: list[Box] = [((-0.22, -0.22, 0.43), (0.22, 0.22, 0.47)), *_legs(0.22, 0.22, 0.43, 0.04)]
    chair += [((-0.22, 0.18, 0.47), (0.22, 0.22, 0.92))]
    sofa: list[Box] = [((-0.9, -0.4, 0), (0.9, 0.4, 0.42)), ((-0.9, 0.2, 0.42), (0.9, 0.4, 0.85))]
    sofa += [((x, -0.4, 0.42), (x + 0.15, 0.4, 0.6)) for x in (-0.9, 0.75)]
    table: list[Box] = [((-0.7, -0.4, 0.70), (0.7, 0.4, 0.74)), *_legs(0.68, 0.38, 0.70, 0.05)]
    pendant: list[Box] = [((-0.15, -0.15, 0.0), (0.15, 0.15, 0.2))]
    pendant += [((-0.02, -0.02, 0.2), (0.02, 0.02, 0.8))]
    sectional: list[Box] = [((-1, 0.2, 0), (1, 1, 0.42)), ((0.2, -1, 0), (1, 0.2, 0.42))]
    sectional += [((-1, 0.8, 0.42), (1, 1, 0.8)), ((0.8, -1, 0.42), (1, 0.8, 0.8))]
    models = [
        _cad("chair", "chair", chair),
        _cad("table", "table", table),
        _cad("sofa", "sofa", sofa),
        _cad("shelf", "bookshelf", shelf),
        _cad("cube", "box", [((-0.3, -0.3, 0.0), (0.3, 0.3, 0.6))]),
        _cad("cabinet", "cabinet", [((-0.5, -0.2, 0.0), (0.5, 0.2, 0.8))]),
        _cad("carton", "box", [((-0.13, -0.1, 0.0), (0.13, 0.1, 0.25))]),
        _cad("counter", "counter", [((-0.3, -0.3, 0.0), (0.3, 0.3, 0.9))]),
        _cad("rug", "rug", [((-1.2, -0.9, 0.0), (1.2, 0.9, 0.012))]),
        _cad("television", "television", [((-0.5, -0.03, 0.0), (0.5, 0.03, 0.58))]),
        _cad("pendant", "ceiling_lamp", pendant),
        _cad("sectional", "sofa", sectional),
    ]
    return {model.id: model for model in models}


CADS: Final = _models()
