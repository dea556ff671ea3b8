"""The layout step: floor, ceiling, walls with real holes, and what fills these holes."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import Kind, Sdf, Usd, UsdGeom, Vt

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.building.partitions import Partition, misplaced, partition_walls
from openrooms_usd.building.roofs import ceiling_solid, crowned
from openrooms_usd.building.shell import slab, wall_solid
from openrooms_usd.building.walls import Wall, walls_of
from openrooms_usd.capture import Capture, CapturedPartition
from openrooms_usd.description import layout
from openrooms_usd.description.layout import (
    CapturedLayout,
    PolygonLayout,
    ScanLayout,
    named_partitions,
)
from openrooms_usd.description.mistakes import FieldsError
from openrooms_usd.description.naming import captured_names
from openrooms_usd.description.room import Room
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.curves import signed_area
from openrooms_usd.geometry.polygons import counter_clockwise, defect
from openrooms_usd.geometry.uv import centred
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.captures import capture_inputs, capture_of, capture_path
from openrooms_usd.steps.layout.beyond import author_beyond
from openrooms_usd.steps.layout.joinery import author_mesh, author_opening, set_value, wall_path
from openrooms_usd.steps.layout.openings import Cut, captured_cuts, described_cuts
from openrooms_usd.steps.layout.trim import Built, Finish, trim_meshes
from openrooms_usd.steps.reports import keep_overlay, keep_report
from openrooms_usd.usd.places.frames import gf_matrix

_TYPES = Sdf.ValueTypeNames

# Captured partitions whose top is nearer to the ceiling than this reach it, metres.
_TO_THE_CEILING_M: Final = 0.15


@dataclass(frozen=True, eq=False)
class Plan:
    """A room's shell before it is built.

    Attributes:
        corners: (N, 2) the floor, counter-clockwise, metres.
        walls: Those of the outline by ascending number, then those that stand free.
        height: Floor to ceiling, metres; at its highest where walls have crowns.
        thickness: Of the walls and slabs, metres.
        cuts: The openings.
        capture: What it is made from, if anything.
        sources: The captured partitions by the names of their walls.
        finish: What runs along the walls and hangs below the ceiling.
        clockwise: Whether the polygon was given clockwise.
    """

    corners: NDArray[np.float64]
    walls: tuple[Wall, ...]
    height: float
    thickness: float
    cuts: tuple[Cut, ...]
    capture: Capture | None = None
    sources: Mapping[str, CapturedPartition] = field(default_factory=dict)
    finish: Finish = field(default_factory=Finish)
    clockwise: bool = False


class LayoutStep:
    """Writes ``/World`` and ``/World/Room`` with everything below it."""

    name = "layout"
    reads: tuple[str, ...] = ()

    def inputs(self, room: Room, source: Path) -> Iterable[str]:
        """The capture, if the room is made from one."""
        layout = room.layout
        return capture_inputs(layout, source) if isinstance(layout, CapturedLayout) else []

    def author(self, context: StepContext) -> None:
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
            author_opening(stage, cut, plan.walls, plan.finish, context.notes)
        author_beyond(context, plan.corners, plan.cuts)


def described_plan(layout: PolygonLayout, notes: list[str]) -> Plan:
    """The plan of a room that is drawn by hand."""
    return _drawn_plan(layout, layout.polygon, layout.height, notes)


def captured_plan(layout: CapturedLayout, context: StepContext) -> Plan:
    """The plan of a captured room."""
    capture = _capture(layout, context)
    context.notes.extend(capture.notes)
    return plan_of(layout, capture, context.source, context.notes)


def plan_of(layout: CapturedLayout, capture: Capture, folder: Path, notes: list[str]) -> Plan:
    """The plan of a captured room, as it was captured or as a person drew it over that.

    Args:
        layout: The section of a description.
        capture: What was read; of a scan what was found in it.
        folder: That of the description, for messages.
        notes: Receives a sentence for everything that was changed or guessed.

    Raises:
        DescriptionError: What is described does not fit.
        InputError: The capture has no usable floor.
    """
    height = layout.height or capture.height
    if height is None:
        height = names.ROOM_HEIGHT
        notes.append(f"the capture has no height: {height} m is assumed")
    if layout.polygon is not None:
        if capture.roof is not None and layout.height is None:
            notes.append(f"the walls are drawn: their ceiling is level, at {height:.2f} m")
        return replace(_drawn_plan(layout, layout.polygon, height, notes), capture=capture)
    place = folder / layout.file
    if capture.floor is None:
        raise InputError(
            "the capture has no floor and no walls that close", place=place, remedy=capture.remedy
        )
    if reason := defect(capture.floor):
        raise InputError(f"the captured floor {reason}", place=place, remedy="scan the room again")
    corners, numbers = counter_clockwise(capture.floor)
    found = captured_partitions(
        capture.partitions, corners, height, described=layout.partitions, notes=notes
    )
    sources = {one.name: source for source, one in found}
    partitions = [one for _, one in found]
    partitions += described_partitions(layout.partitions, corners, height)
    walls, finish = walls_of(corners, numbers, layout.wall_thickness), _finish(layout)
    if capture.roof is not None and layout.height is None:
        walls, finish = crowned(walls, capture.roof), finish.below_slopes(notes)
    walls += walls_within(partitions, corners, notes)
    cuts = captured_cuts(
        capture.openings,
        walls,
        height,
        described=layout.openings,
        notes=notes,
        partitions={row.id: name for name, row in sources.items()},
    )
    cuts += described_cuts(layout.openings, walls, height, before=cuts)
    return Plan(
        corners, walls, height, layout.wall_thickness, tuple(cuts), capture, sources, finish
    )


def _drawn_plan(
    layout: PolygonLayout | CapturedLayout,
    polygon: Sequence[tuple[float, float]],
    height: float,
    notes: list[str],
) -> Plan:
    """The plan of a room whose corners a person gave."""
    if reason := defect(polygon):
        remedy = "list the inner corners once, in order around the room, at least 1 mm apart"
        raise FieldsError((("layout", "polygon"), f"the polygon {reason}; {remedy}"))
    corners, numbers = counter_clockwise(polygon)
    walls = walls_of(corners, numbers, layout.wall_thickness)
    clockwise = signed_area(np.asarray(polygon)) < 0.0
    try:
        partitions = described_partitions(layout.partitions, corners, height)
    except FieldsError as error:
        _check_outline(layout, walls, height, clockwise, error)
        raise
    notes += [
        f"{name}: {row.height:g} m is higher than the room; it ends at the ceiling"
        for name, row in named_partitions(layout.partitions)
        if row.height is not None and row.height > height
    ]
    walls += walls_within(partitions, corners, notes)
    cuts = described_cuts(layout.openings, walls, height, clockwise=clockwise)
    return Plan(
        corners,
        walls,
        height,
        layout.wall_thickness,
        tuple(cuts),
        finish=_finish(layout),
        clockwise=clockwise,
    )


def _check_outline(
    layout: PolygonLayout | CapturedLayout,
    walls: Sequence[Wall],
    height: float,
    clockwise: bool,
    error: FieldsError,
) -> None:
    """Say what is wrong with openings of the outline together with an error of partitions."""
    try:
        described_cuts(layout.openings, walls, height, clockwise=clockwise)
    except FieldsError as other:
        # Partitions are not there yet: what is said of their openings is not true.
        own = [row for row in other.found if layout.openings[int(row[0][2])].partition is None]
        raise FieldsError(*error.found, *own) from None


def _finish(layout: PolygonLayout | CapturedLayout) -> Finish:
    return Finish(layout.trim, layout.ceiling, layout.cladding)


def _capture(layout: CapturedLayout, context: StepContext) -> Capture:
    """What an importer read; of a scan what was found in it, which is kept beside the layer."""
    if not isinstance(layout, ScanLayout):
        return capture_of(context, layout)
    # What finds rooms in points takes a second to import.
    from openrooms_usd.scan.reconstruction import layout_report
    from openrooms_usd.steps.layout.scanned import keep_found, scanned

    room = scanned(layout, capture_path(context, layout), context.source)
    keep_found(context, room.found())
    keep_report(context, layout_report(room.layout, room.scan_from_level))
    keep_overlay(context, room.layout.cloud, room.layout.rooms)
    return room.capture


def _author_room(stage: Usd.Stage, plan: Plan, room_type: str) -> None:
    world = UsdGeom.Xform.Define(stage, names.WORLD).GetPrim()
    Usd.ModelAPI(world).SetKind(Kind.Tokens.assembly)
    room = UsdGeom.Xform.Define(stage, names.ROOM).GetPrim()
    Usd.ModelAPI(room).SetKind(Kind.Tokens.component)
    room.AddAppliedSchema("OpenRoomsRoomAPI")
    set_value(room, "openrooms:room:type", _TYPES.Token, room_type)
    set_value(room, "openrooms:room:height", _TYPES.Double, plan.height)
    floor = Vt.Vec2dArray.FromNumpy(np.ascontiguousarray(plan.corners))
    set_value(room, names.ROOM_FLOOR, _TYPES.Double2Array, floor)
    if plan.capture:
        room.AddAppliedSchema(names.SOURCE_API)
        set_value(room, names.SOURCE_FILE, _TYPES.String, plan.capture.source)
        matrix = gf_matrix(plan.capture.source_from_world)
        set_value(room, names.SOURCE_FROM_WORLD, _TYPES.Matrix4d, matrix)


def _author_shell(stage: Usd.Stage, plan: Plan) -> None:
    below = slab(plan.corners, plan.thickness, -plan.thickness, 0.0)
    above = ceiling_solid(plan.walls, plan.corners, plan.height, plan.thickness)
    author_mesh(stage, names.FLOOR, centred(below), category="floor")
    author_mesh(stage, names.CEILING, above, category="ceiling")
    UsdGeom.Xform.Define(stage, names.WALLS)
    for wall in plan.walls:
        holes = [cut.hole for cut in plan.cuts if cut.wall is wall]
        top = wall.top(plan.height)
        prim = author_mesh(stage, wall_path(wall), wall_solid(wall, top, holes), category="wall")
        if wall.partition:
            author_partition(prim, wall, top, plan.sources.get(wall.partition))
    if plan.cuts:
        UsdGeom.Xform.Define(stage, names.OPENINGS)
    built = Built(plan.corners, plan.walls, plan.height, plan.cuts, plan.clockwise)
    for name, category, mesh in trim_meshes(built, plan.finish):
        UsdGeom.Scope.Define(stage, names.TRIM)
        if "/" in name:
            UsdGeom.Scope.Define(stage, f"{names.TRIM}/{name.partition('/')[0]}")
        if category == "cladding":
            mesh = centred(mesh, along=False)
        author_mesh(stage, f"{names.TRIM}/{name}", mesh, category=category)


def described_partitions(
    described: Sequence[layout.Partition], corners: Array, height: float
) -> list[Partition]:
    """The partitions of a description.

    Args:
        described: As they are described.
        corners: (N, 2) the room's polygon, metres.
        height: Floor to ceiling, metres.

    Raises:
        DescriptionError: Some do not stand in the room.
    """
    made = [
        Partition(name, np.array(row.line), row.thickness, _below(row.height, height))
        for name, row in named_partitions(described)
    ]
    mistakes = [
        (("layout", "partitions", index, "line"), f"{one.name} {reason}")
        for index, one in enumerate(made)
        if (reason := misplaced(one, corners)) is not None
    ]
    if mistakes:
        raise FieldsError(*mistakes)
    return made


def captured_partitions(
    captured: Sequence[CapturedPartition],
    corners: Array,
    height: float,
    *,
    described: Sequence[layout.Partition],
    notes: list[str],
) -> list[tuple[CapturedPartition, Partition]]:
    """The partitions of a capture that stand in the room, each with its source.

    Args:
        captured: As they were captured.
        corners: (N, 2) the room's polygon, metres.
        height: Floor to ceiling, metres.
        described: The partitions of the description, whose names stay theirs.
        notes: Receives a sentence for each that is left out.
    """
    taken = {name for name, _ in named_partitions(described)}
    made = []
    for name, source in zip(
        captured_names([("partition", row.id) for row in captured], taken), captured, strict=True
    ):
        thickness = source.thickness or names.PARTITION_THICKNESS
        one = Partition(name, source.ends, thickness, _below(source.height, height))
        if reason := misplaced(one, corners):
            notes.append(f"dropped the inner wall {source.id}: it {reason}")
        else:
            made.append((source, one))
    return made


def _below(height: float | None, ceiling: float) -> float | None:
    """A height that ends below the ceiling, or None."""
    return None if height is None or height > ceiling - _TO_THE_CEILING_M else height


def walls_within(
    partitions: Sequence[Partition], corners: Array, notes: list[str]
) -> tuple[Wall, ...]:
    """The partitions as walls, with a note for what is too short to be built."""
    walls = partition_walls(partitions, corners)
    built = {wall.partition for wall in walls}
    notes += [
        f"left out {one.name}: it has no length left between the walls it ends at"
        for one in partitions
        if one.name not in built
    ]
    return walls


def author_partition(
    prim: Usd.Prim, wall: Wall, height: float, source: CapturedPartition | None
) -> None:
    """Say of a wall's prim that it stands free, and where it was captured.

    Args:
        prim: The wall's mesh.
        wall: The wall.
        height: What it reaches up to, metres.
        source: What it is made from, if anything.
    """
    kinds = Sdf.ValueTypeNames
    outline = np.ascontiguousarray(wall.to_plan(wall.outline))
    prim.AddAppliedSchema(names.PARTITION_API)
    _set(prim, names.PARTITION_OUTLINE, kinds.Double2Array, Vt.Vec2dArray.FromNumpy(outline))
    _set(prim, names.PARTITION_HEIGHT, kinds.Double, height)
    if source:
        prim.AddAppliedSchema(names.SOURCE_API)
        _set(prim, names.SOURCE_ID, kinds.String, source.id)
        if source.confidence:
            _set(prim, names.SOURCE_CONFIDENCE, kinds.Token, source.confidence)


def _set(prim: Usd.Prim, name: str, kind: Sdf.ValueTypeName, value: object) -> None:
    prim.CreateAttribute(name, kind, custom=False).Set(value)
