"""The models of a room as OBJ files, and the steps that bring each into the scene."""

import re
from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

from openrooms_usd import atomic
from openrooms_usd.arrays import Array
from openrooms_usd.furniture.registry import record
from openrooms_usd.rendering.scene.triangles import Triangles
from orusd_openrooms.cameras import THEIRS_FROM_OURS
from orusd_openrooms.scenes.materials import Materials, mapping
from orusd_openrooms.scenes.objects import Object
from orusd_openrooms.scenes.records import Bsdf, ShapeRecord, Step
from orusd_openrooms.scenes.sceneobjects import label_of

# Meshes as OBJ files, as OpenRooms' loaders read them: triangles, single blanks, `usemtl`.

_DECIMALS: Final = 6


@dataclass(frozen=True, eq=False)
class Faces:
    """Triangles of one material.

    Attributes:
        material: What ``usemtl`` calls it.
        corners: (M, 3, 3) metres, counter-clockwise seen from the front.
        normals: (M, 3, 3) unit normal at each corner.
        st: (M, 3, 2) texture coordinates at each corner.
    """

    material: str
    corners: Array
    normals: Array
    st: Array


def obj_bytes(parts: Iterable[Faces]) -> bytes:
    """An OBJ file; corners of one part that share a point, a normal or coordinates share a line."""
    lines: list[str] = []
    offsets = np.zeros(3, dtype=np.int64)
    for part in parts:
        columns = []
        values = (("v", part.corners), ("vt", part.st), ("vn", part.normals))
        for number, (word, rows) in enumerate(values):
            rounded = np.round(rows.reshape(-1, rows.shape[-1]), _DECIMALS) + 0.0
            own, index = np.unique(rounded, axis=0, return_inverse=True)
            lines += [
                f"{word} {' '.join(f'{x:.{_DECIMALS}f}' for x in row)}" for row in own.tolist()
            ]
            columns.append(index.reshape(-1) + 1 + offsets[number])
            offsets[number] += len(own)
        lines.append(f"usemtl {part.material}")
        v, vt, vn = (column.reshape(-1, 3).tolist() for column in columns)
        for a, b, c in zip(v, vt, vn, strict=True):
            words = (f"{i}/{j}/{k}" for i, j, k in zip(a, b, c, strict=True))
            lines.append(f"f {' '.join(words)}")
    return ("\n".join(lines) + "\n").encode()


# Our objects look along -Y and theirs along -Z, with Y up.
_MODEL_FROM_OBJECT: Final = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
_CEILING_LAMPS: Final = "ceiling_lamp"
_LAMPS: Final = "03636649"
_WHOLE, _DARK, _LIT = "alignedNew.obj", "aligned_shape.obj", "aligned_light.obj"
_STILL_DEG: Final = 1e-7


@dataclass(frozen=True)
class _Model:
    """A model that is written.

    Attributes:
        folder: Below ``uv_mapped``.
        files: That make it, of a light what is dark and what shines.
        refs: The materials of what is dark.
    """

    folder: str
    files: tuple[str, ...]
    refs: tuple[str, ...]

    @property
    def label(self) -> str:
        """What readers take it for."""
        return label_of(self.folder.partition("/")[0])


@dataclass(eq=False)
class ModelFiles:
    """Writes the models of a room, each once.

    Attributes:
        root: The dataset's folder.
        up: The way from a scene file to it.
        own: What the names of the room's models begin with: other rooms have their own.
        materials: Writes their maps.
        bsdfs: The scene's materials, by identifier; grows.
    """

    root: Path
    up: str
    own: str
    materials: Materials
    bsdfs: dict[str, Bsdf]
    _models: dict[str, _Model] = field(default_factory=dict)

    def label(self, item: Object) -> str:
        """What readers take an object for; the object is written."""
        return self._model(item).label

    def shapes(self, item: Object, first: int) -> Iterator[ShapeRecord]:
        """The shapes of an object, counted from a number.

        Raises:
            OutputError: A file cannot be written.
        """
        model, radiance = self._model(item), item.radiance
        for number, file in enumerate(model.files, first):
            emits = radiance is not None and file in (_LIT, _WHOLE)
            yield ShapeRecord(
                number,
                f"{model.folder.replace('/', '_')}_object",
                f"{self.up}uv_mapped/{model.folder}/{file}",
                tuple(steps_of(item)),
                () if emits else model.refs,
                radiance if emits else None,
            )

    def _model(self, item: Object) -> _Model:
        if item.prototype not in self._models:
            self._models[item.prototype] = self._written(item)
        return self._models[item.prototype]

    def _written(self, item: Object) -> _Model:
        taken = {model.folder for model in self._models.values()}
        plain = re.sub(r"[^A-Za-z0-9_]+", "_", item.name) or "object"
        folder = _unique(f"{_category_folder(item)}/{self.own}_{plain}", taken)
        dark: list[Faces] = []
        lit: list[Faces] = []
        for part in item.parts.values():
            surface = part.patch.surface
            identifier = _unique(f"{folder.replace('/', '_')}_{part.name}", self.bsdfs)
            faces = _faces(item, part.triangles, identifier, mapping(surface))
            if part.patch.radiance is not None:
                lit.append(faces)
                continue
            dark.append(faces)
            self.bsdfs[identifier] = self.materials.bsdf(identifier, surface, part.material)
        files = {_WHOLE: [*dark, *lit]}
        shown: tuple[str, ...] = (_WHOLE,)
        if dark and lit:
            files |= {_DARK: dark, _LIT: lit}
            shown = (_DARK, _LIT)
        for file, faces_of in files.items():
            atomic.write_bytes(self.root / "uv_mapped" / folder / file, obj_bytes(faces_of))
        return _Model(folder, shown, tuple(faces.material for faces in dark))


def steps_of(item: Object) -> Iterator[Step]:
    """Scale, rotation and translation of a model, then the shifts that come after them."""
    matrix = item.world_from_object
    scale = np.linalg.norm(matrix[:3, :3], axis=0)
    turn = THEIRS_FROM_OURS @ (matrix[:3, :3] / scale) @ _MODEL_FROM_OBJECT.T
    x, y, z = (np.abs(_MODEL_FROM_OBJECT) @ scale).tolist()
    yield Step.scale(x, y, z)
    vector = Rotation.from_matrix(turn).as_rotvec(degrees=True)
    angle = float(np.linalg.norm(vector))
    if angle > _STILL_DEG:
        yield Step.rotate(angle, vector)
    moved = matrix[:3, 3] - sum(item.shifts, np.zeros(3))
    for shift in (moved, *item.shifts):
        u, v, w = (THEIRS_FROM_OURS @ shift).tolist()
        yield Step.translate(u, v, w)


def plain_steps(item: Object) -> Iterator[tuple[str, Array]]:
    """The same steps as ``transform.dat`` has them."""
    for step in steps_of(item):
        if step.kind == "rotate":
            yield "rot", step.matrix[:3, :3]
        else:
            yield ("s" if step.kind == "scale" else "t"), np.array(step.values)


def _category_folder(item: Object) -> str:
    """The folder of a category: where lights are, loaders know them by it."""
    if item.radiance is not None:
        return _CEILING_LAMPS if item.category == _CEILING_LAMPS else _LAMPS
    found = record(item.category)
    synsets = found.synsets if found is not None else ()
    # Several of our categories have one synset; the reader takes the first of them.
    return next((s for s in synsets if label_of(s) == item.category), item.category)


def _faces(item: Object, triangles: Sequence[Triangles], material: str, uv: Array) -> Faces:
    corners = np.concatenate([one.corners for one in triangles])
    normals = np.concatenate([one.normals for one in triangles]).astype(np.float64)
    st = np.concatenate([one.st for one in triangles]).astype(np.float64)
    object_from_world = np.linalg.inv(item.world_from_object)
    local = corners @ object_from_world[:3, :3].T + object_from_world[:3, 3]
    # Normals go with the inverse transpose of the way of points.
    turned = normals @ item.world_from_object[:3, :3]
    turned = turned / np.maximum(np.linalg.norm(turned, axis=-1, keepdims=True), 1e-12)
    C = _MODEL_FROM_OBJECT
    return Faces(material, local @ C.T, turned @ C.T, st @ uv[:2, :2].T + uv[:2, 2])


def _unique(name: str, taken: Container[str]) -> str:
    number, found = 0, name
    while found in taken:
        number += 1
        found = f"{name}_{number}"
    return found
