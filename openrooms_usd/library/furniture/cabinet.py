"""Cabinets: doors, drawers, open shelves, and a sideboard of all three."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

import numpy as np

from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.library.furniture.joinery import (
    Parts,
    Size,
    Style,
    board,
    corners,
    numbered,
    round_leg,
    splayed,
)

BOARD: Final = 0.018
GAP: Final = 0.003

Cell = tuple[float, float, float, float]
"""Left, right, lower and upper edge of an opening in the front, metres."""


@dataclass
class Carcass:
    """A cabinet under construction: the boards so far, and where its front stands.

    Attributes:
        width: Outer width, metres.
        front: Y of the carcass's front edge, metres.
        back: Y of its back, metres.
        low: Z of its lower side, metres.
        high: Z of its top, metres.
        boards: Parts by name.
    """

    width: float
    front: float
    back: float
    low: float
    high: float
    boards: dict[str, list[Mesh]] = field(default_factory=dict)

    def add(self, part: str, mesh: Mesh) -> None:
        """Add an instance of a part."""
        self.boards.setdefault(part, []).append(mesh)

    def parts(self) -> Parts:
        """All parts by their numbered names."""
        return {
            name: mesh
            for part, meshes in self.boards.items()
            for name, mesh in numbered(part, meshes).items()
        }

    def inside(self) -> Cell:
        """The opening between the outer boards."""
        half = 0.5 * self.width - BOARD
        return -half, half, self.low + BOARD, self.high - BOARD


def _carcass(width: float, front: float, back: float, low: float, high: float) -> Carcass:
    """Sides, top, bottom and a thin back."""
    cabinet = Carcass(width, front, back, low, high)
    half = 0.5 * width
    for x in (-half, half - BOARD):
        cabinet.add("frame", board((x, front, low), (x + BOARD, back, high)))
    for z in (low, high - BOARD):
        cabinet.add("frame", board((BOARD - half, front, z), (half - BOARD, back, z + BOARD)))
    inner = 0.5 * BOARD - half
    cabinet.add(
        "frame", board((inner, back - 0.014, low + 0.009), (-inner, back - 0.006, high - 0.009))
    )
    return cabinet


def _plinth(cabinet: Carcass) -> None:
    half = 0.5 * cabinet.width
    cabinet.add(
        "base",
        board(
            (0.012 - half, cabinet.front + 0.035, 0.0),
            (half - 0.012, cabinet.back - 0.01, cabinet.low),
        ),
    )


def _legs(cabinet: Carcass) -> None:
    middle = 0.5 * (cabinet.front + cabinet.back)
    x = 0.5 * cabinet.width - 0.06
    y = 0.5 * (cabinet.back - cabinet.front) - 0.05
    leg = round_leg(0.018, 0.011, cabinet.low)
    for a, b in corners(x, y):
        foot = (a + np.sign(a) * 0.025, b + np.sign(b) * 0.02)
        cabinet.add("leg", splayed(leg, foot, (a, b)).moved((0.0, middle, 0.0)))


def _split(low: float, high: float, shares: Sequence[float]) -> list[tuple[float, float]]:
    edges = low + (high - low) * np.concatenate([[0.0], np.cumsum(shares) / np.sum(shares)])
    return [(float(a), float(b)) for a, b in pairwise(edges)]


def _front(cabinet: Carcass, part: str, cell: Cell) -> None:
    """A door or drawer front before the carcass, with a gap all around."""
    left, right, low, high = cell
    half = 0.5 * GAP
    cabinet.add(
        part,
        board(
            (left + half, cabinet.front - BOARD - 0.001, low + half),
            (right - half, cabinet.front - 0.001, high - half),
        ),
    )


def bar(length: float) -> Mesh:
    """A bent bar handle along X, 28 mm before the front at y = 0."""
    half = 0.5 * length
    path = [(-half, 0.0, 0.0), (-half, -0.0235, 0.0), (half, -0.0235, 0.0), (half, 0.0, 0.0)]
    return tube(filleted(path, 0.01, segments=4), 0.0045, segments=10)


def _knob() -> Mesh:
    """A turned knob, 28 mm before the front at y = 0."""
    profile = [(0.0, 0.0), (0.006, 0.0), (0.005, 0.012), (0.011, 0.017), (0.0135, 0.021),
               (0.012, 0.026), (0.007, 0.028), (0.0, 0.028)]  # fmt: skip
    forward = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    return lathe(profile, segments=20, crease=70.0).transformed(forward)


HANDLE: Final = 0.028


def _handle(cabinet: Carcass, x: float, z: float, length: float, upright: bool, knob: bool) -> None:
    mesh = _knob() if knob else bar(length)
    if upright and not knob:
        mesh = mesh.transformed(np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]))
    cabinet.add("handle", mesh.moved((x, cabinet.front - BOARD - 0.001, z)))


def _doors(cabinet: Carcass, cell: Cell, knob: bool) -> None:
    """Doors side by side, in pairs that open from their middle."""
    left, right, low, high = cell
    count = max(1, round((right - left) / 0.45))
    for i, (a, b) in enumerate(_split(left, right, [1.0] * count)):
        _front(cabinet, "door", (a, b, low, high))
        x = b - 0.04 if i % 2 == 0 else a + 0.04  # neighbours open away from each other
        tall = high - low
        z = low + 0.5 * tall if tall > 0.9 else high - min(0.14, 0.3 * tall)
        if low > 1.2:
            z = low + min(0.14, 0.3 * tall)
        _handle(cabinet, x, z, min(0.16, 0.4 * tall), True, knob)


def _drawers(cabinet: Carcass, cell: Cell, knob: bool) -> None:
    """Drawers above each other, lower ones taller."""
    left, right, low, high = cell
    count = max(1, round((high - low) / 0.2))
    for a, b in _split(low, high, np.linspace(1.18, 0.86, count).tolist()):
        _front(cabinet, "drawer_front", (left, right, a, b))
        wide = right - left
        xs = (-0.27 * wide, 0.27 * wide) if knob and wide > 0.55 else (0.0,)
        for x in xs:
            _handle(cabinet, 0.5 * (left + right) + x, 0.5 * (a + b), min(0.2, 0.4 * wide),
                    False, knob)  # fmt: skip


def _shelves(cabinet: Carcass, cell: Cell) -> None:
    """Open compartments: shelves about a hand's span and a half apart."""
    left, right, low, high = cell
    count = max(1, round((high - low) / 0.33))
    edges = [edge for edge, _ in _split(low, high, [1.0] * count)][1:]
    for z in edges:
        cabinet.add(
            "shelf",
            board(
                (left, cabinet.front + 0.006, z - 0.5 * BOARD),
                (right, cabinet.back - 0.014, z + 0.5 * BOARD),
            ),
        )


def _divider(cabinet: Carcass, x: float, low: float, high: float) -> None:
    cabinet.add(
        "frame",
        board((x - 0.5 * BOARD, cabinet.front, low), (x + 0.5 * BOARD, cabinet.back - 0.014, high)),
    )


def _plinth_height(height: float) -> float:
    return 0.07 if height > 0.5 else 0.03


def _closed(size: Size, low: float) -> Carcass:
    """A carcass that leaves room for fronts and handles before it."""
    width, depth, height = size
    front = -0.5 * depth + HANDLE + BOARD + 0.001
    return _carcass(width, front, 0.5 * depth, low, height)


def _overlay(cabinet: Carcass) -> Cell:
    """The area that overlaid fronts cover: all of the front."""
    half = 0.5 * cabinet.width
    return -half, half, cabinet.low, cabinet.high


def doors(size: Size, rng: np.random.Generator) -> Parts:
    """Hinged doors over the whole front; tall ones in two rows."""
    cabinet = _closed(size, _plinth_height(size[2]))
    _plinth(cabinet)
    left, right, low, high = _overlay(cabinet)
    knob = bool(rng.integers(2))
    share = float(rng.uniform(0.6, 0.7))
    tiers = [1.0] if high - low < 1.5 else [share, 1.0 - share]
    for a, b in _split(low, high, tiers):
        _doors(cabinet, (left, right, a, b), knob)
    return cabinet.parts()


def drawers(size: Size, rng: np.random.Generator) -> Parts:
    """A chest: rows of drawers, in two columns where it is wide."""
    cabinet = _closed(size, _plinth_height(size[2]))
    _plinth(cabinet)
    left, right, low, high = _overlay(cabinet)
    knob = bool(rng.integers(2))
    columns = max(1, round((right - left) / 0.75))
    for a, b in _split(left, right, [1.0] * columns):
        _drawers(cabinet, (a, b, low, high), knob)
    return cabinet.parts()


def shelves(size: Size, rng: np.random.Generator) -> Parts:
    """An open bookcase."""
    width, depth, height = size
    cabinet = _carcass(width, -0.5 * depth, 0.5 * depth, _plinth_height(height), height)
    _plinth(cabinet)
    left, right, low, high = cabinet.inside()
    columns = max(1, round((right - left) / float(rng.uniform(0.7, 0.9))))
    for i, (a, b) in enumerate(_split(left, right, [1.0] * columns)):
        if i:
            _divider(cabinet, a, low, high)
        pad = 0.5 * BOARD
        _shelves(
            cabinet, (a + (pad if i else 0.0), b - (pad if i < columns - 1 else 0.0), low, high)
        )
    return cabinet.parts()


def _fill_open(cabinet: Carcass, cell: Cell, knob: bool) -> None:
    _shelves(cabinet, (cell[0] + 0.5 * BOARD, cell[1] - 0.5 * BOARD, *cell[2:]))


def sideboard(size: Size, rng: np.random.Generator) -> Parts:
    """Legs, and columns of doors, drawers and open shelves side by side."""
    height = size[2]
    cabinet = _closed(size, min(0.16, 0.22 * height))
    _legs(cabinet)
    left, right, low, high = _overlay(cabinet)
    columns = max(2, round((right - left) / 0.5))
    fills: list[Callable[[Carcass, Cell, bool], None]] = [_doors, _drawers, _fill_open]
    knob, start = bool(rng.integers(2)), int(rng.integers(len(fills)))
    for i, (a, b) in enumerate(_split(left, right, [1.0] * columns)):
        if i:
            _divider(cabinet, a, low + BOARD, high - BOARD)
        fill = fills[(start + i) % len(fills)]
        fill(cabinet, (a, b, low, high), knob)
    return cabinet.parts()


STYLES: Final = {
    "doors": Style(doors),
    "drawers": Style(drawers, lambda size: size[2] < 1.35),
    "shelves": Style(shelves, lambda size: size[1] < 0.5, (0.8, 0.3, 1.8)),
    "sideboard": Style(sideboard, lambda size: size[0] > 0.8 and size[2] < 1.1, (1.5, 0.42, 0.75)),
}
