"""What fills openings: frames with their casings, leaves and sashes, thresholds."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Kind, Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.building.doors import door, free_angle
from openrooms_usd.building.mouldings import moulding, section
from openrooms_usd.building.shell import cut_apart
from openrooms_usd.building.walls import Wall
from openrooms_usd.building.windows import BOARD, EMBED, NOSE, Window, bar, window
from openrooms_usd.description.trim import Casing
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.library.timber import follow_grain
from openrooms_usd.steps.layout.openings import Cut
from openrooms_usd.steps.layout.trim import REVEAL_M, Finish, has_board
from openrooms_usd.usd.places.frames import author_placement
from openrooms_usd.usd.semantics import label, label_part
from openrooms_usd.usd.shading.physics import author_joint
from openrooms_usd.usd.shapes.meshes import define_mesh

# How far a sill board reaches beyond casings, metres.
_BESIDE_CASING_M: Final = 0.02
# How far a door's leaf turns where nothing stops it, degrees.
_WIDE_OPEN_DEG: Final = 170.0

_TYPES = Sdf.ValueTypeNames


def set_value(prim: Usd.Prim, name: str, type_name: Sdf.ValueTypeName, value: object) -> None:
    """Author an attribute of a schema."""
    prim.CreateAttribute(name, type_name, custom=False).Set(value)


def wall_path(wall: Wall) -> str:
    """The prim of a wall."""
    return f"{names.WALLS}/{wall.name}"


def author_mesh(
    stage: Usd.Stage, path: str, mesh: Mesh, *, category: str = "", part: str = ""
) -> Usd.Prim:
    """Define a mesh with its labels."""
    mesh = follow_grain(part, mesh) if part else mesh
    prim = define_mesh(stage, path, mesh).GetPrim()
    if category:
        label(prim, category)
    if part:
        label_part(prim, part)
    return prim


def author_opening(
    stage: Usd.Stage, cut: Cut, walls: Sequence[Wall], finish: Finish, notes: list[str]
) -> None:
    """The opening's frame, its description for tools, and what fills it."""
    hole, path = cut.hole, f"{names.OPENINGS}/{cut.name}"
    # Nanometres are noise of subtracting.
    width, height = round(hole.right - hole.left, 9), round(hole.top - hole.bottom, 9)
    xform = UsdGeom.Xform.Define(stage, path)
    x, y = cut.wall.to_plan(np.array([0.5 * (hole.left + hole.right), 0.0]))
    heading = float(np.degrees(np.arctan2(cut.wall.along[1], cut.wall.along[0])))
    prim = xform.GetPrim()
    author_placement(prim, Gf.Vec3d(x, y, 0.5 * (hole.bottom + hole.top)), heading)
    Usd.ModelAPI(prim).SetKind(Kind.Tokens.subcomponent)
    label(prim, cut.kind)
    prim.AddAppliedSchema("OpenRoomsOpeningAPI")
    set_value(prim, "openrooms:opening:kind", _TYPES.Token, cut.kind)
    if cut.style:
        set_value(prim, names.OPENING_STYLE, _TYPES.Token, cut.style)
    set_value(prim, names.OPENING_WIDTH, _TYPES.Double, width)
    set_value(prim, names.OPENING_HEIGHT, _TYPES.Double, height)
    set_value(prim, "openrooms:opening:sill", _TYPES.Double, hole.bottom)
    wall = prim.CreateRelationship(names.OPENING_WALL, custom=False)
    wall.SetTargets([wall_path(cut.wall)])
    if cut.source:
        prim.AddAppliedSchema(names.SOURCE_API)
        set_value(prim, names.SOURCE_ID, _TYPES.String, cut.source.id)
        if cut.source.confidence:
            set_value(prim, names.SOURCE_CONFIDENCE, _TYPES.Token, cut.source.confidence)
    if cut.kind == "window":
        beyond = (
            max(NOSE, finish.trim.casing.width + _BESIDE_CASING_M) if finish.trim.casing else NOSE
        )
        made = window(
            width,
            height,
            cut.wall.thickness,
            board=has_board(cut),
            style=cut.style or "casement",
            beyond=beyond,
        )
        author_mesh(stage, f"{path}/Frame", made.frame, part="frame")
        _author_sashes(stage, made, path)
    elif cut.kind == "door":
        _author_door(stage, cut, walls, path, notes, cased=finish.trim.casing is None)
    if finish.trim.casing:
        author_mesh(stage, f"{path}/Casing", _casing(cut, finish.trim.casing), part="casing")
    if finish.trim.threshold and cut.kind != "window" and hole.bottom == 0.0:
        strip = _threshold(cut, finish.trim.threshold.height)
        author_mesh(stage, f"{path}/Threshold", strip, part="threshold")


def _casing(cut: Cut, described: Casing) -> Mesh:
    """Boards around an opening, in its frame: on both sides where both are in the room."""
    half, tall = 0.5 * (cut.hole.right - cut.hole.left), 0.5 * (cut.hole.top - cut.hole.bottom)
    x, top = half + REVEAL_M, tall + REVEAL_M
    stands = cut.hole.bottom == 0.0 or has_board(cut)
    foot = -tall + (BOARD - EMBED if has_board(cut) else 0.0 if stands else -REVEAL_M)
    path = np.array([[-x, foot], [-x, top], [x, top], [x, foot]])
    # From the opening outwards, the profile's foot first; its back is on the wall.
    shape = section(described.profile, described.depth, described.width)
    shape = np.stack([described.width - shape[:, 1], shape[:, 0]], axis=1)
    board = moulding(path, shape, closed=not stands)
    inside = board.transformed(np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]]))
    if not (cut.wall.partition or cut.kind == "door"):
        return inside
    other = np.array([[-1.0, 0, 0], [0, 0, 1.0], [0, 1.0, 0]])
    return joined([inside, board.transformed(other).moved((0.0, cut.wall.thickness, 0.0))])


def _threshold(cut: Cut, height: float) -> Mesh:
    """A strip across the floor of an opening, as deep as its wall."""
    half, tall = 0.5 * (cut.hole.right - cut.hole.left), 0.5 * (cut.hole.top - cut.hole.bottom)
    depth = (0.0, cut.wall.thickness)
    return bar((-half, half), depth, (-tall - EMBED, -tall + height), min(0.002, 0.4 * height))


def _author_door(
    stage: Usd.Stage, cut: Cut, walls: Sequence[Wall], path: str, notes: list[str], *, cased: bool
) -> None:
    hole = cut.hole
    made = door(
        hole.right - hole.left,
        hole.top - hole.bottom,
        cut.wall.thickness,
        hinge=cut.hinge,
        swing=cut.swing,
        style=cut.style or "panelled",
        cased=cased,
    )
    author_mesh(stage, f"{path}/Frame", made.frame, part="frame")
    around = _around(walls, cut)
    for number, leaf in enumerate(made.leaves):
        prim = UsdGeom.Xform.Define(stage, f"{path}/{names.leaf(number)}").GetPrim()
        # Where it can go at most, and where it stands.
        most = free_angle(leaf, max(cut.open, _WIDE_OPEN_DEG), around)
        angle = min(cut.open, most)
        if angle < cut.open:
            notes.append(f"{cut.name} opens {angle:g} degrees, not {cut.open:g}: a wall stops it")
        author_placement(prim, Gf.Vec3d(*leaf.hinge, 0.0), leaf.sense * angle)
        author_joint(prim, "hinge", (0.0, 0.0, leaf.sense), (0.0, most))
        author_mesh(stage, f"{prim.GetPath()}/Panel", leaf.panel, part="panel")
        author_mesh(stage, f"{prim.GetPath()}/Handle", leaf.handle, part="handle")
        if leaf.pane:
            author_mesh(stage, f"{prim.GetPath()}/Pane", leaf.pane, part="pane")


def _author_sashes(stage: Usd.Stage, made: Window, path: str) -> None:
    for number, sash in enumerate(made.sashes):
        prim = UsdGeom.Xform.Define(stage, f"{path}/Sash_{number}").GetPrim()
        author_placement(prim, Gf.Vec3d(*sash.origin), 0.0)
        author_joint(prim, sash.kind, sash.axis, (0.0, sash.upper))
        author_mesh(stage, f"{prim.GetPath()}/Bars", sash.mesh, part="sash")
        author_mesh(stage, f"{prim.GetPath()}/Pane", sash.pane, part="pane")
    for number, glass in enumerate(made.panes):
        author_mesh(stage, f"{path}/Pane_{number}", glass, part="pane")


def _around(walls: Sequence[Wall], cut: Cut) -> list[NDArray[np.float64]]:
    """What a leaf can run into: all walls, its own but for the hole, in the opening's x and y."""
    to_middle = np.array([0.5 * (cut.hole.left + cut.hole.right), 0.0])
    rings = []
    for wall in walls:
        pieces = cut_apart(wall, [cut.hole]) if wall is cut.wall else [wall.outline]
        rings += [cut.wall.from_plan(wall.to_plan(piece)) - to_middle for piece in pieces]
    return rings
