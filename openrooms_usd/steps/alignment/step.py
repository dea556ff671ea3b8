"""The alignment step: furniture as references to published assets, each at its place.

Objects that stand on another one, or are described relative to it, depend on it. Where an edit
moves an object from its described pose M to the pose M', its dependents move by M' M^-1. Objects on
it move in space, upright or not. Objects beside it move in the plan, on their own floor or wall.
Their sizes stay: a support that is scaled moves what it carries to the scaled places, without
scaling it.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from pxr import Kind, Sdf, Usd, Vt

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.description.furniture import (
    AlignedObject,
    CapturedFurniture,
    FileObject,
    LibraryObject,
    ObjectList,
    ScanFurniture,
    named_objects,
)
from openrooms_usd.description.generate import GeneratedFurniture
from openrooms_usd.description.mistakes import FieldsError, Steps
from openrooms_usd.description.room import Room
from openrooms_usd.errors import InputError
from openrooms_usd.furniture import CATEGORIES, Size, category, part_of
from openrooms_usd.geometry.rotations import nearest_rotation, pose
from openrooms_usd.library.assets import Asset, publish
from openrooms_usd.library.models.meshfile import dependencies
from openrooms_usd.portable import relative_text
from openrooms_usd.spelling import listed
from openrooms_usd.steps.alignment import aligned, placement, poses
from openrooms_usd.steps.alignment.apart import moved_apart
from openrooms_usd.steps.alignment.captured import Captured, captured_objects
from openrooms_usd.steps.alignment.catalogue import Catalogue, asked
from openrooms_usd.steps.alignment.surroundings import RoomGeometry, surroundings
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.captures import capture_inputs, capture_of
from openrooms_usd.threads import mapped
from openrooms_usd.untrusted import check_path
from openrooms_usd.usd.files.layers import is_off

ASSETS: Final = "assets"
_TYPES: Final = Sdf.ValueTypeNames

# A support with a smaller scale is degenerate.
_MIN_SCALE: Final = 1e-6
# How many names a note lists.
_MAX_LISTED_NAMES: Final = 5


@dataclass
class EditPropagation:
    """Moves what belongs to objects that were moved by hand.

    Attributes:
        stage: The composed stage; all objects stand there as they are described.
        room: What they stand in.
        placements: All objects by name.
        stands: Where they stand as described.
        notes: Receives a sentence for each object that nothing can follow.
    """

    stage: Usd.Stage
    room: RoomGeometry
    placements: Mapping[str, placement.Placement]
    stands: Mapping[str, placement.ResolvedPose]
    notes: list[str]
    _motions: dict[str, Array] = field(default_factory=dict)

    def propagate(self, by_hand: frozenset[str]) -> None:
        """Write the poses of all that follows.

        Args:
            by_hand: The objects that an edit transforms.

        Raises:
            InputError: Objects depend on each other in a circle.
        """
        parents = {
            name: stand.carrier or self.placements[name].relative_to
            for name, stand in self.stands.items()
        }
        with_others = set(parents.values())
        self._note_what_is_off(parents)
        layer = self.stage.GetEditTarget().GetLayer()
        for name in placement.parents_first(parents) if by_hand else ():
            followed = self._followed(name, parents[name])
            if followed is not None:
                poses.author_pose(layer.GetPrimAtPath(f"{names.FURNITURE}/{name}"), followed)
            if name in with_others:
                self._note_motion(name, followed, name in by_hand)

    def _note_motion(self, name: str, followed: Array | None, by_hand: bool) -> None:
        """Record the motion of an object from its described pose, if it has moved."""
        if followed is None and not by_hand:
            return
        prim = self._prim(name)
        if is_off(prim):
            return
        now = poses.composed_pose(prim) if by_hand or followed is None else followed
        if not np.isfinite(now).all() or abs(np.linalg.det(now[:3, :3])) < _MIN_SCALE**3:
            self.notes.append(f"{name} has a scale of zero: no object follows it")
            return
        motion = now @ np.linalg.inv(self._described(name))
        if not np.allclose(motion, np.eye(4), rtol=0.0, atol=1e-6):
            self._motions[name] = motion

    def _followed(self, name: str, parent: str | None) -> Array | None:
        """The pose of an object after its parent's motion; None where it stays."""
        motion = self._motions.get(parent) if parent else None
        if motion is None:
            return None
        described = self._described(name)
        gone = motion @ described
        turn = nearest_rotation(motion[:3, :3])
        if self.stands[name].carrier:
            return pose(turn @ described[:3, :3], gone[:3, 3])
        return self._beside(name, gone, turn)

    def _beside(self, name: str, gone: Array, turn: Array) -> Array:
        """A motion in the plan alone: the room still carries the object."""
        item, stand = self.placements[name], self.stands[name]
        heading = float(np.degrees(np.arctan2(turn[1, 0], turn[0, 0])))
        x, y = gone[:2, 3].tolist()
        yaw = stand.yaw + heading
        if item.on == placement.WALL:
            width, depth, _ = item.size
            hung = self.room.hang(x, y, width, depth)
            x, y, yaw = hung.x, hung.y, hung.yaw
        return poses.matrix_of(x, y, stand.z, yaw, stand.tilt)

    def _note_what_is_off(self, parents: Mapping[str, str | None]) -> None:
        children: defaultdict[str, list[str]] = defaultdict(list)
        for name, parent in parents.items():
            if parent is not None:
                children[parent].append(name)
        for parent, belonging in children.items():
            if is_off(self._prim(parent)):
                those = listed(belonging, _MAX_LISTED_NAMES)
                self.notes.append(f"{parent} is switched off: {those} stay as described")

    def _described(self, name: str) -> Array:
        """(4, 4) from an object's frame to the room, as it is described."""
        item, stand = self.placements[name], self.stands[name]
        upright = poses.matrix_of(stand.x, stand.y, stand.z, stand.yaw, stand.tilt)
        return upright if item.pose is None else item.pose

    def _prim(self, name: str) -> Usd.Prim:
        return self.stage.GetPrimAtPath(f"{names.FURNITURE}/{name}")


class AlignmentStep:
    """Writes ``/World/Furniture`` and everything below it."""

    name = "alignment"
    reads: tuple[str, ...] = ("layout",)

    def inputs(self, room: Room, source: Path) -> Iterable[str]:
        """The capture, the user's mesh files and all files that these refer to."""
        furniture = _explicit(room)
        captured: list[str] = []
        if isinstance(furniture, ScanFurniture):
            captured = _cad_files(furniture, source)
        elif isinstance(furniture, CapturedFurniture):
            captured = capture_inputs(furniture, source)
        files = [item.file for item in _described(furniture) if isinstance(item, FileObject)]
        return [
            *dict.fromkeys([*captured, *files]),
            *sorted(
                {
                    relative_text(path, source.resolve())
                    for file in dict.fromkeys(files)
                    for path in dependencies(source / file)
                }
            ),
        ]

    def author(self, context: StepContext) -> None:
        """Publish what is needed once, and place it.

        Raises:
            InputError: A file cannot be read, a style is unknown, or objects carry each other.
            OutputError: An asset cannot be written.
            StageError: Something hangs from a ceiling or a wall that the stage does not have.
        """
        room = surroundings(context.stage)
        placements = {item.name: item for item in _placements(context, room)}
        stands = placement.Supports(placements, room, context.notes).resolve()
        _publish(context, [item.asset for item in placements.values()])
        by_hand = poses.moved_by_hand(context.stage)
        _author_furniture(context, placements, stands)
        EditPropagation(context.stage, room, placements, stands, context.notes).propagate(by_hand)


def _explicit(room: Room) -> ObjectList | CapturedFurniture | ScanFurniture:
    assert not isinstance(room.furniture, GeneratedFurniture), "it is expanded before"
    return room.furniture


def _described(
    furniture: ObjectList | CapturedFurniture | ScanFurniture,
) -> tuple[AlignedObject, ...]:
    """The objects that the description lists one by one."""
    return furniture.further if isinstance(furniture, ScanFurniture) else furniture.objects


def _cad_files(furniture: ScanFurniture, source: Path) -> list[str]:
    """All files of all CADs; what was found in the scan is a file of the layout's."""
    if furniture.cad is None:
        return []
    check_path(source / furniture.cad)
    files = [path for path in (source / furniture.cad).rglob("*") if path.is_file()]
    return sorted(relative_text(path, source) for path in files)


def _placements(context: StepContext, room: RoomGeometry) -> Iterator[placement.Placement]:
    """Captured objects, then those of the description, each with its asset."""
    furniture, catalogue = _explicit(context.room), Catalogue(context)
    if isinstance(furniture, ScanFurniture):
        from openrooms_usd.steps.alignment.furnished import furnish

        yield from furnish(context, furniture, catalogue)
    elif isinstance(furniture, CapturedFurniture):
        capture = aligned.with_boxes(capture_of(context, furniture))
        models = {model.id: model for model in capture.models if model.file}
        captured = captured_objects(capture, room.floor, furniture.objects, context.notes)
        placed = [
            aligned.placed_model(context, catalogue, models[thing.box.id], thing, capture.source)
            if thing.box.id in models
            else _placed_capture(catalogue, thing, capture.source)
            for thing in captured
        ]
        yield from moved_apart(placed, room, context.notes)
    key = "further" if isinstance(furniture, ScanFurniture) else "objects"
    wrong: list[tuple[Steps, str]] = []
    for index, (name, item) in enumerate(named_objects(_described(furniture))):
        try:
            yield placement_of(catalogue, name, item)
        except InputError as error:
            place = f"{error.place}: " if error.place else ""
            remedy = f"; {error.remedy}" if error.remedy else ""
            wrong.append((("furniture", key, index), f"{name}: {place}{error.message}{remedy}"))
    if wrong:
        raise FieldsError(*wrong)


def _placed_capture(catalogue: Catalogue, thing: Captured, file: str) -> placement.Placement:
    (x, y, z), emits = thing.base, category(thing.category).emits
    asset = catalogue.furniture(thing.category, thing.size, label=thing.label)
    source = placement.CaptureSource(file, thing.box.id, thing.box.confidence, thing.box.label)
    height = None if thing.on_floor else z
    return placement.Placement(
        thing.name, asset, thing.size, x, y, height, thing.yaw, emits=emits, source=source
    )


def placement_of(
    catalogue: Catalogue, name: str, item: LibraryObject | FileObject
) -> placement.Placement:
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
        size, order = asked(item)
        asset = catalogue.furniture(item.category, size, item.style, order=order)
        emits = spec.emits
    x, y, *z = item.at
    on = item.on or (spec.support if spec else placement.FLOOR)
    return placement.Placement(
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
        level=spec.mount_height if spec else 0.0,
        tilt=item.tilt,
    )


def _publish(context: StepContext, assets: Iterable[Asset]) -> None:
    """Write every distinct asset; the order and the number of threads change nothing."""
    distinct = {asset.name: asset for asset in assets}
    folder = context.folder / ASSETS
    for _ in mapped(partial(publish, folder), distinct.values(), context.workers):
        pass
    for name in distinct:
        context.keep(f"{ASSETS}/{name}")


def _author_furniture(
    context: StepContext,
    placements: Mapping[str, placement.Placement],
    stands: Mapping[str, placement.ResolvedPose],
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
            # The lights step writes over the bulb, which it could not inside an instance.
            prim.instanceable = not item.emits
            stand = stands[name]
            if item.pose is None:
                poses.author_described(prim, stand.x, stand.y, stand.z, stand.yaw, stand.tilt)
            elif item.measured is None:
                aligned.author_shifted(prim, item.pose, item.shifts)
            else:
                aligned.author_aligned(prim, item.measured.pose, item.pose)
                aligned.author_measured(prim, item.measured)
            if item.source:
                _author_source(prim, item.source)


def _author_source(prim: Sdf.PrimSpec, source: placement.CaptureSource) -> None:
    aligned.apply_schema(prim, names.SOURCE_API)
    _set(prim, names.SOURCE_FILE, _TYPES.String, source.file)
    _set(prim, names.SOURCE_ID, _TYPES.String, source.id)
    if source.confidence:
        _set(prim, names.SOURCE_CONFIDENCE, _TYPES.Token, source.confidence)
    if source.word:
        aligned.apply_schema(prim, f"SemanticsLabelsAPI:{names.CAPTURED}")
        label = Sdf.AttributeSpec(
            prim, f"semantics:labels:{names.CAPTURED}", _TYPES.TokenArray, Sdf.VariabilityUniform
        )
        label.default = Vt.TokenArray([source.word])


def _set(prim: Sdf.PrimSpec, name: str, type_name: Sdf.ValueTypeName, value: object) -> None:
    attribute = Sdf.AttributeSpec(prim, name, type_name, declaresCustom=False)
    attribute.default = value
