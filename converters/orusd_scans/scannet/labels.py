"""ScanNet's annotation of a mesh: class and instance of each vertex."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.usd.taxonomies import NYU40
from orusd_scans.formats.ply import read_ply
from orusd_scans.records.fields import text
from orusd_scans.records.jsonfile import Node, read_json
from orusd_scans.records.table import read_table

# The column of the raw names, in new and in old releases.
_RAW: Final = ("raw_category", "category")


@dataclass(frozen=True, eq=False)
class Annotation:
    """Class (NYU40) and instance of each vertex, (N,); 0 where there is none; None if unknown."""

    label: NDArray[np.int32] | None
    instance: NDArray[np.int32] | None


def read_annotation(
    count: int,
    segments: Path | None,
    aggregation: Path | None,
    labelled: Path | None,
    table: Path | None,
    notes: list[str],
) -> Annotation:
    """Read the annotation of a mesh.

    Classes come from the table if it is given, else from the labelled mesh, else from those names
    of the objects that are names of NYU40.

    Args:
        count: How many vertices the mesh has.
        segments: ``segs.json``: the segment of each vertex.
        aggregation: ``aggregation.json``: the segments of each object.
        labelled: ``labels.ply``: the mesh with a class at each vertex.
        table: ``scannetv2-labels.combined.tsv``.
        notes: Receives sentences about what is missing or was guessed.

    Raises:
        InputError: A file holds nonsense, or does not belong to the mesh.
    """
    label = _labelled(labelled, count, notes) if labelled is not None and table is None else None
    if segments is None or aggregation is None:
        if label is None:
            notes.append("the scene has no segments and no labels: its points have no classes")
        return Annotation(label, None)
    owners = _segments(segments, count)
    objects = _objects(aggregation)
    instance = np.zeros(count, np.int32)
    classes = np.zeros(count, np.int32)
    known = _classes(table) if table is not None else {n: i for i, n in enumerate(NYU40)}
    unknown: set[str] = set()
    for one in objects:
        rows = np.isin(owners, one.segments)
        instance[rows] = one.number
        classes[rows] = known.get(one.name, 0)
        if one.name not in known:
            unknown.add(one.name)
    if label is None and unknown:
        notes.append(
            f"{len(unknown)} names of objects have no NYU40 class (such as {min(unknown)}): "
            "give scannetv2-labels.combined.tsv as --labels"
        )
    return Annotation(classes if label is None else label, instance)


@dataclass(frozen=True, eq=False)
class _Object:
    """A group of segments."""

    number: int
    name: str
    segments: NDArray[np.int64]


def _labelled(path: Path, count: int, notes: list[str]) -> NDArray[np.int32] | None:
    scanned = read_ply(path)
    label = scanned.cloud.label
    if label is None or len(label) != count:
        raise InputError(
            "this is not the labelled mesh of the scene: its vertices are others",
            place=path,
            remedy="take both meshes from one release",
        )
    if int(label.max(initial=0)) >= len(NYU40):
        # Old releases wrote numbers of raw categories there.
        notes.append("the labelled mesh holds no NYU40 classes: it was left out")
        return None
    return label


def _segments(path: Path, count: int) -> NDArray[np.int64]:
    node = read_json(path, "annotations").need("segIndices")
    owners = _whole_numbers(node)
    if len(owners) != count:
        raise node.error(
            f"{len(owners):,} vertices have segments, but the mesh has {count:,}",
            "take the segments of this mesh",
        )
    return owners


def _objects(path: Path) -> list[_Object]:
    found, numbers = list[_Object](), set[int]()
    for node in read_json(path).items("segGroups"):
        number = node.get("objectId") or node.need("id")
        value = int(_whole_numbers(Node([number.value], path, number.path))[0]) + 1
        if value in numbers:
            raise number.error("this object is there already", "mend the aggregation")
        numbers.add(value)
        name = text(node.need("label")).lower().replace(" ", "_")
        found.append(_Object(value, name, _whole_numbers(node.need("segments"))))
    return found


def _whole_numbers(node: Node) -> NDArray[np.int64]:
    values: Any = node.value
    ok = isinstance(values, list) and all(type(v) is int and 0 <= v < 1 << 31 for v in values)
    if not ok:
        raise node.error("a list of whole numbers expected", "download the scene again")
    return np.array(values, dtype=np.int64)


def _classes(path: Path) -> Mapping[str, int]:
    """The NYU40 class of each raw name."""
    rows = read_table(path, ("nyu40id",), (*_RAW, "nyu40class"))
    found: dict[str, int] = {}
    for row in rows:
        name = next((node for key in _RAW if (node := row.get(key)) is not None), None)
        number = row.get("nyu40id")
        if name is not None and number is not None:
            value = number.numbers(1, len(NYU40) - 1)[0]
            found[text(name).lower().replace(" ", "_")] = int(value)
    if not found:
        raise InputError(
            "no raw category has an NYU40 class here",
            place=path,
            remedy="give scannetv2-labels.combined.tsv",
        )
    return found
