"""The objects of a composed stage, and how far they are from those of the truth."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.real.truth import Truth
from openrooms_usd.arrays import Array, Ints

# A size is right within these factors, or within so many metres.
SIZE: Final = (0.6, 1.6, 0.05)
# The middle of an object is inside the room within so many metres.
INSIDE: Final = 0.15
# What may stand for a label that says nothing of the kind.
PLAIN: Final = ("box", "basket")
_LABELS: Final = ("semantics:labels:category", "semantics:labels:openrooms45")
_THINNEST: Final = 0.02  # metres; what is flatter has no proportion


@dataclass(frozen=True, eq=False)
class PlacedObject:
    """An object of a stage, in the capture's axes, metres.

    Attributes:
        prim: The name of its prim.
        label: Its category.
        size: Long, short, height.
        middle: (3,) of its box.
        points: (N, 3) of its mesh.
        faces: (F, 3) rows of them.
    """

    prim: str
    label: str | None
    size: tuple[float, float, float]
    middle: Array
    points: Array
    faces: Ints


@dataclass(frozen=True)
class ThingScore:
    """Counts over the labelled objects of a capture.

    Attributes:
        listed: Those whose label says what they are.
        present: Those of them that were placed.
        category: Those of them whose category is one that the label accepts.
        size: Those whose size is right.
        sized: Those whose size is known.
        inside: Those in the room, of those that are in truth.
        inside_of: Those that are in truth.
        other: Objects whose label says nothing, such as "otherprop".
        invented: Those of them that became a named thing.
    """

    listed: int = 0
    present: int = 0
    category: int = 0
    size: int = 0
    sized: int = 0
    inside: int = 0
    inside_of: int = 0
    other: int = 0
    invented: int = 0

    def __add__(self, more: "ThingScore") -> "ThingScore":
        return ThingScore(*(getattr(self, f.name) + getattr(more, f.name) for f in fields(self)))


def things_of(scene: Path) -> dict[str, PlacedObject]:
    """The furniture of a composed stage by the capture's identifiers."""
    from pxr import Gf, Usd, UsdGeom

    stage = Usd.Stage.Open(str(scene))
    attribute = stage.GetPrimAtPath("/World/Room").GetAttribute("openrooms:source:fromWorld")
    back = attribute.Get() if attribute and attribute.HasValue() else Gf.Matrix4d(1.0)
    purposes = [UsdGeom.Tokens.default_, UsdGeom.Tokens.render]
    boxes = UsdGeom.BBoxCache(Usd.TimeCode.Default(), purposes, True)
    parent = stage.GetPrimAtPath("/World/Furniture")
    found: dict[str, PlacedObject] = {}
    for prim in parent.GetChildren() if parent else ():
        key = prim.GetAttribute("openrooms:source:id")
        box = boxes.ComputeUntransformedBound(prim).ComputeAlignedRange()
        if not key or key.Get() is None or box.IsEmpty():
            continue
        matrix = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
        axes = np.array(matrix)[:3, :3]
        size = np.array(box.GetSize()) * np.linalg.norm(axes, axis=1)
        up = int(np.argmax(np.abs(axes[:, 2]) / np.linalg.norm(axes, axis=1)))
        flat = sorted(np.delete(size, up), reverse=True)
        middle = back.Transform(matrix.Transform((box.GetMin() + box.GetMax()) / 2))
        points, faces = _mesh(prim, np.array(back))
        found[str(key.Get())] = PlacedObject(
            prim.GetName(),
            next((str(next(iter(v))) for name in _LABELS if (v := _value(prim, name))), None),
            (float(flat[0]), float(flat[1]), float(size[up])),
            np.array(middle),
            points,
            faces,
        )
    return found


def _value(prim: Any, name: str) -> Any:
    attribute = prim.GetAttribute(name)
    return attribute.Get() if attribute else None


def _mesh(prim: Any, back: Array) -> tuple[Array, Ints]:
    """The triangles below a prim, in the capture's axes."""
    points, faces, start = [np.zeros((0, 3))], [np.zeros((0, 3), np.int64)], 0
    for some, polygons in _meshes(prim):
        points.append(some @ back[:3, :3] + back[3, :3])
        faces.append(polygons + start)
        start += len(some)
    return np.concatenate(points), np.concatenate(faces)


def _meshes(prim: Any) -> Iterator[tuple[Array, Ints]]:
    """Points in the world and triangles of each mesh that is drawn."""
    from pxr import Usd, UsdGeom

    drawn = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)
    for part in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()):
        image = UsdGeom.Imageable(part)
        if not part.IsA(UsdGeom.Mesh) or image.ComputePurpose() not in drawn:
            continue
        if image.ComputeVisibility() == UsdGeom.Tokens.invisible:
            continue
        mesh = UsdGeom.Mesh(part)
        matrix = np.array(image.ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
        local = np.array(mesh.GetPointsAttr().Get(), float).reshape(-1, 3)
        counts = np.array(mesh.GetFaceVertexCountsAttr().Get(), np.int64)
        rows = np.array(mesh.GetFaceVertexIndicesAttr().Get(), np.int64)
        yield local @ matrix[:3, :3] + matrix[3, :3], fans(counts, rows)


def fans(counts: Ints, rows: Ints) -> Ints:
    """(F, 3) triangles of polygons, each a fan around its first point."""
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    many = np.maximum(counts - 2, 0)
    first = np.repeat(starts, many)
    step = np.arange(many.sum()) - np.repeat(np.cumsum(many) - many, many) + 1
    return np.stack([rows[first], rows[first + step], rows[first + step + 1]], axis=1)


def thing_score(
    said: Mapping[str, str],
    placed: Mapping[str, PlacedObject],
    truth: Truth,
    substitutes: Mapping[str, Sequence[str] | None],
) -> ThingScore:
    """Labelled objects against those of the truth.

    Args:
        said: The category of each instance that was placed.
        placed: Where it stands, and how large it is.
        truth: With a frame.
        substitutes: The categories that do for a label; None for one that says nothing.
    """
    import shapely

    assert truth.frame is not None
    area = shapely.make_valid(shapely.Polygon(truth.rooms[0].outlines[0])).buffer(INSIDE)
    total = ThingScore()
    for true in truth.things:
        category = said.get(true.instance)
        accepted = substitutes.get(true.label)
        if accepted is None:
            named = category is not None and category not in PLAIN
            total += ThingScore(other=1, invented=int(named))
            continue
        total += ThingScore(listed=1)
        if category is None:
            continue
        total += ThingScore(present=1, category=int(category in accepted))
        thing = placed.get(true.instance)
        if thing is None:
            continue
        spot = shapely.Point(truth.frame.plan(thing.middle)[0, :2])
        total += ThingScore(
            size=int(size_right(thing.size, true.size)),
            sized=1,
            inside=int(true.inside and area.contains(spot)),
            inside_of=int(true.inside),
        )
    return total


def size_right(found: Sequence[float], true: Sequence[float]) -> bool:
    """Whether each of three lengths is within `SIZE`."""
    low, high, near = SIZE
    return all(
        low <= a / max(b, _THINNEST) <= high or abs(a - b) < near
        for a, b in zip(found, true, strict=True)
    )
