"""The layout stage: floor, ceiling, walls with real holes, and what fills these holes."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, Vt

from openrooms_usd import names
from openrooms_usd.capture import Capture, CapturedPartition
from openrooms_usd.description.layout import CapturedLayout, PolygonLayout, ScanLayout
from openrooms_usd.description.room import Room
from openrooms_usd.errors import DescriptionError, InputError
from openrooms_usd.geometry.curves import signed_area
from openrooms_usd.geometry.doors import door, free_angle
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.polygons import counter_clockwise, defect
from openrooms_usd.geometry.shell import cut_apart, slab, wall_solid
from openrooms_usd.geometry.walls import Wall, walls_of
from openrooms_usd.geometry.windows import Window, window
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.captures import capture_inputs, capture_of
from openrooms_usd.stages.openings import Cut, captured_cuts, described_cuts
from openrooms_usd.stages.partitions import (
    author_partition,
    captured_partitions,
    described_partitions,
    walls_within,
)
from openrooms_usd.stages.reports import keep_overlay, keep_report
from openrooms_usd.usd.frames import gf_matrix
from openrooms_usd.usd.joints import author_joint
from openrooms_usd.usd.meshes import define_mesh
from openrooms_usd.usd.semantics import label, label_part
from openrooms_usd.usd.transforms import author_placement

# Windows that begin lower than this have no sill board, metres.
_BOARD_FROM = 0.3
# How far a door's leaf turns where nothing stops it, degrees.
_WIDE_OPEN = 170.0

_TYPES = Sdf.ValueTypeNames


@dataclass(frozen=True, eq=False)
class Plan:
    """A room's shell before it is built.

    Attributes:
        corners: (N, 2) the floor, counter-clockwise, metres.
        walls: Those of the outline by ascending number, then those that stand free.
        height: Floor to ceiling, metres.
        thickness: Of the walls and slabs, metres.
        cuts: The openings.
        capture: What it is made from, if anything.
        sources: The captured partitions by the names of their walls.
    """

    corners: NDArray[np.float64]
    walls: tuple[Wall, ...]
    height: float
    thickness: float
    cuts: tuple[Cut, ...]
    capture: Capture | None = None
    sources: Mapping[str, CapturedPartition] = field(default_factory=dict)


class LayoutStage:
    """Writes ``/World`` and ``/World/Room`` with everything below it."""

    name = "layout"
    reads: tuple[str, ...] = ()

    def inputs(self, room: Room, source: Path) -> Iterable[str]:
        """The capture, if the room is made from one."""
        layout = room.layout
        return capture_inputs(layout, source) if isinstance(layout, CapturedLayout) else []

    def author(self, context: StageContext) -> None:
        """Write the room's shell.

        Raises:
            DescriptionError: The polygon is not simple, or an opening does not fit.
            InputError: The capture cannot be read, or has no usable floor.
        """
        layout, stage = context.room.layout, context.stage
        if isinstance(layout, CapturedLayout):
            plan = captured_plan(layout, context)
        else:
            assert isinstance(layout, PolygonLayout), "generated sections are expanded before"
            plan = described_plan(layout, context.notes)
        _author_room(stage, plan, context.room.room)
        _author_shell(stage, plan)
        for cut in plan.cuts:
            _author_opening(stage, plan, cut, context.notes)


def described_plan(layout: PolygonLayout, notes: list[str]) -> Plan:
    """The plan of a room that is drawn by hand."""
    if reason := defect(layout.polygon):
        raise DescriptionError(
            f"the polygon {reason}",
            place="layout.polygon",
            remedy="list the inner corners once, in order around the room, at least 1 mm apart",
        )
    corners, numbers = counter_clockwise(layout.polygon)
    walls = walls_of(corners, numbers, layout.wall_thickness)
    partitions = described_partitions(layout.partitions, corners, layout.height)
    walls += walls_within(partitions, corners, notes)
    clockwise = signed_area(np.asarray(layout.polygon)) < 0.0
    cuts = described_cuts(layout.openings, walls, layout.height, clockwise=clockwise)
    return Plan(corners, walls, layout.height, layout.wall_thickness, tuple(cuts))


def captured_plan(layout: CapturedLayout, context: StageContext) -> Plan:
    """The plan of a captured room."""
    capture = _capture(layout, context)
    context.notes.extend(capture.notes)
    place = context.source / layout.file
    if capture.floor is None:
        raise InputError(
            "the capture has no floor and no walls that close", place=place, remedy=capture.remedy
        )
    if reason := defect(capture.floor):
        raise InputError(f"the captured floor {reason}", place=place, remedy="scan the room again")
    height = layout.height or capture.height
    if height is None:
        height = names.ROOM_HEIGHT
        context.notes.append(f"the capture has no height: {height} m is taken")
    corners, numbers = counter_clockwise(capture.floor)
    found = captured_partitions(
        capture.partitions, corners, height, described=layout.partitions, notes=context.notes
    )
    sources = {one.name: source for source, one in found}
    partitions = [one for _, one in found]
    partitions += described_partitions(layout.partitions, corners, height)
    walls = walls_of(corners, numbers, layout.wall_thickness)
    walls += walls_within(partitions, corners, context.notes)
    cuts = captured_cuts(
        capture.openings,
        walls,
        height,
        described=layout.openings,
        notes=context.notes,
        partitions={row.id: name for name, row in sources.items()},
    )
    cuts += described_cuts(layout.openings, walls, height, before=cuts)
    return Plan(corners, walls, height, layout.wall_thickness, tuple(cuts), capture, sources)


def _capture(layout: CapturedLayout, context: StageContext) -> Capture:
    """What an importer read; of a scan what was found in it, with a report beside the layer."""
    if not isinstance(layout, ScanLayout):
        return capture_of(context, layout)
    # What finds rooms in points takes a second to import.
    from openrooms_usd.scan.reconstruction import layout_report
    from openrooms_usd.stages.scanned import scanned_room

    scanned = scanned_room(context, layout)
    keep_report(context, layout_report(scanned.layout, scanned.scan_from_level))
    keep_overlay(context, scanned.layout)
    return scanned.capture


def _author_room(stage: Usd.Stage, plan: Plan, room_type: str) -> None:
    world = UsdGeom.Xform.Define(stage, names.WORLD).GetPrim()
    Usd.ModelAPI(world).SetKind(Kind.Tokens.assembly)
    room = UsdGeom.Xform.Define(stage, names.ROOM).GetPrim()
    Usd.ModelAPI(room).SetKind(Kind.Tokens.component)
    room.AddAppliedSchema("OpenRoomsRoomAPI")
    _set(room, "openrooms:room:type", _TYPES.Token, room_type)
    _set(room, "openrooms:room:height", _TYPES.Double, plan.height)
    floor = Vt.Vec2dArray.FromNumpy(np.ascontiguousarray(plan.corners))
    _set(room, names.ROOM_FLOOR, _TYPES.Double2Array, floor)
    if plan.capture:
        room.AddAppliedSchema(names.SOURCE_API)
        _set(room, names.SOURCE_FILE, _TYPES.String, plan.capture.source)
        matrix = gf_matrix(plan.capture.source_from_world)
        _set(room, names.SOURCE_FROM_WORLD, _TYPES.Matrix4d, matrix)


def _set(prim: Usd.Prim, name: str, type_name: Sdf.ValueTypeName, value: object) -> None:
    prim.CreateAttribute(name, type_name, custom=False).Set(value)


def _author_shell(stage: Usd.Stage, plan: Plan) -> None:
    below = slab(plan.corners, plan.thickness, -plan.thickness, 0.0)
    above = slab(plan.corners, plan.thickness, plan.height, plan.height + plan.thickness)
    _author_mesh(stage, names.FLOOR, below, category="floor")
    _author_mesh(stage, names.CEILING, above, category="ceiling")
    UsdGeom.Xform.Define(stage, names.WALLS)
    for wall in plan.walls:
        holes = [cut.hole for cut in plan.cuts if cut.wall is wall]
        top = wall.top(plan.height)
        prim = _author_mesh(stage, _wall_path(wall), wall_solid(wall, top, holes), category="wall")
        if wall.partition:
            author_partition(prim, wall, top, plan.sources.get(wall.partition))
    if plan.cuts:
        UsdGeom.Xform.Define(stage, names.OPENINGS)


def _wall_path(wall: Wall) -> str:
    return f"{names.WALLS}/{wall.name}"


def _author_mesh(
    stage: Usd.Stage, path: str, mesh: Mesh, *, category: str = "", part: str = ""
) -> Usd.Prim:
    prim = define_mesh(stage, path, mesh).GetPrim()
    if category:
        label(prim, category)
    if part:
        label_part(prim, part)
    return prim


def _author_opening(stage: Usd.Stage, plan: Plan, cut: Cut, notes: list[str]) -> None:
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
    _set(prim, "openrooms:opening:kind", _TYPES.Token, cut.kind)
    if cut.style:
        _set(prim, names.OPENING_STYLE, _TYPES.Token, cut.style)
    _set(prim, names.OPENING_WIDTH, _TYPES.Double, width)
    _set(prim, names.OPENING_HEIGHT, _TYPES.Double, height)
    _set(prim, "openrooms:opening:sill", _TYPES.Double, hole.bottom)
    wall = prim.CreateRelationship(names.OPENING_WALL, custom=False)
    wall.SetTargets([_wall_path(cut.wall)])
    if cut.source:
        prim.AddAppliedSchema(names.SOURCE_API)
        _set(prim, names.SOURCE_ID, _TYPES.String, cut.source.id)
        if cut.source.confidence:
            _set(prim, names.SOURCE_CONFIDENCE, _TYPES.Token, cut.source.confidence)
    if cut.kind == "window":
        board = hole.bottom >= _BOARD_FROM
        made = window(width, height, cut.wall.thickness, board=board, style=cut.style or "casement")
        _author_mesh(stage, f"{path}/Frame", made.frame, part="frame")
        _author_sashes(stage, made, path)
    elif cut.kind == "door":
        _author_door(stage, plan, cut, path, notes)


def _author_door(stage: Usd.Stage, plan: Plan, cut: Cut, path: str, notes: list[str]) -> None:
    hole = cut.hole
    made = door(
        hole.right - hole.left,
        hole.top - hole.bottom,
        cut.wall.thickness,
        hinge=cut.hinge,
        swing=cut.swing,
        style=cut.style or "panelled",
    )
    _author_mesh(stage, f"{path}/Frame", made.frame, part="frame")
    around = _around(plan, cut)
    for number, leaf in enumerate(made.leaves):
        prim = UsdGeom.Xform.Define(stage, f"{path}/{names.leaf(number)}").GetPrim()
        # Where it can go at most, and where it stands.
        most = free_angle(leaf, max(cut.open, _WIDE_OPEN), around)
        angle = min(cut.open, most)
        if angle < cut.open:
            notes.append(f"{cut.name} opens {angle:g} degrees, not {cut.open:g}: it meets a wall")
        author_placement(prim, Gf.Vec3d(*leaf.hinge, 0.0), leaf.sense * angle)
        author_joint(prim, "hinge", (0.0, 0.0, leaf.sense), (0.0, most))
        _author_mesh(stage, f"{prim.GetPath()}/Panel", leaf.panel, part="panel")
        _author_mesh(stage, f"{prim.GetPath()}/Handle", leaf.handle, part="handle")


def _author_sashes(stage: Usd.Stage, made: Window, path: str) -> None:
    for number, sash in enumerate(made.sashes):
        prim = UsdGeom.Xform.Define(stage, f"{path}/Sash_{number}").GetPrim()
        author_placement(prim, Gf.Vec3d(*sash.origin), 0.0)
        author_joint(prim, sash.kind, sash.axis, (0.0, sash.upper))
        _author_mesh(stage, f"{prim.GetPath()}/Bars", sash.mesh, part="sash")


def _around(plan: Plan, cut: Cut) -> list[NDArray[np.float64]]:
    """What a leaf can run into: all walls, its own but for the hole, in the opening's x and y."""
    to_middle = np.array([0.5 * (cut.hole.left + cut.hole.right), 0.0])
    rings = []
    for wall in plan.walls:
        pieces = cut_apart(wall, [cut.hole]) if wall is cut.wall else [wall.outline]
        rings += [cut.wall.from_plan(wall.to_plan(piece)) - to_middle for piece in pieces]
    return rings
