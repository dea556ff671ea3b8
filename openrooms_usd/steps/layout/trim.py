"""What runs along the walls and hangs below the ceiling, as the layout describes it.

::

    /World/Room/Trim            Scope
        Skirting                Mesh, like Cornice, PictureRail, Wainscot and Beams
        cladding_0              Scope: a Mesh for each wall
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.building.ceilings import across, bars
from openrooms_usd.building.claddings import cladding
from openrooms_usd.building.mouldings import moulding, panelling, section
from openrooms_usd.building.shell import Hole
from openrooms_usd.building.wallruns import Run, free_rings, runs
from openrooms_usd.building.walls import Wall
from openrooms_usd.building.windows import EMBED
from openrooms_usd.description.naming import unique_names
from openrooms_usd.description.trim import Ceiling, Cladding, Trim
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.steps.layout.openings import Cut

# How far a door's own casing reaches beyond its opening, metres.
_DOOR_CASING_M: Final = 0.06
# Windows that begin lower than this have no sill board, metres.
_BOARD_FROM_M: Final = 0.3
# From the edge of an opening outwards to that of its casing, which covers the reveal's, metres.
REVEAL_M: Final = -0.001


@dataclass(frozen=True)
class Finish:
    """What a described layout says of its walls' and its ceiling's geometry.

    Attributes:
        trim: Along the walls.
        ceiling: Below the ceiling.
        claddings: On parts of the walls.
    """

    trim: Trim = field(default_factory=Trim)
    ceiling: Ceiling = field(default_factory=Ceiling)
    claddings: Sequence[Cladding] = ()

    @property
    def beside(self) -> float:
        """How far casings reach beyond doors, metres."""
        return self.trim.casing.width + REVEAL_M if self.trim.casing else _DOOR_CASING_M

    def below_slopes(self, notes: list[str]) -> "Finish":
        """What of it a room has whose ceiling is not level; a sentence tells the rest."""
        beams = self.ceiling.kind != "plain"
        left_out = [*["the cornice"] * (self.trim.cornice is not None), *["the beams"] * beams]
        if left_out:
            both = " and ".join(left_out)
            notes.append(f"left out {both}: the ceiling slopes; `height` makes it level")
        return replace(self, trim=self.trim.model_copy(update={"cornice": None}), ceiling=Ceiling())


@dataclass(frozen=True, eq=False)
class Built:
    """The shell that is finished.

    Attributes:
        corners: (N, 2) the floor, counter-clockwise, metres.
        walls: Those of the outline, then those that stand free.
        height: Floor to ceiling, metres.
        cuts: The openings.
        clockwise: Whether the polygon was given clockwise.
    """

    corners: Array
    walls: Sequence[Wall]
    height: float
    cuts: Sequence[Cut]
    clockwise: bool = False


def trim_meshes(built: Built, finish: Finish) -> Iterator[tuple[str, str, Mesh]]:
    """The name, the category and the mesh of everything that is there."""
    trim = finish.trim
    if board := trim.skirting:
        shape = section(board.profile, board.depth, board.height)
        found = _runs(built, finish, 0.0, board.height, board.depth)
        yield from _swept("Skirting", "skirting", found, shape, 0.0)
    if piece := trim.cornice:
        shape = section(piece.profile, piece.depth, piece.height) * [1.0, -1.0]
        found = _runs(built, finish, built.height - piece.height, built.height, piece.depth)
        yield from _swept("Cornice", "cornice", found, shape, built.height)
    if rail := trim.picture_rail:
        shape = section(rail.profile, rail.depth, rail.height)
        found = _runs(built, finish, rail.at, rail.at + rail.height, rail.depth)
        yield from _swept("PictureRail", "picture_rail", found, shape, rail.at)
    if boards := trim.wainscot:
        found = _runs(built, finish, 0.0, boards.height, boards.depth)
        parts = [panelling(run, boards.height, boards.depth) for run in found]
        if parts:
            yield "Wainscot", "wainscot", joined(parts)
    if finish.ceiling.kind != "plain":
        yield from _beams(built, finish.ceiling)
    for name, one in named_claddings(finish.claddings):
        for wall, mesh in _cladding(built, finish, one):
            yield f"{name}/{wall}", "cladding", mesh


def named_claddings(claddings: Sequence[Cladding]) -> list[tuple[str, Cladding]]:
    """Every cladding with its name: its own, or a number."""
    names = unique_names((one.name, "cladding") for one in claddings)
    return list(zip(names, claddings, strict=True))


def _swept(
    name: str, category: str, found: Sequence[Run], shape: Array, base: float
) -> Iterator[tuple[str, str, Mesh]]:
    if found:
        meshes = [moulding(run.path, shape, closed=run.closed) for run in found]
        yield name, category, joined(meshes).moved((0.0, 0.0, base))


def _runs(built: Built, finish: Finish, low: float, high: float, depth: float) -> list[Run]:
    """Where walls run on between two heights."""
    standing = [
        wall.to_plan(wall.outline)
        for wall in built.walls
        if wall.partition and wall.top(built.height) >= high
    ]
    rings = free_rings(built.corners, standing)
    gaps = [gap for cut in built.cuts for gap in _gaps(cut, finish, low, high)]
    return runs(rings, gaps, depth)


def _gaps(cut: Cut, finish: Finish, low: float, high: float) -> Iterator[tuple[Array, Array]]:
    """The ends of an opening with its casings on the faces of its wall, if it is in the way."""
    hole, beyond = with_casing(cut, finish), cut.wall.thickness
    if hole.bottom < high and hole.top > low:
        for y in (0.0, beyond) if cut.wall.partition else (0.0,):
            ends = cut.wall.to_plan(np.array([[hole.left, y], [hole.right, y]]))
            yield ends[0], ends[1]


def has_board(cut: Cut) -> bool:
    """Whether an opening has a sill board."""
    return cut.kind == "window" and cut.hole.bottom >= _BOARD_FROM_M


def with_casing(cut: Cut, finish: Finish) -> Hole:
    """The hole of an opening, grown by what stands around it on the wall."""
    cased = cut.kind == "door" or finish.trim.casing is not None
    margin = finish.beside if cased else 0.0
    below = 0.0 if cut.hole.bottom == 0.0 else margin
    if has_board(cut):
        below = EMBED
    return Hole(
        cut.hole.left - margin,
        cut.hole.right + margin,
        max(cut.hole.bottom - below, 0.0),
        cut.hole.top + margin,
    )


def _beams(built: Built, ceiling: Ceiling) -> Iterator[tuple[str, str, Mesh]]:
    spacing, width, depth = ceiling.sizes
    mesh = bars(
        built.corners,
        built.height,
        spacing=spacing,
        width=width,
        depth=depth,
        along=ceiling.along or across(built.corners),
        crossed=ceiling.kind != "beams",
    )
    if mesh is not None:
        yield "Beams", "ceiling_grid" if ceiling.kind == "grid" else "beam", mesh


def _cladding(built: Built, finish: Finish, one: Cladding) -> Iterator[tuple[str, Mesh]]:
    outline = [wall for wall in built.walls if not wall.partition]
    chosen = outline if one.walls is None else [w for w in outline if w.number in one.walls]
    top = built.height if one.top is None else min(one.top, built.height)
    for wall in chosen:
        # Described from the wall's start; walls run to the right, seen from inside.
        low, high = one.span or (0.0, wall.length)
        if one.span and not built.clockwise:
            low, high = wall.length - high, wall.length - low
        holes = [with_casing(cut, finish) for cut in built.cuts if cut.wall is wall]
        ends = _turns(built.corners, wall) if one.span is None else (0.0, 0.0)
        pieces = cladding(wall, (low, high), (one.bottom, top), one.depth, holes, ends)
        if pieces:
            yield wall.name, joined(pieces)


def _turns(corners: Array, wall: Wall) -> tuple[float, float]:
    """The tangents of half the angles by which the room turns at a wall's two ends."""
    found: Mapping[bool, float] = {
        left: _half_tangent(corners, wall.left if left else wall.right) for left in (True, False)
    }
    return found[True], found[False]


def _half_tangent(corners: Array, corner: Array) -> float:
    i = int(np.argmin(np.linalg.norm(corners - corner, axis=1)))
    a, b = corners[i] - corners[i - 1], corners[(i + 1) % len(corners)] - corners[i]
    angle = float(np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b))
    return float(np.tan(0.5 * np.clip(angle, -2.0, 2.0)))
