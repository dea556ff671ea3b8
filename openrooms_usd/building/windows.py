"""Windows: an outer frame with a sill board, and sashes that turn or slide.

Panes are thin boxes whose edges stand in the bars around them; each sash takes its own along.

Frames are in their opening's frame: x to the right seen from inside, y outwards, z up, the origin
in the middle of the opening on the wall's inner face.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from openrooms_usd.building.faces import prism
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box, rounded_box

# How far parts reach into the wall and into each other, so that no seam lets light pass, metres.
EMBED = 0.005

_GLASS = 0.004  # thickness of a pane

Span = tuple[float, float]

_PROFILE = 0.06  # visible width of the outer frame
_DEPTH = 0.07
_SHARE = 0.6  # of a wall's thickness that is before the middle of the frame
_SASH = 0.05  # visible width of a sash
_REBATE = 0.012  # how far the frame reaches behind the edges of a sash
_GAP = 0.003  # between a sash and the frame beside it
_LIGHT = 0.75  # the width that one sash usually has
_PANE = 0.42  # the width and height that one pane of a grid usually has
_BAR = 0.022  # width of the bars between panes
BOARD = 0.025  # thickness of the sill board
NOSE = 0.04  # how far the board stands out into the room and beyond the opening
_WIDE_OPEN = 90.0  # how far sashes turn, degrees


@dataclass(frozen=True, eq=False)
class Sash:
    """The part of a window that moves.

    Attributes:
        mesh: Its bars, about its own origin.
        pane: Its glass, about the same.
        kind: Whether it turns or slides.
        origin: A point of its axis in the opening's frame, metres.
        axis: Of its movement: into the room where it turns, upwards or downwards where it slides.
        upper: How far it moves, degrees or metres.
    """

    mesh: Mesh
    pane: Mesh
    kind: Literal["hinge", "rail"]
    origin: tuple[float, float, float]
    axis: tuple[float, float, float]
    upper: float


@dataclass(frozen=True, eq=False)
class Window:
    """The parts of a window.

    Attributes:
        frame: What stands fast, in the opening's frame: closed solids that overlap each other and
            the wall.
        panes: The glass that stands fast, a piece each.
        sashes: What moves, from the left or from below.
    """

    frame: Mesh
    panes: tuple[Mesh, ...]
    sashes: tuple[Sash, ...]

    def closed(self) -> Mesh:
        """All of it but the glass in the opening's frame, shut."""
        return joined([self.frame, *(sash.mesh.moved(sash.origin) for sash in self.sashes)])


@dataclass(frozen=True)
class _Box:
    """What a style builds in: the clear opening of the outer frame.

    Attributes:
        x: Left and right, metres.
        y: Inner and outer face of the frame, metres.
        z: Lower and upper, metres.
        slim: By how much profiles are slimmer than usual; 1 for all but small windows.
    """

    x: Span
    y: Span
    z: Span
    slim: float


# Bars and glass that stand fast, and what moves.
_Filling = tuple[list[Mesh], list[Mesh], list[Sash]]


def bar(x: Span, y: Span, z: Span, radius: float = 0.002) -> Mesh:
    """A box with softened edges between two values of each coordinate, metres."""
    low, high = np.sort(np.array([x, y, z], dtype=np.float64), axis=1).T
    return rounded_box(high - low, radius, center=0.5 * (low + high))


def pane(x: Span, y: Span, z: Span) -> Mesh:
    """Glass within an opening between bars, in the middle of their thickness.

    Args:
        x: Left and right edge of the opening, metres.
        y: Front and back of the bars.
        z: Lower and upper edge.
    """
    (left, right), (low, high) = _wider(x, EMBED), _wider(z, EMBED)
    middle = (0.5 * (left + right), 0.5 * (y[0] + y[1]), 0.5 * (low + high))
    return box((right - left, _GLASS, high - low), middle)


def rectangle(x: Span, z: Span, y: Span, width: float) -> list[Mesh]:
    """Four bars of a width around the inside of a rectangle: two stiles and two rails."""
    inner = (x[0] + width - EMBED, x[1] - width + EMBED)
    return [
        bar((x[0], x[0] + width), y, z),
        bar((x[1] - width, x[1]), y, z),
        bar(inner, y, (z[0], z[0] + width)),
        bar(inner, y, (z[1] - width, z[1])),
    ]


def window(
    width: float,
    height: float,
    thickness: float,
    *,
    board: bool,
    style: str = "casement",
    beyond: float = NOSE,
) -> Window:
    """Make a window that fills an opening.

    Args:
        width: Of the opening, metres.
        height: Of the opening, metres.
        thickness: Of the wall, metres.
        board: Whether it has a sill board.
        style: One of `STYLES`.
        beyond: How far the sill board stands out beyond the opening on both sides, metres.
    """
    slim = min(1.0, width / 0.5, height / 0.5)  # small windows have slim profiles
    profile = slim * _PROFILE
    inner = reveal_depth(thickness)
    y = (inner, inner + _DEPTH)
    x, z = (-0.5 * width, 0.5 * width), (-0.5 * height, 0.5 * height)
    bars = rectangle(_wider(x, EMBED), _wider(z, EMBED), y, profile + EMBED)
    clear = _Box(_wider(x, -profile), y, _wider(z, -profile), slim)
    more, panes, sashes = STYLES[style](clear)
    bars += more
    if board:
        bars.append(_sill_board(width, z[0], y[0], beyond))
    return Window(joined(bars), tuple(panes), tuple(sashes))


def reveal_depth(thickness: float) -> float:
    """How deep a window's frame stands behind the inner face of a wall, metres."""
    return max(_SHARE * thickness - 0.5 * _DEPTH, 0.0)


def _lights(clear: _Box, usual: float) -> tuple[list[Mesh], list[Span]]:
    """Posts that divide a window into lights side by side, and where these are."""
    left, right = clear.x
    count = max(1, round((right - left) / usual))
    edges = np.linspace(left, right, count + 1).tolist()
    half = 0.5 * clear.slim * _PROFILE
    upright = _wider(clear.z, EMBED)
    posts = [bar((edge - half, edge + half), clear.y, upright) for edge in edges[1:-1]]
    spans = [
        (edges[i] + (half if i else 0.0), edges[i + 1] - (half if i < count - 1 else 0.0))
        for i in range(count)
    ]
    return posts, spans


def _casement(clear: _Box) -> _Filling:
    """Sashes side by side that turn into the room."""
    return _turning(clear, lambda x, z, y: [])


def _grid(clear: _Box) -> _Filling:
    """The same with small panes between bars."""
    return _turning(clear, _panes)


def _turning(clear: _Box, between: Callable[[Span, Span, Span], list[Mesh]]) -> _Filling:
    bars, spans = _lights(clear, _LIGHT)
    sashes = []
    inner, sash = clear.y[1] - 0.4 * _DEPTH, clear.slim * _SASH
    for i, span in enumerate(spans):
        # Behind the edges of the sash the frame is narrower, and keeps the wind out.
        stop = (inner + 0.001, clear.y[1] - 0.004)
        bars += rectangle(
            _wider(span, EMBED), _wider(clear.z, EMBED), stop, clear.slim * _REBATE + EMBED
        )
        x, z = _wider(span, -clear.slim * _GAP), _wider(clear.z, -clear.slim * _GAP)
        y = (clear.y[0] - 0.004, inner)
        leaf = rectangle(x, z, y, sash)
        inside = _wider(x, -sash), _wider(z, -sash)
        leaf += between(*inside, y)
        right = i % 2 == 1  # neighbours open away from each other
        axis = (x[1] if right else x[0], y[0], z[0])
        turn = (0.0, 0.0, 1.0 if right else -1.0)
        mesh, glass = (
            made.moved(-np.array(axis)) for made in (joined(leaf), pane(inside[0], y, inside[1]))
        )
        sashes.append(Sash(mesh, glass, "hinge", axis, turn, _WIDE_OPEN))
    return bars, [], sashes


def _panes(x: Span, z: Span, y: Span) -> list[Mesh]:
    """Bars that divide the inside of a sash into panes of about the same size."""
    columns, rows = (max(1 if b - a < 0.3 else 2, round((b - a) / _PANE)) for a, b in (x, z))
    half = 0.5 * min(_BAR, 0.1 * (x[1] - x[0]), 0.1 * (z[1] - z[0]))
    slim = _wider(y, -0.2 * (y[1] - y[0]))
    across, upright = _wider(x, EMBED), _wider(z, EMBED)
    places = np.linspace(*x, columns + 1)[1:-1].tolist()
    levels = np.linspace(*z, rows + 1)[1:-1].tolist()
    return [
        *(bar((p - half, p + half), slim, upright) for p in places),
        *(bar(across, _wider(slim, -0.0015), (p - half, p + half)) for p in levels),
    ]


def _sliding(clear: _Box) -> _Filling:
    """Two sashes above each other, the lower one before the upper one; both slide."""
    bars, spans = _lights(clear, 1.1)
    sashes = []
    (front, back), rail = clear.y, clear.slim * _SASH
    tracks = ((front + 0.006, front + 0.032), (back - 0.032, back - 0.006))
    stop = (front + 0.033, back - 0.033)
    middle, half = 0.5 * (clear.z[0] + clear.z[1]), 0.5 * rail
    for span in spans:
        bars += rectangle(
            _wider(span, EMBED), _wider(clear.z, EMBED), stop, clear.slim * _REBATE + EMBED
        )
        x, z = _wider(span, -clear.slim * _GAP), _wider(clear.z, -clear.slim * _GAP)
        travel = 0.85 * (middle - half - clear.z[0])
        for y, edges, up in zip(
            tracks, ((z[0], middle + half), (middle - half, z[1])), (1.0, -1.0), strict=True
        ):
            origin = (0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]), 0.5 * (edges[0] + edges[1]))
            glass = pane(_wider(x, -rail), y, _wider(edges, -rail))
            mesh, glass = (
                made.moved(-np.array(origin))
                for made in (joined(rectangle(x, edges, y, rail)), glass)
            )
            sashes.append(Sash(mesh, glass, "rail", origin, (0.0, 0.0, up), travel))
    return bars, [], sashes


def _fixed(clear: _Box) -> _Filling:
    """Large lights that do not open, with a bead around each."""
    bars, spans = _lights(clear, 1.4)
    y = (clear.y[0] + 0.3 * _DEPTH, clear.y[1] - 0.3 * _DEPTH)
    bead, panes = 0.6 * clear.slim * _SASH, []
    for span in spans:
        bars += rectangle(_wider(span, EMBED), _wider(clear.z, EMBED), y, bead + EMBED)
        panes.append(pane(_wider(span, -bead), y, _wider(clear.z, -bead)))
    return bars, panes, []


STYLES: Final[dict[str, Callable[[_Box], _Filling]]] = {
    "casement": _casement,
    "grid": _grid,
    "sliding": _sliding,
    "fixed": _fixed,
}


def _wider(span: Span, by: float) -> Span:
    return (float(span[0] - by), float(span[1] + by))


def _sill_board(width: float, bottom: float, depth: float, wider: float) -> Mesh:
    """A board on the lower reveal, from the frame to a nose that is wider than the opening."""
    inside, beyond = 0.5 * width + EMBED, 0.5 * width + wider
    outline = np.array(
        [
            [-beyond, -NOSE],
            [beyond, -NOSE],
            [beyond, EMBED],
            [inside, EMBED],
            [inside, depth + EMBED],
            [-inside, depth + EMBED],
            [-inside, EMBED],
            [-beyond, EMBED],
        ]
    )
    return prism(outline, bottom - EMBED, bottom + BOARD)
