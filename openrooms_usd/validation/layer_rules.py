"""Rules about layers: what each may say, and how they fit together."""

import re
from collections.abc import Iterator
from typing import Final

from pxr import Sdf, UsdGeom

from openrooms_usd.edits.orphans import find_orphans
from openrooms_usd.usd.places.metrics import find_misfits
from openrooms_usd.validation.model import Complaint, Subject

# USD takes these from the root layer alone, so a layer that differs shows something else by itself.
METADATA: Final = (
    "defaultPrim",
    UsdGeom.Tokens.upAxis,
    UsdGeom.Tokens.metersPerUnit,
    "kilogramsPerUnit",
)

_ELSEWHERE = re.compile(r"[/\\]|[A-Za-z]:[/\\]|[A-Za-z][A-Za-z0-9+.-]+:")
# An expression, in backticks, says where the file is only when it is evaluated.
_ANCHORED = re.compile(r"\.{1,2}/|`")


def equal_metadata(subject: Subject) -> Iterator[Complaint]:
    """Every layer of the stack has the root layer's axis, units and default prim."""
    for layer in subject.stack[1:]:
        for key in METADATA:
            here, there = _metadata(layer, key), _metadata(subject.root, key)
            if here != there:
                yield subject.name(layer), f"{key} is {here}, the root layer says {there}"


def _metadata(layer: Sdf.Layer, key: str) -> object:
    root = layer.pseudoRoot
    return root.GetInfo(key) if root.HasInfo(key) else "missing"


def absolute_paths(subject: Subject) -> Iterator[Complaint]:
    """No layer names a file by a place on one machine."""
    for layer, path in subject.asset_paths:
        if _ELSEWHERE.match(path):
            yield subject.name(layer), f"@{path}@ is an absolute path"


def unanchored_paths(subject: Subject) -> Iterator[Complaint]:
    """Every file is named from the layer that names it, and not from a search path."""
    for layer, path in subject.asset_paths:
        if path and not _ELSEWHERE.match(path) and not _ANCHORED.match(path):
            yield subject.name(layer), f"@{path}@ does not start with ./ or ../"


def one_definer(subject: Subject) -> Iterator[Complaint]:
    """A prim is defined by one layer; the others only write over it."""
    definer: dict[Sdf.Path, Sdf.Layer] = {}
    for layer in subject.stack:
        for spec in subject.specs(layer):
            if spec.specifier == Sdf.SpecifierOver:
                continue
            first = definer.setdefault(spec.path, layer)
            if first is not layer:
                yield (
                    str(spec.path),
                    f"defined by {subject.name(first)} and by {subject.name(layer)}",
                )


def nothing_below_instances(subject: Subject) -> Iterator[Complaint]:
    """No layer writes below an instance, where USD drops it without a word."""
    for layer in subject.stack:
        for spec in subject.specs(layer):
            parent = subject.stage.GetPrimAtPath(spec.path.GetParentPath())
            if parent and parent.IsInstance() and not parent.IsInstanceProxy():
                yield str(spec.path), f"{subject.name(layer)} writes below an instance: it is lost"


def no_orphans(subject: Subject) -> Iterator[Complaint]:
    """Every opinion finds what it speaks about; `nothing_below_instances` sees to instances."""
    for layer in subject.stack:
        for orphan in find_orphans(subject.stage, [layer]):
            if orphan.reason != "instance":
                near = f"; near: {orphan.hint}" if orphan.hint else ""
                yield orphan.path, f"{subject.name(layer)} {orphan.message}{near}"


def referenced_units(subject: Subject) -> Iterator[Complaint]:
    """What is referred to has the stage's units and up axis, or operations that correct it."""
    for misfit in find_misfits(subject.stage):
        yield misfit.path, misfit.said
