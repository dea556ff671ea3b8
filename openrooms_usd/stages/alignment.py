"""The alignment stage: furniture as references to published assets, each at its place."""

import os
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Final

from pxr import Kind, Sdf, Vt

from openrooms_usd import names
from openrooms_usd.categories.record import given
from openrooms_usd.description.alignment import (
    AlignedObject,
    CapturedAlignment,
    FileObject,
    LibraryObject,
    ObjectList,
    ScanAlignment,
    named_objects,
)
from openrooms_usd.description.generate import GeneratedAlignment
from openrooms_usd.description.layout import ScanLayout
from openrooms_usd.description.room import Room
from openrooms_usd.errors import InputError
from openrooms_usd.library.assets import Asset, publish
from openrooms_usd.library.furniture import CATEGORIES, Order, Size, category, part_of
from openrooms_usd.library.meshfile import dependencies
from openrooms_usd.stages.aligned import (
    apply_schema,
    author_aligned,
    author_measured,
    author_shifted,
    placed_model,
    with_boxes,
)
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.captured import Captured, captured_objects
from openrooms_usd.stages.captures import capture_inputs, capture_of
from openrooms_usd.stages.catalogue import Catalogue
from openrooms_usd.stages.following import Following
from openrooms_usd.stages.placement import FLOOR, Placement, Source, Stand, Supports
from openrooms_usd.stages.poses import author_described, moved_by_hand
from openrooms_usd.stages.surroundings import surroundings
from openrooms_usd.untrusted import check_path

ASSETS: Final = "assets"
_TYPES: Final = Sdf.ValueTypeNames


class AlignmentStage:
    """Writes ``/World/Furniture`` and everything below it."""

    name = "alignment"
    reads: tuple[str, ...] = ("layout",)

    def inputs(self, room: Room, source: Path) -> Iterable[str]:
        """The capture, the user's mesh files and all files that these refer to."""
        alignment = _explicit(room)
        captured: list[str] = []
        if isinstance(alignment, ScanAlignment):
            captured = _scanned_inputs(alignment, room, source)
        elif isinstance(alignment, CapturedAlignment):
            captured = capture_inputs(alignment, source)
        files = [item.file for item in _described(alignment) if isinstance(item, FileObject)]
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
            StageError: Something hangs from a ceiling or a wall that the stage does not have.
        """
        room = surroundings(context.stage)
        placements = {item.name: item for item in _placements(context, room.floor)}
        stands = Supports(placements, room, context.notes).stands()
        _publish(context, [item.asset for item in placements.values()])
        by_hand = moved_by_hand(context.stage)
        _author_furniture(context, placements, stands)
        Following(context.stage, room, placements, stands, context.notes).author(by_hand)


def _explicit(room: Room) -> ObjectList | CapturedAlignment | ScanAlignment:
    assert not isinstance(room.alignment, GeneratedAlignment), "it is expanded before"
    return room.alignment


def _described(
    alignment: ObjectList | CapturedAlignment | ScanAlignment,
) -> tuple[AlignedObject, ...]:
    """The objects that the description lists one by one."""
    return alignment.further if isinstance(alignment, ScanAlignment) else alignment.objects


def _scanned_inputs(alignment: ScanAlignment, room: Room, source: Path) -> list[str]:
    """The scan, and all files of all CADs."""
    layout = room.layout
    scan = capture_inputs(layout, source) if isinstance(layout, ScanLayout) else []
    if alignment.cad is None:
        return scan
    check_path(source / alignment.cad)
    files = [path for path in (source / alignment.cad).rglob("*") if path.is_file()]
    return [*scan, *sorted(os.path.relpath(path, source) for path in files)]


def _placements(context: StageContext, floor: float) -> Iterator[Placement]:
    """Captured objects, then those of the description, each with its asset."""
    alignment, catalogue = _explicit(context.room), Catalogue(context)
    if isinstance(alignment, ScanAlignment):
        from openrooms_usd.stages.furnished import furnish

        yield from furnish(context, alignment, catalogue)
    elif isinstance(alignment, CapturedAlignment):
        capture = with_boxes(capture_of(context, alignment))
        models = {model.id: model for model in capture.models if model.file}
        for thing in captured_objects(capture, floor, alignment.objects, context.notes):
            if (model := models.get(thing.box.id)) is not None:
                yield placed_model(context, catalogue, model, thing, capture.source)
            else:
                yield _placed_capture(catalogue, thing, capture.source)
    for name, item in named_objects(_described(alignment)):
        try:
            yield placement_of(catalogue, name, item)
        except InputError as error:
            error.place = error.place or f"alignment.objects, {name}"
            raise


def _placed_capture(catalogue: Catalogue, thing: Captured, file: str) -> Placement:
    (x, y, z), emits = thing.base, category(thing.category).emits
    asset = catalogue.furniture(thing.category, thing.size, label=thing.label)
    source = Source(file, thing.box.id, thing.box.confidence, thing.box.label)
    height = None if thing.on_floor else z
    return Placement(
        thing.name, asset, thing.size, x, y, height, thing.yaw, emits=emits, source=source
    )


def placement_of(catalogue: Catalogue, name: str, item: LibraryObject | FileObject) -> Placement:
    """An object of a description with its asset, before anything carries it.

    Raises:
        InputError: Its file cannot be read, or there is no such style.
    """
    spec = CATEGORIES.get(item.category)
    if isinstance(item, FileObject):
        asset = catalogue.file(item)
        model = asset.build()
        width, depth, height = (model.extent[1] - model.extent[0]).tolist()
        size: Size = (width, depth, height)
        emits = any(part_of(part) == names.LIGHT_BULB for part in model.parts)
    else:
        spec = category(item.category)
        style = spec.styles.get(item.style or "")
        size = item.size or (style and style.size) or spec.size
        order = Order(item.fronts, item.cutouts)
        asset = catalogue.furniture(item.category, size, item.style, order=order)
        emits = spec.emits
    x, y, *z = item.at
    on = item.on or (spec.support if spec else FLOOR)
    return Placement(
        name,
        asset,
        size,
        x,
        y,
        z[0] if z else None,
        item.yaw,
        on,
        emits,
        relative_to=item.relative_to,
        level=given(spec.level, 0.0) if spec else 0.0,
        tilt=item.tilt,
    )


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
    context: StageContext, placements: Mapping[str, Placement], stands: Mapping[str, Stand]
) -> None:
    """Define the prims, on the layer itself: thousands of them in one change."""
    layer = context.stage.GetEditTarget().GetLayer()
    with Sdf.ChangeBlock():
        group = Sdf.CreatePrimInLayer(layer, names.FURNITURE)
        group.specifier, group.typeName = Sdf.SpecifierDef, "Xform"
        group.SetInfo("kind", Kind.Tokens.group)
        for name, item in placements.items():
            prim = Sdf.PrimSpec(group, item.name, Sdf.SpecifierDef, "Xform")
            prim.SetInfo("kind", Kind.Tokens.component)
            path = context.asset(f"{ASSETS}/{item.asset.file}")
            prim.referenceList.Prepend(Sdf.Reference(path))
            # The lights stage writes over the bulb, which it could not inside an instance.
            prim.instanceable = not item.emits
            stand = stands[name]
            if item.pose is None:
                author_described(prim, stand.x, stand.y, stand.z, stand.yaw, stand.tilt)
            elif item.measured is None:
                author_shifted(prim, item.pose, item.shifts)
            else:
                author_aligned(prim, item.measured.pose, item.pose)
                author_measured(prim, item.measured)
            if item.source:
                _author_source(prim, item.source)


def _author_source(prim: Sdf.PrimSpec, source: Source) -> None:
    apply_schema(prim, names.SOURCE_API)
    _set(prim, names.SOURCE_FILE, _TYPES.String, source.file)
    _set(prim, names.SOURCE_ID, _TYPES.String, source.id)
    if source.confidence:
        _set(prim, names.SOURCE_CONFIDENCE, _TYPES.Token, source.confidence)
    if source.word:
        apply_schema(prim, f"SemanticsLabelsAPI:{names.CAPTURED}")
        label = Sdf.AttributeSpec(
            prim, f"semantics:labels:{names.CAPTURED}", _TYPES.TokenArray, Sdf.VariabilityUniform
        )
        label.default = Vt.TokenArray([source.word])


def _set(prim: Sdf.PrimSpec, name: str, type_name: Sdf.ValueTypeName, value: object) -> None:
    attribute = Sdf.AttributeSpec(prim, name, type_name, declaresCustom=False)
    attribute.default = value
