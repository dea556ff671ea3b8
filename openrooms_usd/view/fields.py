"""What people do with things of a room, as fields of its room.yaml: objects, materials."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np
from pxr import Sdf, Usd

from openrooms_usd import names
from openrooms_usd.edits.arranging import Standing, beside, resized, settled, standing
from openrooms_usd.edits.assigning import Assigned
from openrooms_usd.edits.snapping import PlanPoint
from openrooms_usd.edits.targets import Scope, furniture, object_of, parts_meant
from openrooms_usd.geometry.rotations import in_plan
from openrooms_usd.library.styles.assignment.kinds import kind_of
from openrooms_usd.steps.alignment.surroundings import surroundings
from openrooms_usd.steps.materials.dressing import ALL
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.view.describing import Described, Objects
from openrooms_usd.view.targets import Said

_DIGITS: Final = 4
# What only some categories and styles know.
_OF_A_STYLE: Final = ("fronts", "cutouts")
# The key of the materials that says what a part of the shell is made of; of others there is none.
_SHELL: Final = {
    "floor": "floor",
    "wall": "walls",
    "ceiling": "ceiling",
    "skirting": "trim",
    "cornice": "trim",
    "picture_rail": "trim",
    "wainscot": "trim",
    "beam": "beams",
    "ceiling_grid": "beams",
}


@dataclass(frozen=True)
class Fields:
    """Changes that are fields of a room.yaml; after each of them the room is composed.

    Attributes:
        described: The room.
    """

    described: Described

    @property
    def file(self) -> Path:
        """What is written."""
        return self.described.file

    @property
    def scene(self) -> Path:
        """What is shown."""
        return self.described.scene

    def place(
        self, name: str, spot: PlanPoint, *, size: tuple[float, float, float] | None, snap: bool
    ) -> Standing:
        """Move, turn or resize an object."""
        stage = open_stage(self.scene)
        thing = standing(furniture(stage, name))
        thing = thing if size is None else resized(thing, size)
        goal = settled(surroundings(stage), thing, spot) if snap else spot

        def change(objects: Objects) -> None:
            row = objects[name]
            row |= _placed(stage, row, goal)
            if size is not None:
                row["size"] = [round(side, _DIGITS) for side in size]

        self.described.change_objects(change)
        return self._standing(name)

    def duplicate(self, name: str) -> Standing:
        """Put a copy of an object beside it."""
        stage = open_stage(self.scene)
        thing, copy = standing(furniture(stage, name)), name

        def change(objects: Objects) -> None:
            nonlocal copy
            row = dict(objects[name])
            taken = {prim.GetName() for prim in stage.GetPrimAtPath(names.FURNITURE).GetChildren()}
            numbered = (f"{name}_copy_{number}" for number in range(2, len(taken) + 4))
            copy = next(one for one in (f"{name}_copy", *numbered) if one not in taken)
            objects.rows[copy] = {**row, "name": copy, **_placed(stage, row, beside(stage, thing))}

        self.described.change_objects(change)
        return self._standing(copy)

    def remove(self, name: str) -> None:
        """Take an object out of the list."""

        def change(objects: Objects) -> None:
            objects[name]
            del objects.rows[name]

        self.described.change_objects(change)

    def relabel(self, name: str, category: str) -> Standing:
        """Let an object be of another category; the library makes it."""

        def change(objects: Objects) -> None:
            row = objects[name]
            for key in ("style", *_OF_A_STYLE):
                row.pop(key, None)
            row["category"] = category

        self.described.change_objects(change)
        return self._standing(name)

    def remake(self, name: str, style: str, kind: str | None, *, keep_size: bool) -> Standing:
        """Let the library make an object in another style."""
        now = self._standing(name)

        def change(objects: Objects) -> None:
            row = objects[name]
            for key in _OF_A_STYLE:
                row.pop(key, None)
            if keep_size:
                row["size"] = [round(side, _DIGITS) for side in now.size]
            row |= {"category": kind or now.category, "style": style}

        self.described.change_objects(change)
        return self._standing(name)

    def assign(self, path: str, scope: Scope, look: Said) -> Assigned:
        """Say in the section ``materials`` what parts are made of."""
        return self._dressed(path, scope, look)

    def unassign(self, path: str, scope: Scope) -> Assigned:
        """Take what is said of parts out of the section ``materials``."""
        return self._dressed(path, scope, None)

    def _dressed(self, path: str, scope: Scope, look: Said | None) -> Assigned:
        stage = open_stage(self.scene)
        parts = parts_meant(stage, path, scope)
        self.described.change(
            "materials", partial(_change_materials, stage, parts, path, scope, look)
        )
        return Assigned("", tuple(map(str, parts)))

    def _standing(self, name: str) -> Standing:
        # What was opened must live as long as its prims.
        stage = open_stage(self.scene)
        return standing(furniture(stage, name))


def _placed(stage: Usd.Stage, row: Mapping[str, Any], spot: PlanPoint) -> dict[str, Any]:
    """``at`` and ``yaw`` of an object; relative to another one where it is so described."""
    place, yaw = np.array([spot.x, spot.y]), spot.yaw
    if other := row.get("relative_to"):
        frame = standing(furniture(stage, other))
        place = in_plan(np.radians(-frame.yaw)) @ (place - [frame.x, frame.y])
        yaw -= frame.yaw
    x, y = (round(value, _DIGITS) + 0.0 for value in place.tolist())
    turned = round((yaw + 180.0) % 360.0 - 180.0, _DIGITS) + 0.0
    return {"at": [x, y, *row["at"][2:]], "yaw": turned}


def _change_materials(
    stage: Usd.Stage,
    parts: list[Sdf.Path],
    path: str,
    scope: Scope,
    look: Said | None,
    section: Mapping[str, Any],
) -> dict[str, Any]:
    """The keys of the materials that change."""
    part = stage.GetPrimAtPath(path)
    root = object_of(part)
    category = read_label(root, names.CATEGORY) or ""
    if root != part or category not in (*_SHELL, "cladding"):
        return {"overrides": _overrides(stage, parts, scope, look, section) or None}
    if category == "cladding":
        return {"cladding": _with(section.get("cladding"), part.GetParent().GetName(), look)}
    if category == "wall" and scope in ("part", "object"):
        return {"accents": _with(section.get("accents"), part.GetName(), look)}
    # All walls: what single ones have beside would hide it.
    return {_SHELL[category]: look, **({"accents": None} if category == "wall" else {})}


def _with(held: Any, key: str, value: Any) -> dict[str, Any] | None:
    """A mapping with one key changed, or left out; None for an empty one."""
    rest = {name: old for name, old in (held or {}).items() if name != key}
    return {**rest, **({key: value} if value is not None else {})} or None


def _overrides(
    stage: Usd.Stage,
    parts: list[Sdf.Path],
    scope: Scope,
    look: Said | None,
    section: Mapping[str, Any],
) -> dict[str, Any]:
    found = {name: dict(rows) for name, rows in (section.get("overrides") or {}).items()}
    for path in parts:
        prim = stage.GetPrimAtPath(path)
        rows = found.setdefault(object_of(prim).GetName(), {})
        kind = kind_of(read_label(prim, names.PART) or "")
        if scope in ("object", "category"):
            rows.clear()
        elif scope == "alike":
            rows.pop(path.name, None)
        key = {"part": path.name, "alike": kind}.get(scope, ALL)
        rows.pop(key, None)
        if look is not None:
            rows[key] = look
    return {name: rows for name, rows in found.items() if rows}
