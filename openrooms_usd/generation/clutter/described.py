"""What lies about in a room that people described: their objects as the generator sees them."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd.description.furniture import FileObject, LibraryObject, named_objects
from openrooms_usd.draws import generator
from openrooms_usd.furniture import CATEGORIES, Size, category, styles
from openrooms_usd.furniture.joinery.pieces import NOTHING_ORDERED
from openrooms_usd.generation.clutter.forms import LevelFinder
from openrooms_usd.generation.clutter.laying import taken_by
from openrooms_usd.generation.clutter.living import add_clutter
from openrooms_usd.generation.items import Item, placed
from openrooms_usd.generation.placement import Arrangement
from openrooms_usd.generation.shapes import BuiltForm, Shapes
from openrooms_usd.generation.shell import Shell
from openrooms_usd.library.models.meshfile import read_model

_ROOM: Final = ("floor", "ceiling", "wall")
AnyObject = LibraryObject | FileObject


def lying_in(
    objects: Sequence[AnyObject], shell: Shell, room_type: str, seed: int, level: int, folder: Path
) -> list[tuple[Item, Item | None]]:
    """What lies about among described objects, each with the object that carries it.

    Args:
        objects: The described objects.
        shell: The room.
        room_type: One of the 27.
        seed: The room's.
        level: 1 tidy, 2 lived in, 3 messy.
        folder: Where the names of mesh files begin.
    """
    shapes = Shapes(seed)
    items = list(_Described(objects, shell, shapes, folder).items())
    room = Arrangement(shell)
    room.floor = room.floor.with_boxes(taken_by(items, LevelFinder(shapes)).boxes)
    room.solids = np.array([item.box for item in items]).reshape(-1, 8)
    room.know(items)
    full = add_clutter([("described", items)], room, shapes, room_type, seed, level)
    everything = [item for _, group in full for item in group]
    known = {item.key: item for item in everything}
    return [(item, known.get(item.on)) for item in everything if item.lies]


class _Described:
    """Finds where described objects stand, as the alignment step will."""

    def __init__(
        self, objects: Sequence[AnyObject], shell: Shell, shapes: Shapes, folder: Path
    ) -> None:
        self.rows = dict(named_objects(objects))
        self.shell, self.shapes, self.folder = shell, shapes, folder
        self.done: dict[str, Item] = {}

    def items(self) -> Iterator[Item]:
        """All objects in the room's frame."""
        standing = sorted(self.rows, key=lambda name: self._support(self.rows[name]) == "surface")
        for name in standing:
            self._item(name, ())
        yield from (self.done[name] for name in self.rows)

    def _support(self, row: AnyObject) -> str:
        known = category(row.category).support if row.category in CATEGORIES else "floor"
        return row.on or str(known)

    def _item(self, name: str, above: tuple[str, ...]) -> Item | None:
        """An object, after those that it depends on; None in a circle, which the stage refuses."""
        if name in self.done or name not in self.rows or name in above:
            return self.done.get(name)
        row, on = self.rows[name], self._support(self.rows[name])
        size, style = self._make(name, row)
        (x, y), yaw = row.at[:2], row.yaw
        frame = self._item(row.relative_to, (*above, name)) if row.relative_to else None
        if frame is not None:
            (x, y), yaw = frame.at(x, y), yaw + frame.yaw
        if on == "wall":
            x, y, yaw = self._hung(x, y, size)
        item = Item(name, row.category, size, style, x, y, 0.0, yaw, on)
        if len(row.at) > 2:
            z, carrier = row.at[2], on
        else:
            z, carrier = self._height(item, self._item(on, (*above, name)))
        self.done[name] = Item(name, row.category, size, style, x, y, z, yaw, carrier)
        return self.done[name]

    def _make(self, name: str, row: AnyObject) -> tuple[Size, str]:
        if isinstance(row, FileObject):
            model = read_model(
                self.folder / row.file, size=row.size, up=row.up, front=row.front, unit=row.unit
            )
            width, depth, height = (model.extent[1] - model.extent[0]).tolist()
            shape = BuiltForm(tuple(model.parts.values()))
            self.shapes.know(row.category, (width, depth, height), name, shape)
            return (width, depth, height), name
        spec = category(row.category)
        known = spec.styles.get(row.style or "")
        size = row.size or (known and known.size) or spec.size
        if row.style:
            return size, row.style
        choices = styles(row.category, size)
        draw = generator(self.shapes.seed, "alignment", "style", row.category, repr(size))
        return size, choices[int(draw.integers(len(choices)))]

    def _hung(self, x: float, y: float, size: Size) -> tuple[float, float, float]:
        """With its back at the nearest wall."""
        place = np.array([x, y])
        along = [float((place - side.start) @ side.along) for side in self.shell.sides]
        near = [
            float(np.linalg.norm(place - side.point(float(np.clip(at, 0.0, side.length)))))
            for side, at in zip(self.shell.sides, along, strict=True)
        ]
        index = int(np.argmin(near))
        side = self.shell.sides[index]
        half = min(0.5 * size[0], 0.5 * side.length)
        at = float(np.clip(along[index], half, side.length - half))
        px, py = side.point(at, 0.5 * size[1]).tolist()
        return px, py, side.yaw

    def _height(self, item: Item, carrier: Item | None) -> tuple[float, str]:
        if item.on == "ceiling":
            return self.shell.height - item.size[2], item.on
        if item.on == "wall":
            known = category(item.category).mount_height if item.category in CATEGORIES else 0.0
            return known, item.on
        below = [carrier] if carrier else []
        if item.on == "surface":
            below = [other for other in self.done.values() if other.on == "floor"]
        tops = [(self._top(other, item), other.key) for other in below]
        return max((row for row in tops if np.isfinite(row[0])), default=(0.0, "floor"))

    def _top(self, carrier: Item, item: Item) -> float:
        x, y = placed((0.0, 0.0, -carrier.yaw), item.x - carrier.x, item.y - carrier.y)
        shape = self.shapes.of(carrier.category, carrier.size, carrier.style, NOTHING_ORDERED)
        return carrier.z + float(shape.tops(np.array([x]), np.array([y]))[0])


def rows(
    lying: Sequence[tuple[Item, Item | None]], taken: Sequence[str]
) -> list[tuple[str, Item, str, Item | None]]:
    """Names of what lies about, beside the names that are taken: name, item, carrier, its item."""
    names: dict[str, str] = {}
    used, numbers = set(taken), dict[str, int]()
    for item, _ in lying:
        number = numbers.get(item.category, 0)
        while f"{item.category}_{number}" in used:
            number += 1
        names[item.key] = f"{item.category}_{number}"
        numbers[item.category] = number + 1
    return [(names[i.key], i, names.get(i.on, i.on), below) for i, below in lying]
