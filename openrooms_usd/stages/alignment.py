"""The alignment stage: furniture as references to published assets, each at its place."""

import os
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Final

from pxr import Gf, Kind, Sdf, Usd, UsdGeom, Vt

from openrooms_usd import adapters, names
from openrooms_usd.capture import Capture
from openrooms_usd.description.alignment import (
    FileObject,
    LibraryObject,
    RoomPlanAlignment,
    named_objects,
)
from openrooms_usd.description.room import Room
from openrooms_usd.errors import InputError
from openrooms_usd.library.assets import Asset, publish
from openrooms_usd.library.furniture import CATEGORIES, Size, category, part_of
from openrooms_usd.library.meshfile import dependencies
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.captured import Captured, captured_objects
from openrooms_usd.stages.catalogue import Catalogue
from openrooms_usd.stages.placement import FLOOR, Placement, Source, Supports

ASSETS: Final = "assets"
_TYPES: Final = Sdf.ValueTypeNames


class AlignmentStage:
    """Writes ``/World/Furniture`` and everything below it."""

    name = "alignment"
    reads: tuple[str, ...] = ("layout",)

    def inputs(self, room: Room, source: Path) -> Iterable[str]:
        """The capture, the user's mesh files and all files that these refer to."""
        alignment = room.alignment
        files = [item.file for item in alignment.objects if isinstance(item, FileObject)]
        captured = [alignment.file] if isinstance(alignment, RoomPlanAlignment) else []
        return [
            *dict.fromkeys([*captured, *files]),
            *sorted(
                {
                    os.path.relpath(path, source.resolve())
                    for file in dict.fromkeys(files)
                    for path in dependencies(source / file)
                }
            ),
        ]

    def author(self, context: StageContext) -> None:
        """Publish what is needed once, and place it.

        Raises:
            InputError: A file cannot be read, a style is unknown, or objects carry each other.
            OutputError: An asset cannot be written.
            StageError: Something hangs from a ceiling that the stage does not have.
        """
        floor, ceiling = _levels(context.stage)
        placements = list(_placements(context, floor))
        supports = Supports({item.name: item for item in placements}, floor, ceiling, context.notes)
        heights = [supports.height(item.name) for item in placements]
        _publish(context, [item.asset for item in placements])
        _author_furniture(context, placements, heights)


def _levels(stage: Usd.Stage) -> tuple[float, float | None]:
    """Height of the floor and of the ceiling, metres; no ceiling in a room without one."""
    boxes = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_])
    floor, ceiling = (stage.GetPrimAtPath(path) for path in (names.FLOOR, names.CEILING))
    lower = boxes.ComputeWorldBound(floor).ComputeAlignedRange() if floor else Gf.Range3d()
    upper = boxes.ComputeWorldBound(ceiling).ComputeAlignedRange() if ceiling else Gf.Range3d()
    return (
        0.0 if lower.IsEmpty() else lower.GetMax()[2],
        None if upper.IsEmpty() else upper.GetMin()[2],
    )


def _placements(context: StageContext, floor: float) -> Iterator[Placement]:
    """Captured objects, then those of the description, each with its asset."""
    alignment, catalogue = context.room.alignment, Catalogue(context)
    labels: list[str] = []
    if isinstance(alignment, RoomPlanAlignment):
        capture = _capture(context, alignment)
        for thing in captured_objects(capture, floor, alignment.objects, context.notes):
            labels.append(thing.substitute.label)
            yield _placed_capture(catalogue, thing, capture.source)
    for name, item in named_objects(alignment.objects, labels):
        try:
            yield _placed(catalogue, name, item)
        except InputError as error:
            error.place = error.place or f"alignment.objects, {name}"
            raise


def _capture(context: StageContext, alignment: RoomPlanAlignment) -> Capture:
    path = context.input(alignment.file)
    capture: Capture = adapters.load(adapters.IMPORTERS, "roomplan").read(path)
    return capture


def _placed_capture(catalogue: Catalogue, thing: Captured, file: str) -> Placement:
    substitute, (x, y, z) = thing.substitute, thing.base
    asset = catalogue.furniture(substitute.category, thing.size, label=substitute.label)
    source = Source(file, thing.box.id, thing.box.confidence)
    height = None if thing.on_floor else z
    return Placement(thing.name, asset, thing.size, x, y, height, thing.yaw, source=source)


def _placed(catalogue: Catalogue, name: str, item: LibraryObject | FileObject) -> Placement:
    spec = CATEGORIES.get(item.category)
    if isinstance(item, FileObject):
        asset = catalogue.file(item)
        model = asset.build()
        width, depth, height = (model.extent[1] - model.extent[0]).tolist()
        size: Size = (width, depth, height)
        emits = any(part_of(part) == names.LIGHT_BULB for part in model.parts)
    else:
        spec = category(item.category)
        usual = spec.styles[item.style].size if item.style in spec.styles else None
        size = item.size or usual or spec.size
        asset = catalogue.furniture(item.category, size, item.style)
        emits = spec.emits
    x, y, *z = item.at
    on = item.on or (spec.support if spec else FLOOR)
    return Placement(name, asset, size, x, y, z[0] if z else None, item.yaw, on, emits)


def _publish(context: StageContext, assets: Iterable[Asset]) -> None:
    """Write every distinct asset; the order and the number of threads change nothing."""
    distinct = {asset.name: asset for asset in assets}
    folder = context.folder / ASSETS
    with ThreadPoolExecutor(max(1, context.workers)) as pool:
        for _ in pool.map(partial(publish, folder), distinct.values()):
            pass
    for name in distinct:
        context.keep(f"{ASSETS}/{name}")


def _author_furniture(
    context: StageContext, placements: Sequence[Placement], heights: Sequence[float]
) -> None:
    """Define the prims, on the layer itself: thousands of them in one change."""
    layer = context.stage.GetEditTarget().GetLayer()
    with Sdf.ChangeBlock():
        group = Sdf.CreatePrimInLayer(layer, names.FURNITURE)
        group.specifier, group.typeName = Sdf.SpecifierDef, "Xform"
        group.SetInfo("kind", Kind.Tokens.group)
        for item, height in zip(placements, heights, strict=True):
            prim = Sdf.PrimSpec(group, item.name, Sdf.SpecifierDef, "Xform")
            prim.SetInfo("kind", Kind.Tokens.component)
            path = context.asset(f"{ASSETS}/{item.asset.file}")
            prim.referenceList.Prepend(Sdf.Reference(path))
            # The lights stage writes over the bulb, which it could not inside an instance.
            prim.instanceable = not item.emits
            _author_pose(prim, item, height)
            if item.source:
                _author_source(prim, item.source)


def _author_pose(prim: Sdf.PrimSpec, item: Placement, height: float) -> None:
    operations = ["xformOp:translate"]
    _set(prim, operations[0], _TYPES.Double3, Gf.Vec3d(item.x, item.y, height))
    if item.yaw:
        operations.append("xformOp:rotateZ")
        _set(prim, operations[1], _TYPES.Double, item.yaw)
    order = Sdf.AttributeSpec(
        prim, "xformOpOrder", _TYPES.TokenArray, Sdf.VariabilityUniform, declaresCustom=False
    )
    order.default = Vt.TokenArray(operations)


def _author_source(prim: Sdf.PrimSpec, source: Source) -> None:
    schemas = Sdf.TokenListOp()
    schemas.prependedItems = [names.SOURCE_API]
    prim.SetInfo("apiSchemas", schemas)
    _set(prim, names.SOURCE_FILE, _TYPES.String, source.file)
    _set(prim, names.SOURCE_ID, _TYPES.String, source.id)
    if source.confidence:
        _set(prim, names.SOURCE_CONFIDENCE, _TYPES.Token, source.confidence)


def _set(prim: Sdf.PrimSpec, name: str, type_name: Sdf.ValueTypeName, value: object) -> None:
    attribute = Sdf.AttributeSpec(prim, name, type_name, declaresCustom=False)
    attribute.default = value
