"""ScanNet's annotation of a mesh: class and instance of each vertex."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Ints
from openrooms_usd.errors import InputError
from openrooms_usd.usd.semantics import NYU40
from orusd_scans.formats.ply import read_ply
from orusd_scans.records import Node, read_json, read_table, text

# The column of the raw names, in new and in old releases.
_RAW: Final = ("raw_category", "category")
# Columns of the WordNet synset's key, such as ashcan.n.01, and of the class in words.
_SYNSET: Final = "wnsynsetkey"
_CLASS: Final = "nyu40class"
# More numbers beyond the classes are those of an old release, and no damage.
_MOST_WRONG_SHARE: Final = 1e-3


@dataclass(frozen=True, eq=False)
class Annotation:
    """What is known of a mesh.

    Attributes:
        label: (N,) NYU40 class of each vertex; 0 where there is none; None if unknown.
        instance: (N,) number of each vertex's object; 0 where there is none; None if unknown.
        words: For each object: its name, then its synset and class by the table.
    """

    label: NDArray[np.int32] | None
    instance: NDArray[np.int32] | None
    words: Mapping[int, tuple[str, ...]] | None = None


def read_annotation(
    count: int,
    segments: Path | None,
    aggregation: Path | None,
    labelled: Path | None,
    table: Path | None,
    notes: list[str],
) -> Annotation:
    """Read the annotation of a mesh.

    Classes come from the table, else from the labelled mesh, else from those names of the objects
    that are names of NYU40.

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
    label = None if labelled is None else _labelled(labelled, count, table is not None, notes)
    if segments is None or aggregation is None:
        if label is None:
            notes.append("the scene has no segments and no labels: its points have no classes")
        return Annotation(label, None)
    owners = _segments(segments, count)
    objects = _objects(aggregation)
    instance = np.zeros(count, np.int32)
    classes = np.zeros(count, np.int32) if label is None else label.copy()
    known = _classes(table) if table is not None else _NYU40
    for one in objects:
        rows = np.isin(owners, one.segments)
        instance[rows] = one.number
        if one.name in known and (label is None or table is not None):
            classes[rows] = known[one.name].number
    if table is None and label is None and (unknown := {one.name for one in objects} - {*known}):
        notes.append(
            f"{len(unknown)} names of objects have no class (such as {min(unknown)!r}): they are "
            "known by these words alone; scannetv2-labels.combined.tsv beside the scene says more"
        )
    words = {o.number: (o.name, *(known[o.name].words if o.name in known else ())) for o in objects}
    return Annotation(classes, instance, words)


class _Class(NamedTuple):
    """What the table says of a name."""

    number: int
    words: tuple[str, ...] = ()


_NYU40: Final = {name.replace("_", " "): _Class(n) for n, name in enumerate(NYU40)}


@dataclass(frozen=True, eq=False)
class _Object:
    """A group of segments."""

    number: int
    name: str
    segments: Ints


def _labelled(
    path: Path, count: int, has_table: bool, notes: list[str]
) -> NDArray[np.int32] | None:
    """The classes of the labelled mesh; None where it has other numbers, as old releases wrote."""
    scanned = read_ply(path)
    label = scanned.cloud.label
    if label is None or len(label) != count:
        raise InputError(
            "this is not the labelled mesh of the scene: its vertices differ",
            place=path,
            remedy="use both meshes from one release",
        )
    others = label >= len(NYU40)
    if not others.any():
        return label
    if others.mean() <= _MOST_WRONG_SHARE:
        notes.append(f"{others.sum():,} labels of {path.name} are not classes: left out")
        return np.where(others, 0, label).astype(np.int32)
    if not has_table:
        notes.append("the labelled mesh has the numbers of an old release: it was left out")
    return None


def _segments(path: Path, count: int) -> Ints:
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
            raise number.error("this object exists already", "correct the aggregation")
        numbers.add(value)
        name = " ".join(text(node.need("label")).lower().replace("_", " ").split())
        found.append(_Object(value, name, _whole_numbers(node.need("segments"))))
    return found


def _whole_numbers(node: Node) -> Ints:
    values: Any = node.value
    ok = isinstance(values, list) and all(type(v) is int and 0 <= v < 1 << 31 for v in values)
    if not ok:
        raise node.error("a list of whole numbers expected", "download the scene again")
    return np.array(values, dtype=np.int64)


def _classes(path: Path) -> Mapping[str, _Class]:
    """The NYU40 class of each raw name, and its WordNet synset's first word."""
    rows = read_table(path, ("nyu40id",), (*_RAW, _SYNSET, _CLASS))
    found: dict[str, _Class] = {}
    for row in rows:
        name = next((node for key in _RAW if (node := row.get(key)) is not None), None)
        number = row.get("nyu40id")
        if name is not None and number is not None:
            value = number.numbers(1, len(NYU40) - 1)[0]
            synset, kind = (
                text(node) if (node := row.get(key)) else "" for key in (_SYNSET, _CLASS)
            )
            said = tuple(
                word.replace("_", " ") for word in (synset.partition(".")[0], kind) if word
            )
            raw = " ".join(text(name).lower().replace("_", " ").split())
            found[raw] = _Class(int(value), said)
    if not found:
        raise InputError(
            "no raw category has an NYU40 class here",
            place=path,
            remedy="give scannetv2-labels.combined.tsv",
        )
    return found
