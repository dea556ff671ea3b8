"""How a generated room is finished: trim, ceiling, tiles, and walls that differ."""

from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.building.ceilings import Axis, across, strips
from openrooms_usd.description.layout import PolygonLayout
from openrooms_usd.description.styles import InteriorStyle
from openrooms_usd.description.trim import Ceiling, Trim
from openrooms_usd.draws import generator
from openrooms_usd.generation.boxes import NONE, box
from openrooms_usd.generation.shell import Shell
from openrooms_usd.library.styles.assignment.weights import drawn
from openrooms_usd.library.styles.interiors import INTERIORS, PLAIN, ShellStyle

# Skirting and rails stand out less than the gap between furniture and walls, metres.
_DEPTH_M: Final = 0.014
_CASING_DEPTH_M: Final = 0.015
# Tiles on walls: what hangs on these is flush to the wall, and may sink in by so much, metres.
_TILES_M: Final = 0.004
# Rooms of work, of stores, and such as are tiled.
_WORK: Final = frozenset(
    {"bookstore", "classroom", "computer_cluster", "conference_room", "copy_room", "lobby",
     "mail_room", "office"}
)  # fmt: skip
_STORES: Final = frozenset({"basement", "garage", "storage"})
_WET: Final = frozenset({"bathroom"})
_PANELLED: Final = frozenset({"dining_room", "hallway", "library", "stairs"})
# Where a beam would be in the way of what reaches up to the ceiling.
_UNDER_PLAIN: Final = frozenset({"bathroom", "closet", "laundry_room", "stairs"})
_GRID_SHARE: Final = 0.6
# Beams and cornices stay above this; a rail needs this much wall above openings, metres.
_HEADROOM_M: Final = 2.15
_ABOVE_OPENINGS_M: Final = 0.25
_BELOW_SILL_M: Final = 0.03
_LOW_SILL_M: Final = 0.6
# Heights of tiles in wet rooms with their shares; None: up to the ceiling, metres.
_TILED: Final = (((1.15, 1.35), 0.4), ((2.0, 2.15), 0.25), (None, 0.35))


@dataclass(frozen=True)
class Finishing:
    """What a room's shell wears.

    Attributes:
        trim: The section ``layout.trim``; empty for none.
        ceiling: The section ``layout.ceiling``; empty for a plain one.
        tiles: Height of the tiles on all walls, metres; None where only the walls' own material
            says what they are.
        wooden: Whether boards are wood.
        accent: Whether one wall differs.
    """

    trim: dict[str, Any] = field(default_factory=dict)
    ceiling: dict[str, Any] = field(default_factory=dict)
    tiles: float | None = None
    wooden: bool = False
    accent: bool = False

    @property
    def layout(self) -> dict[str, Any]:
        """Its keys of the layout section."""
        rows: dict[str, Any] = {"trim": self.trim} if self.trim else {}
        if self.ceiling:
            rows["ceiling"] = self.ceiling
        if self.tiles is not None:
            rows["cladding"] = [{"name": "tiles", "top": self.tiles, "depth": _TILES_M}]
        return rows


def shell_style(style: InteriorStyle | None) -> ShellStyle:
    """How rooms of a style are finished; those without one plainly."""
    return INTERIORS[style].shell if style else PLAIN


def finishing(room_type: str, seed: int, shell: Shell, style: InteriorStyle | None) -> Finishing:
    """Draw how a room is finished; its seed, its type and its height decide."""
    rng = generator(seed, "generate", room_type, "finishing")
    taste = shell_style(style)
    tiles = _tiles(rng, shell) if room_type in _WET else None
    ceiling = _ceiling(rng, room_type, shell, taste)
    plain = room_type in _WORK | _STORES
    trim = _trim(rng, room_type, shell, PLAIN if plain else taste, bool(ceiling))
    if tiles is not None or room_type in _WET:
        trim = {key: trim[key] for key in ("casing", "threshold") if key in trim}
    return Finishing(
        trim,
        ceiling,
        tiles,
        bool(rng.random() < taste.wood) and not plain,
        bool(rng.random() < taste.accent) and room_type not in _WET | _STORES,
    )


def _tiles(rng: np.random.Generator, shell: Shell) -> float | None:
    """To which height a wet room is tiled."""
    heights = [row[0] for row in _TILED]
    drawn_row = heights[int(rng.choice(len(heights), p=[share for _, share in _TILED]))]
    if drawn_row is None:
        return None
    return round(min(float(rng.uniform(*drawn_row)), shell.height - 0.2), 2)


def _ceiling(
    rng: np.random.Generator, room_type: str, shell: Shell, taste: ShellStyle
) -> dict[str, Any]:
    if room_type in _STORES | _UNDER_PLAIN:
        return {}
    if room_type in _WORK:
        return {"kind": "grid"} if rng.random() < _GRID_SHARE else {}
    kind = drawn(rng, taste.ceilings)
    deep = round(min(float(rng.uniform(0.12, 0.2)), shell.height - _HEADROOM_M - 0.05), 2)
    if kind == "plain" or deep < 0.08:
        return {}
    if kind == "coffers":
        spacing = round(float(rng.uniform(1.0, 1.5)), 2)
        return {"kind": kind, "spacing": spacing, "width": 0.12, "depth": min(deep, 0.1)}
    width, spacing = (round(float(rng.uniform(*ends)), 2) for ends in ((0.1, 0.18), (0.8, 1.3)))
    return {"kind": kind, "spacing": spacing, "width": width, "depth": deep}


def _trim(
    rng: np.random.Generator, room_type: str, shell: Shell, taste: ShellStyle, beamed: bool
) -> dict[str, Any]:
    profile = drawn(rng, taste.profiles)
    height, width, size = (
        round(float(rng.uniform(*ends)), 2)
        for ends in (taste.skirting, taste.casing, taste.cornice)
    )
    cornice, cased = drawn(rng, taste.cornices), rng.random() < 0.85
    railed, panelled = (float(rng.random()) for _ in range(2))
    if room_type in _STORES:
        return {"threshold": True} if cased else {}
    trim: dict[str, Any] = {"skirting": {"height": height, "depth": _DEPTH_M, "profile": profile}}
    if cornice != "none" and not beamed and shell.height - size > _HEADROOM_M:
        trim["cornice"] = {"height": size, "depth": size, "profile": cornice}
    trim["casing"] = {"width": width, "depth": _CASING_DEPTH_M, "profile": profile}
    lintel = max((gap.top for gap in shell.gaps), default=2.1)
    rail = round(max(2.05, lintel + _ABOVE_OPENINGS_M), 2)
    if railed < taste.picture_rail and rail + 0.3 < shell.height:
        trim["picture_rail"] = {"at": rail, "depth": _DEPTH_M}
    if panelled < taste.wainscot and room_type in _PANELLED:
        # Below sill boards it runs on.
        sills = [gap.sill - _BELOW_SILL_M for gap in shell.gaps if gap.sill > _LOW_SILL_M]
        trim["wainscot"] = {"height": round(min([0.9, *sills]), 2)}
    trim["threshold"] = True
    return trim


def _along_walls(shell: Shell, trim: Trim) -> Array:
    """(K, 8) what is fixed along the walls, as boxes."""
    rows: list[tuple[float, float, float]] = []  # depth, low, high
    if trim.skirting:
        rows.append((trim.skirting.depth, 0.0, trim.skirting.height))
    if trim.cornice:
        rows.append((trim.cornice.depth, shell.height - trim.cornice.height, shell.height))
    if rail := trim.picture_rail:
        rows.append((rail.depth, rail.at, rail.at + rail.height))
    if trim.wainscot:
        rows.append((trim.wainscot.depth + 0.002, 0.0, trim.wainscot.height))
    found = [
        side.keep(0.5 * side.length, side.length, depth, low, high)
        for depth, low, high in rows
        for side in shell.sides
    ]
    return np.array(found) if found else NONE


def _beams(shell: Shell, ceiling: Ceiling) -> Array:
    """(B, 8) what hangs below the ceiling; the bars of a grid are thinner than what matters."""
    if ceiling.kind in ("plain", "grid"):
        return NONE
    spacing, width, depth = ceiling.sizes
    low, high = shell.corners.min(axis=0), shell.corners.max(axis=0)
    middle, size = 0.5 * (low + high), high - low
    along = ceiling.along or across(shell.corners)
    found: list[Array] = []
    axes: tuple[Axis, ...] = ("x", "y") if ceiling.kind == "coffers" else (along,)
    for axis in axes:
        for a, b in strips(shell.corners, axis, spacing, width):
            x, y = (middle[0], 0.5 * (a + b)) if axis == "x" else (0.5 * (a + b), middle[1])
            wide, deep = (size[0], b - a) if axis == "x" else (b - a, size[1])
            found.append(box(x, y, wide, deep, shell.height - depth, shell.height))
    return np.array(found) if found else NONE


def finished(shell: Shell, finish: Finishing | PolygonLayout) -> Shell:
    """The room with what is fixed in it."""
    if isinstance(finish, PolygonLayout):
        trim, ceiling = finish.trim, finish.ceiling
    else:
        trim = Trim.model_validate(finish.trim)
        ceiling = Ceiling.model_validate(finish.ceiling)
    casing = trim.casing.width if trim.casing else 0.0
    return shell.with_fixed(_along_walls(shell, trim), _beams(shell, ceiling), casing)
