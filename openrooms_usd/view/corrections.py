"""What all pages share in which people correct a room: taking back, composing, telling."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np
from pxr import Usd

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.composing import compose_room
from openrooms_usd.description import load_room
from openrooms_usd.description.furniture import ScanFurniture
from openrooms_usd.edits.arranging import Standing, beside, resized, settled, standing
from openrooms_usd.edits.editing import History
from openrooms_usd.edits.snapping import PlanPoint
from openrooms_usd.edits.targets import furniture
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.rotations import about_z
from openrooms_usd.steps.alignment.instances import instances_of
from openrooms_usd.steps.alignment.surroundings import surroundings
from openrooms_usd.steps.layout.scanned import found_in, in_metres
from openrooms_usd.usd.files.diagnostics import quiet
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.view.app import Command, Nothing
from openrooms_usd.view.fields import Fields
from openrooms_usd.view.targets import Edits, Target

Row: TypeAlias = dict[str, Any]
_DIGITS: Final = 4


@dataclass
class Corrections:
    """A room under correction.

    Attributes:
        target: Where the corrections are written.
        description: The room.yaml that it is composed from; None if unknown.
        history: What was done to the file that the corrections are written to.
        notes: What the last composition said.
    """

    target: Target
    description: Path | None
    history: History
    notes: list[str] = field(default_factory=list)
    _composed: bool = False

    def told(self) -> dict[str, Any]:
        """What can be taken back and composed, and the version of the file."""
        return {
            **self.history.told(),
            "composes": self.description is not None,
            "notes": self.notes,
        }

    def done(
        self, change: Callable[[], Mapping[str, Any]], *, bares: bool = False
    ) -> dict[str, Any]:
        """Do something that can be taken back, and tell what came of it.

        Args:
            change: What is done.
            bares: Whether steps may have left something out because of prims that no longer exist.
        """
        with quiet(), self.history.step():
            found = change()
        if bares:
            self._follow()
        return {**found, **self.told()}

    def _follow(self) -> None:
        """Steps leave out what edits say: without the edit it must be made again."""
        if self._composed and self.description is not None:
            self.compose()

    def compose(self) -> dict[str, Any]:
        """Compose the room again, so that everything follows what was changed.

        Raises:
            InputError: The description is not known.
            OrusdError: It does not compose.
        """
        if self.description is None:
            raise InputError(
                "the description of this room is not known",
                place=self.target.scene,
                remedy="open the page with --description room.yaml, or run orusd compose",
            )
        with quiet():
            done = compose_room(self.description, self.target.scene.parent)
        self._composed = True
        self.notes = [*(note for row in done.stages for note in row.notes), *done.notes]
        return self.told()

    def _undo(self, _: Nothing) -> dict[str, Any]:
        self.history.undo()
        self._follow()
        return self.told()

    def _redo(self, _: Nothing) -> dict[str, Any]:
        self.history.redo()
        self._follow()
        return self.told()

    def commands(self) -> dict[str, Command[Any]]:
        """Those that every page of corrections has."""
        return {
            "version": Command(Nothing, lambda _: self.told()),
            "undo": Command(Nothing, self._undo),
            "redo": Command(Nothing, self._redo),
            "compose": Command(Nothing, lambda _: self.compose()),
        }


def corrections(
    room: Path, description: Path | None = None, out: Path | None = None
) -> Corrections:
    """Corrections of a composed room, which go to its edits, or of a description, which go there.

    Args:
        room: The ``scene.usda`` of a composed room, or a room.yaml, which is composed first.
        description: What a composed room is composed from, to compose it again.
        out: Where a room.yaml is composed to; by default ``composed`` beside it.

    Raises:
        InputError: It is not a composed room.
        OrusdError: The description does not compose.
    """
    if room.suffix in (".yaml", ".yml"):
        from openrooms_usd.view.describing import Described
        from openrooms_usd.view.fields import Fields

        is_scan = isinstance(load_room(room).furniture, ScanFurniture)
        described = Described(room, (out or room.parent / "composed") / names.SCENE)
        with quiet():
            described.compose()
        fields = Hints(described) if is_scan else Fields(described)
        return Corrections(fields, room, History(room), _composed=True)
    target = Edits(room, description.parent if description else None)
    if not (room.is_file() and target.file.is_file()):
        raise InputError(
            "this is not a composed room",
            place=room,
            remedy="compose a room first: `orusd compose room.yaml -o out`",
        )
    return Corrections(target, description, History(target.file))


@dataclass(frozen=True)
class Hints(Fields):
    """Changes of a room that is found in a scan; what it lists besides are fields as elsewhere."""

    def place(
        self, name: str, spot: PlanPoint, *, size: tuple[float, float, float] | None, snap: bool
    ) -> Standing:
        """Say where an instance is, roughly."""
        stage, instance = self._found(name)
        if instance is None:
            return super().place(name, spot, size=size, snap=snap)
        prim = furniture(stage, name)
        thing = standing(prim)
        thing = thing if size is None else resized(thing, size)
        goal = settled(surroundings(stage), thing, spot) if snap else spot
        moved = replace(thing, x=goal.x, y=goal.y, yaw=goal.yaw)

        def change(row: Row) -> None:
            row.pop("pose", None)
            row["box"] = _box(stage, moved)

        return self._hint(stage, instance, change)

    def duplicate(self, name: str) -> Standing:
        """Put another such object of the library beside it, which the scan does not show."""
        stage, instance = self._found(name)
        if instance is None:
            return super().duplicate(name)
        thing = standing(furniture(stage, name))
        spot, copy = beside(stage, thing), f"{name}_copy"
        row = {
            "name": copy,
            "category": thing.category,
            "at": [round(spot.x, _DIGITS), round(spot.y, _DIGITS)],
            "yaw": round(spot.yaw, _DIGITS),
            "size": [round(side, _DIGITS) for side in thing.size],
        }
        self.described.change(
            "furniture", lambda section: {"further": [*(section.get("further") or ()), row]}
        )
        return self._standing(copy)

    def remove(self, name: str) -> None:
        """Leave an instance out."""
        stage, instance = self._found(name)
        if instance is None:
            super().remove(name)
        else:
            self._change(stage, lambda rows: [r for r in rows if r["instance"] != instance])

    def relabel(self, name: str, category: str) -> Standing:
        """Say what an instance is."""
        stage, instance = self._found(name)
        if instance is None:
            return super().relabel(name, category)

        def change(row: Row) -> None:
            row.pop("cad", None)
            row["category"] = category

        return self._hint(stage, instance, change)

    def remake(self, name: str, style: str, kind: str | None, *, keep_size: bool) -> Standing:
        """Say which of the library's CADs an instance is."""
        stage, instance = self._found(name)
        if instance is None:
            return super().remake(name, style, kind, keep_size=keep_size)
        category = kind or standing(furniture(stage, name)).category

        def change(row: Row) -> None:
            row |= {"category": category, "cad": f"{category}.{style}"}

        return self._hint(stage, instance, change)

    def _found(self, name: str) -> tuple[Usd.Stage, int | None]:
        """The stage, and the number of an object in the scan; None where it is not from there."""
        stage = open_stage(self.scene)
        return stage, _instance(furniture(stage, name))

    def _hint(self, stage: Usd.Stage, instance: int, change: Callable[[Row], None]) -> Standing:
        before = next(
            standing(prim)
            for prim in stage.GetPrimAtPath(names.FURNITURE).GetChildren()
            if _instance(prim) == instance
        )

        def changed(rows: list[Row]) -> list[Row]:
            found = [dict(row) for row in rows]
            if instance not in {row["instance"] for row in found}:
                found += [row for row in self._all(stage) if row["instance"] == instance]
            for row in found:
                if row["instance"] == instance:
                    change(row)
            return found

        self._change(stage, changed)
        # What an instance is called depends on what it is.
        again = open_stage(self.scene)
        for prim in again.GetPrimAtPath(names.FURNITURE).GetChildren():
            if _instance(prim) == instance:
                return standing(prim)
        # Composing may leave out what has no place.
        return before

    def _change(self, stage: Usd.Stage, change: Callable[[list[Row]], list[Row]]) -> None:
        def listed(section: dict[str, Any]) -> dict[str, Any]:
            held = section.get("objects")
            return {"objects": change(self._all(stage) if held is None else list(held))}

        self.described.change("furniture", listed)

    def _all(self, stage: Usd.Stage) -> list[Row]:
        """What is there of the scan, as hints."""
        told = self._labelled_instances(stage)
        if told:
            return [{"instance": number} for number in told]
        found = []
        for prim in stage.GetPrimAtPath(names.FURNITURE).GetChildren():
            if (number := _instance(prim)) is not None:
                word = read_label(prim, names.CAPTURED) or read_label(prim, names.CATEGORY)
                box = _box(stage, standing(prim))
                found.append({"instance": number, "category": word, "box": box})
        return found

    def _labelled_instances(self, stage: Usd.Stage) -> list[int]:
        """The things that the scan itself tells apart; also those that found no place."""
        scan = found_in(stage)
        known = () if scan is None or scan.captured else instances_of(scan.cloud) or ()
        return [one.number for one in known if one.meaning.kind == "thing"]


def _instance(prim: Usd.Prim) -> int | None:
    said = prim.GetAttribute(names.SOURCE_ID)
    text = str(said.Get(TIME)) if said and said.HasValue() else ""
    return int(text) if text.isdecimal() else None


def _box(stage: Usd.Stage, thing: Standing) -> dict[str, Any]:
    """The box of an object in the scan's own axes, metres."""
    from scipy.spatial.transform import Rotation

    said = stage.GetPrimAtPath(names.ROOM).GetAttribute(names.SOURCE_FROM_WORLD).Get(TIME)
    scan_from_world: Array = in_metres(np.array(said).T)
    turn = about_z(np.radians(thing.yaw))
    middle = 0.5 * (np.array(thing.low) + np.array(thing.high))
    center = turn @ np.append(middle, 0.5 * thing.size[2]) + [thing.x, thing.y, thing.z]
    there = scan_from_world[:3, :3] @ center + scan_from_world[:3, 3]
    quaternion = Rotation.from_matrix(scan_from_world[:3, :3] @ turn).as_quat(scalar_first=True)
    return {
        "center": np.round(there, _DIGITS).tolist(),
        "size": [round(side, _DIGITS) for side in thing.size],
        "rotation_wxyz": np.round(quaternion, 6).tolist(),
    }
