"""The furniture of a scan: CADs at the poses that were measured, and where they were placed."""

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.categories.record import UNLABELED
from openrooms_usd.description.alignment import FileObject, ScanAlignment, named_objects
from openrooms_usd.description.layout import ScanLayout
from openrooms_usd.description.naming import captured_names
from openrooms_usd.description.scanned import ScannedObject
from openrooms_usd.errors import InputError
from openrooms_usd.library.assets import Asset, Model
from openrooms_usd.library.cads import Cad, folder_cads, furniture_cads, merged
from openrooms_usd.library.furniture import CATEGORIES, MAX_SIDE, MIN_SIDE, category
from openrooms_usd.names import SHELL
from openrooms_usd.scan.models.cad import CadModel, Up
from openrooms_usd.scan.placement.correcting import correction, moved_by
from openrooms_usd.scan.reconstruction import FoundFurniture, find_furniture, furniture_report
from openrooms_usd.scan.registration.hints import Box, Hint
from openrooms_usd.scan.results import FoundObject, Pose
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.catalogue import Catalogue
from openrooms_usd.stages.placement import Measured, Placement, Source
from openrooms_usd.stages.reports import keep_overlay, keep_report
from openrooms_usd.stages.scanned import ScannedRoom, captured_hints, scanned_room
from openrooms_usd.stages.substitutes import plain, substitute
from openrooms_usd.usd.taxonomies import NYU40, class_of, classes

Array = NDArray[np.float64]

# Objects that placement moved by more than this are counted in a note, metres.
_COUNTED_MOTION_M: Final = 0.01


def furnish(
    context: StageContext, alignment: ScanAlignment, catalogue: Catalogue
) -> Iterator[Placement]:
    """The objects of a scan, each with its asset; a report of them is kept beside the layer.

    Raises:
        InputError: The layout is not found in a scan, or a CAD cannot be read.
    """
    layout = context.room.layout
    if not isinstance(layout, ScanLayout):
        raise InputError(
            "furniture is found in the scan of the layout, and there is none",
            place="alignment",
            remedy="give `layout: {from: scan, scan: FILE}` too",
        )
    scanned = scanned_room(context, layout)
    shelf = _Shelf(context, alignment, scanned)
    found = find_furniture(
        scanned.layout,
        shelf.models,
        shelf.hints(alignment.objects),
        shelf.categories,
        context.workers,
        context.progress,
    )
    keep_report(context, furniture_report(found, scanned.scan_from_level))
    bounds = {model.id: model.extent for model in shelf.models}
    keep_overlay(context, scanned.layout, found.objects, bounds)
    context.notes.extend(_told(found))
    labels = [(plain(thing.category or "object"), str(thing.instance)) for thing in found.objects]
    taken = {name for name, _ in named_objects(alignment.further)}
    names = captured_names(labels, taken)
    by_instance = {str(o.instance): name for o, name in zip(found.objects, names, strict=True)}
    for name, thing in zip(names, found.objects, strict=True):
        yield shelf.placement(catalogue, name, thing, by_instance.get(thing.support))


def _told(found: FoundFurniture) -> Iterator[str]:
    yield from found.notes
    moved = {thing.instance: moved_by(thing)["metres"] for thing in found.objects}
    far = [instance for instance, metres in moved.items() if metres > _COUNTED_MOTION_M]
    if far:
        most = max(far, key=moved.__getitem__)
        text = f"{len(far)} of {len(moved)} objects were moved to where they can be"
        yield f"{text}, instance {most} the farthest: {moved[most]:.3f} m"
    for rejected in found.rejected:
        yield f"instance {rejected.instance} has no CAD: {rejected.reason}"
    yield from (str(unresolved) for unresolved in found.unresolved)


@dataclass(eq=False)
class _Shelf:
    """The CADs that may be taken."""

    context: StageContext
    alignment: ScanAlignment
    scanned: ScannedRoom

    @cached_property
    def cads(self) -> dict[str, Cad]:
        if self.alignment.cad is not None:
            found = folder_cads(self.context.source / self.alignment.cad)
        else:
            found = furniture_cads(tuple(sorted(self._wanted())))
        return {cad.id: cad for cad in found}

    @cached_property
    def built(self) -> dict[str, Model]:
        return {name: cad.model() for name, cad in self.cads.items()}

    @cached_property
    def models(self) -> list[CadModel]:
        """In the CADs' own frames: those of their files."""
        made = []
        for name, cad in self.cads.items():
            vertices, faces = merged(self.built[name], self.built[name].file_from_object)
            made.append(CadModel(name, cad.category, vertices, faces, cad.symmetry, _up(cad)))
        return made

    @cached_property
    def categories(self) -> dict[int, tuple[str, ...]]:
        """The categories of CADs that a class of NYU40 may mean."""
        known = {cad.category for cad in self.cads.values()}
        return {
            number: tuple(sorted(kind for kind in known if _means(kind, name)))
            for number, name in enumerate(NYU40)
            if name not in (UNLABELED, *SHELL)
        }

    def _wanted(self) -> set[str]:
        """Those of the library's categories that the scan may show."""
        hints = self.hints(self.alignment.objects) or ()
        hinted = {hint.category for hint in hints} - {None}
        cloud = self.scanned.layout.cloud
        if cloud.label is not None:
            labels = {NYU40[n] for n in np.unique(cloud.label).tolist() if n < len(NYU40)}
            hinted |= {name for name in CATEGORIES if class_of(name, "nyu40") in labels}
        kinds = {substitute(str(word), {}, 0.0) for word in hinted}
        return {kind for kind in kinds if kind and kind in CATEGORIES and kind not in SHELL}

    def hints(self, objects: Iterable[ScannedObject] | None) -> list[Hint] | None:
        """What the description knows, in the level frame."""
        if objects is None:
            return captured_hints(self.scanned)
        level_from_scan: Array = np.linalg.inv(self.scanned.scan_from_level).astype(np.float64)
        return [_hint(thing, level_from_scan) for thing in objects]

    def placement(
        self, catalogue: Catalogue, name: str, thing: FoundObject, carrier: str | None
    ) -> Placement:
        """An object where it was placed, with where it was measured and what it stands on."""
        cad, built = self.cads[thing.cad], self.built[thing.cad]
        measured = thing.pose.matrix @ built.file_from_object
        asset, emits = self._asset(catalogue, cad, thing, measured)
        if cad.file is None:
            # The library builds it at the size that was found.
            measured = measured / np.append(np.linalg.norm(measured[:3, :3], axis=0), 1.0)
        pose = correction(thing) @ measured
        x, y, z = pose[:3, 3].tolist()
        extent = asset.build().extent
        width, depth, height = (
            np.linalg.norm(pose[:3, :3], axis=0) * np.ptp(extent, axis=0)
        ).tolist()
        yaw = float(np.degrees(np.arctan2(pose[1, 0], pose[0, 0])))
        source = Source(self.scanned.capture.source, str(thing.instance))
        return Placement(
            name, asset, (width, depth, height), x, y, z, yaw, emits=emits, source=source,
            pose=pose, measured=Measured(
                measured, thing.residual, thing.coverage, thing.symmetry,
                "object" if carrier else thing.support, carrier,
            ),
        )  # fmt: skip

    def _asset(
        self, catalogue: Catalogue, cad: Cad, thing: FoundObject, measured: Array
    ) -> tuple[Asset, bool]:
        if cad.file is None:
            extent = self.built[cad.id].extent
            scale = np.linalg.norm(measured[:3, :3], axis=0)
            size = np.clip(np.round(scale * np.ptp(extent, axis=0), 3), MIN_SIDE, MAX_SIDE)
            width, depth, height = size.tolist()
            made = catalogue.furniture(cad.category, (width, depth, height), cad.style)
            return made, category(cad.category).emits
        file = os.path.relpath(cad.file.resolve(), self.context.source.resolve())
        item = FileObject(
            **{"from": "file"}, category=plain(thing.category or "object"), at=(0.0, 0.0),
            file=file, up=cad.up, front=cad.front, unit=1.0,
        )  # fmt: skip
        return catalogue.file(item), False


def _means(kind: str, name: str) -> bool:
    """Whether a category of a CAD is one of a class of NYU40."""
    ours = kind if kind in classes() else substitute(kind, {}, 0.0) or kind
    return class_of(ours, "nyu40") == name


def _up(cad: Cad) -> Up | None:
    """A CAD's vertical; None where nobody says it: OBJ and PLY files stand either way."""
    if cad.file is None:
        return "Z"
    return cad.up or ("Y" if cad.file.suffix.lower() == ".glb" else None)


def _hint(thing: ScannedObject, level_from_scan: Array) -> Hint:
    pose = box = None
    if thing.pose:
        given = Pose(
            np.array(thing.pose.translation), _unit(thing.pose.rotation_wxyz),
            np.array(thing.pose.scale),
        )  # fmt: skip
        pose = given.moved(level_from_scan)
    if thing.box:
        middle = Pose(np.array(thing.box.center), _unit(thing.box.rotation_wxyz), np.ones(3))
        level = middle.moved(level_from_scan)
        box = Box(level.translation, np.array(thing.box.size), level.rotation)
    support = "" if thing.support is None else str(thing.support)
    return Hint(thing.instance, thing.category, thing.cad, pose, box, support)


def _unit(quaternion: tuple[float, ...]) -> Array:
    turn = np.array(quaternion)
    return np.asarray(turn / np.linalg.norm(turn))
