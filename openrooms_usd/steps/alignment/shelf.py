"""The CADs that may stand for what a scan shows: people's own, and what the library builds."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.codedigest import remembered
from openrooms_usd.description.furniture import FileObject, ScanFurniture
from openrooms_usd.description.scanned import ScannedObject
from openrooms_usd.furniture import CATEGORIES, MAX_SIDE, MIN_SIDE, category
from openrooms_usd.furniture.record import UNLABELED
from openrooms_usd.furniture.registry import records
from openrooms_usd.furniture.words import category_of, library_words, named_in, plain
from openrooms_usd.library.assets import Asset, Model
from openrooms_usd.library.models.cads import Cad, folder_cads, furniture_cads, merged
from openrooms_usd.names import SHELL
from openrooms_usd.portable import relative_text
from openrooms_usd.scan.artefact import FoundScan
from openrooms_usd.scan.models.cad import CadModel, Up
from openrooms_usd.scan.placement.correcting import correction
from openrooms_usd.scan.registration.hints import Box, Hint
from openrooms_usd.scan.registration.scalelimits import CAD_UNITS_M
from openrooms_usd.scan.results import FoundObject, Pose
from openrooms_usd.steps.alignment.captured import UNKNOWN, sizes_of
from openrooms_usd.steps.alignment.catalogue import Catalogue
from openrooms_usd.steps.alignment.instances import Instance, hint_of, instances_of
from openrooms_usd.steps.alignment.placement import CaptureSource, Measured, Placement
from openrooms_usd.steps.base import StepContext
from openrooms_usd.usd.semantics import NYU40, class_of, classes


@dataclass(eq=False)
class CadCandidates:
    """The CADs that may be taken."""

    context: StepContext
    furniture: ScanFurniture
    scan: FoundScan

    @cached_property
    def cads(self) -> dict[str, Cad]:
        """People's own, and what the library builds for what they lack."""
        built = furniture_cads(tuple(sorted(self._library_categories())))
        own = folder_cads(self.context.source / self.furniture.cad) if self.furniture.cad else []
        return {cad.id: cad for cad in (*built, *own)}

    @cached_property
    def built(self) -> dict[str, Model]:
        """The CADs' meshes, in the object frame."""
        return {name: cad.model() for name, cad in self.cads.items()}

    @cached_property
    def models(self) -> list[CadModel]:
        """In the CADs' own frames: those of their files."""
        made = []
        folder = self.context.source / (self.furniture.cad or "")
        for name, cad in self.cads.items():
            vertices, faces = merged(self.built[name], self.built[name].file_from_object)
            model = CadModel(name, _kind(cad, folder), vertices, faces, cad.symmetry, _up(cad))
            if cad.file is None:
                suits = category(cad.category).styles[cad.style].suits
                model = replace(model, sizes=sizes_of(cad.category), suits=suits)
            made.append(replace(model, unit=_unit_of(model)))
        return made

    @cached_property
    def categories(self) -> dict[int, tuple[str, ...]]:
        """The categories of CADs that a class of NYU40 may mean."""
        known = {model.category for model in self.models}
        return {
            number: tuple(sorted(kind for kind in known if class_of(kind, "nyu40") == name))
            for number, name in enumerate(NYU40)
            if name not in (UNLABELED, *SHELL)
        }

    def _library_categories(self) -> set[str]:
        """Those of the library's categories that may stand for something, and the box."""
        hints = self.hints or ()
        named = {(hint.cad or "").partition(".")[0] for hint in hints}
        chosen = {kind for hint in hints for group in hint.choices or () for kind in group}
        return {UNKNOWN, *(kind for kind in named | chosen if kind in CATEGORIES)} - SHELL

    @cached_property
    def instances(self) -> list[Instance]:
        """The instances of the scan, where it is they that become objects."""
        given = self.furniture.objects is not None or captured_hints(self.scan) is not None
        return [] if given else self._in_scan

    @cached_property
    def _in_scan(self) -> list[Instance]:
        return instances_of(self.scan.cloud) or []

    @cached_property
    def hints(self) -> list[Hint] | None:
        """What is known of the objects, in the level frame."""
        if self.furniture.objects is not None:
            level_from_scan: Array = np.linalg.inv(self.scan.scan_from_level).astype(np.float64)
            known = {instance.number: instance for instance in self._in_scan}
            return [
                _hint(thing, level_from_scan, known.get(thing.instance))
                for thing in self.furniture.objects
            ]
        things = [
            replace(one.hint, box=self.scan.boxes.get(one.number))
            for one in self.instances
            if one.meaning.kind == "thing"
        ]
        return captured_hints(self.scan) or (things if self.instances else None)

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
        source = CaptureSource(self.scan.source, str(thing.instance), word=thing.word)
        return Placement(
            name,
            asset,
            (width, depth, height),
            x,
            y,
            z,
            yaw,
            emits=emits,
            source=source,
            pose=pose,
            measured=Measured(
                measured,
                thing.residual,
                thing.coverage,
                thing.symmetry,
                "object" if carrier else thing.support,
                carrier,
            ),
        )

    def _asset(
        self, catalogue: Catalogue, cad: Cad, thing: FoundObject, measured: Array
    ) -> tuple[Asset, bool]:
        if cad.file is None:
            extent = self.built[cad.id].extent
            scale = np.linalg.norm(measured[:3, :3], axis=0)
            size = np.clip(np.round(scale * np.ptp(extent, axis=0), 3), MIN_SIDE, MAX_SIDE)
            width, depth, height = size.tolist()
            label = plain(thing.word) if cad.category == UNKNOWN and thing.word else None
            made = catalogue.furniture(cad.category, (width, depth, height), cad.style, label)
            return made, category(cad.category).emits
        file = relative_text(cad.file.resolve(), self.context.source.resolve())
        item = FileObject(
            **{"from": "file"},
            category=plain(thing.category or "object"),
            at=(0.0, 0.0),
            file=file,
            up=cad.up,
            front=cad.front,
            unit=1.0,
        )
        return catalogue.file(item), False


def captured_hints(scan: FoundScan) -> list[Hint] | None:
    """The boxes of a capture whose points have no instances.

    Returns:
        None where the points say themselves what is an object, or the capture has no boxes.
    """
    instances = scan.cloud.instance
    if not scan.captured or (instances is not None and instances.any()):
        return None
    return [
        hint_of(number, (word,), float(box.center[2] - 0.5 * box.size[2]), box=box)
        for number, (word, box) in enumerate(scan.captured, 1)
    ]


def _kind(cad: Cad, folder: Path) -> str:
    """The category of a CAD: the library's where it has a word for it, else the file's own.

    Where neither the index nor its folder has such a word, the folders above may, also as ShapeNet
    numbers them, and then the file's own name.
    """
    if cad.file is None or (cad.category in classes() and cad.category not in library_words()):
        return cad.category
    above = reversed(cad.file.relative_to(folder).parts[:-1])
    said = (_synsets().get(word) or category_of(word, 0.0) for word in (cad.category, *above))
    found = next((kind for kind in said if kind), None) or named_in(cad.file.stem)
    return found or (plain(cad.category) if cad.category else "")


def _unit_of(model: CadModel) -> float | None:
    """Metres of a CAD's unit, by the sizes that things of its category have."""
    if model.category not in CATEGORIES:
        return None
    lengths = np.sort(np.ptp(model.extent, axis=0))
    least, most = np.sort(sizes_of(model.category), axis=1)
    units = (unit for unit in CAD_UNITS_M if (lengths * unit >= least).all())
    return next((unit for unit in units if (lengths * unit <= most).all()), None)


@remembered
def _synsets() -> dict[str, str]:
    """The library's categories by the numbers that ShapeNet files them under."""
    return {synset: name for name, told in records() for synset in told.synsets}


def _up(cad: Cad) -> Up | None:
    """A CAD's vertical; None if unknown: OBJ and PLY files may be Y up or Z up."""
    if cad.file is None:
        return "Z"
    # GLB is Y up, and so are ShapeNet's models, which lie in folders of synsets.
    known = cad.file.suffix.lower() == ".glb" or any(part in _synsets() for part in cad.file.parts)
    return cad.up or ("Y" if known else None)


def _hint(thing: ScannedObject, level_from_scan: Array, seen: Instance | None) -> Hint:
    """What the description knows of an object; where it does not say what it is, the scan may."""
    pose = box = None
    if thing.pose:
        given = Pose(
            np.array(thing.pose.translation),
            _unit(thing.pose.rotation_wxyz),
            np.array(thing.pose.scale),
        )
        pose = given.moved(level_from_scan)
    if thing.box:
        middle = Pose(np.array(thing.box.center), _unit(thing.box.rotation_wxyz), np.ones(3))
        level = middle.moved(level_from_scan)
        box = Box(level.translation, np.array(thing.box.size), level.rotation)
    support = "" if thing.support is None else str(thing.support)
    hint = Hint(thing.instance, thing.category, thing.cad, pose, box, support)
    if thing.cad is not None or (thing.category is None and seen is None):
        return hint
    bottom = seen.bottom if seen else 0.0
    words = (thing.category,) if thing.category else seen.words if seen else ()
    meant = hint_of(thing.instance, words, bottom)
    return replace(hint, word=meant.word, choices=meant.choices)


def _unit(quaternion: tuple[float, ...]) -> Array:
    turn = np.array(quaternion)
    return np.asarray(turn / np.linalg.norm(turn))
