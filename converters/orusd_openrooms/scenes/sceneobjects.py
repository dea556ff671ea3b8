"""What the shapes of a scene are: the layout, its container, and objects with their lights."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import PurePosixPath
from typing import Final, Literal

import numpy as np

from openrooms_usd.furniture.registry import records
from orusd_openrooms.scenes.records import Color, ShapeRecord, Step, whole
from orusd_openrooms.scenes.roots import Named, named

Kind = Literal["door", "window", "curtain", "lamp", "furniture"]

LAYOUT: Final = "uv_mapped.obj"
CONTAINER: Final = "container.obj"
# A lamp's two files, and the one that stands for both of them here.
_SHADE, _LIGHT, WHOLE = "aligned_shape.obj", "aligned_light.obj", "alignedNew.obj"
_BUILT_IN: Final[dict[str, Kind]] = {
    "door": "door",
    "window": "window",
    "curtain": "curtain",
    "ceiling_lamp": "lamp",
}
_LAMPS: Final = "03636649"
_SAME_M: Final = 1e-5


@dataclass(frozen=True, eq=False)
class SceneObject:
    """An object of a scene, of one shape or of a lamp's two.

    Attributes:
        number: Of its first shape.
        model: Its folder in the dataset: a synset or a word, and a name.
        kind: What is special about it.
        files: Its meshes, with what each emits; None for what does not.
        steps: How it comes into the world.
        refs: The materials that its meshes may name.
    """

    number: int
    model: Named
    kind: Kind
    files: tuple[tuple[Named, Color | None], ...]
    steps: tuple[Step, ...]
    refs: tuple[str, ...]

    @property
    def id(self) -> str:
        """What identifies it in the scene."""
        return f"{self.number}_{'_'.join(self.model.parts)}"

    @property
    def label(self) -> str:
        """What it is, in a word of the library where there is one."""
        return label_of(self.model.parts[0])

    @property
    def radiance(self) -> Color | None:
        """What it emits, of each primary: nothing where it has a light that is off.

        None where nothing of it could emit.
        """
        lit = next((emitted for _, emitted in self.files if emitted is not None), None)
        has_light = any(is_light(file, emitted) for file, emitted in self.files)
        return (0.0, 0.0, 0.0) if lit is None and has_light else lit


@dataclass(frozen=True, eq=False)
class Contents:
    """The shapes of a scene, sorted.

    Attributes:
        layout: The room's shell; None where the scene has none.
        container: Whether there is a second shell around it.
        members: All else.
    """

    layout: ShapeRecord | None
    container: bool
    members: tuple[SceneObject, ...]


def is_light(file: Named, emitted: Color | None) -> bool:
    """Whether a mesh is what emits of its object, if only when it is switched on."""
    return emitted is not None or file.parts[-1] == _LIGHT


def label_of(folder: str) -> str:
    """What models of a folder are, in a word of the library where there is one."""
    return folder if folder in _BUILT_IN else _synsets().get(folder, folder)


def contents(shapes: Sequence[ShapeRecord]) -> Contents:
    """Sort the shapes of a scene.

    Raises:
        InputError: One of them names a file outside the dataset.
    """
    files = [named(shape.file, f"shape {shape.number} {shape.id[:80]!r}") for shape in shapes]
    shells = [(s, f) for s, f in zip(shapes, files, strict=True) if f.folder == "layoutMesh"]
    layout = next((s for s, f in shells if f.parts[-1] != CONTAINER), None)
    container = any(f.parts[-1] == CONTAINER for _, f in shells)
    rest = [(s, f) for s, f in zip(shapes, files, strict=True) if f.folder != "layoutMesh"]
    return Contents(layout, container, tuple(_things(rest)))


def _things(rest: Sequence[tuple[ShapeRecord, Named]]) -> Iterator[SceneObject]:
    """Each shape, and a lamp's shade together with its light wherever that stands in the file."""
    taken: set[int] = set()
    for at, (shape, file) in enumerate(rest):
        if at in taken:
            continue
        pair = _partner(rest, at, taken)
        both = [(shape, file)] if pair is None else [(shape, file), rest[pair]]
        taken |= {at} if pair is None else {at, pair}
        refs = tuple(dict.fromkeys(ref for one, _ in both for ref in one.refs))
        files = tuple((path, one.radiance) for one, path in both)
        yield SceneObject(shape.number, _model(file), _kind(file), files, shape.steps, refs)


def _partner(rest: Sequence[tuple[ShapeRecord, Named]], at: int, taken: set[int]) -> int | None:
    """The other half of a lamp: in the same folder and at the same place."""
    shape, file = rest[at]
    other = {_SHADE: _LIGHT, _LIGHT: _SHADE}.get(file.parts[-1])
    for index in range(at + 1, len(rest)):
        near, path = rest[index]
        same = path.parts == (*file.parts[:-1], other) and index not in taken
        if same and np.abs(whole(near.steps) - whole(shape.steps)).max() < _SAME_M:
            return index
    return None


def _model(file: Named) -> Named:
    folder = PurePosixPath(file.path).parent
    return Named(file.folder, str(folder if folder.parts else PurePosixPath(file.path).stem))


def _kind(file: Named) -> Kind:
    word = file.parts[0]
    return "lamp" if word == _LAMPS else _BUILT_IN.get(word, "furniture")


@cache
def _synsets() -> dict[str, str]:
    """The library's categories by the numbers that ShapeNet files them under."""
    return {synset: name for name, told in records() for synset in told.synsets}
