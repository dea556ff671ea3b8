"""Moves what another program saved over ``scene.usda`` into the layer of the edits."""

import os
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import claims, names, untrusted
from openrooms_usd.edits.blender import is_blenders
from openrooms_usd.edits.blender_changes import BlenderDifferences
from openrooms_usd.edits.flattened import Differences
from openrooms_usd.edits.foreign import Foreign, anchored, foreign_to, own_layers, real_path
from openrooms_usd.edits.merging import empty, make_absolute, merged_over, with_sublayers
from openrooms_usd.errors import InputError, StageError
from openrooms_usd.steps import runner
from openrooms_usd.steps.draft import drafting
from openrooms_usd.usd.files.diagnostics import reading
from openrooms_usd.usd.files.layers import open_stage, prim_specs, stacked_files

# What a layer means by saying nothing (UsdGeom).
_FALLBACKS: Final = {UsdGeom.Tokens.upAxis: "Y", UsdGeom.Tokens.metersPerUnit: 0.01}
_OURS: Final = {
    UsdGeom.Tokens.upAxis: names.UP_AXIS,
    UsdGeom.Tokens.metersPerUnit: names.METERS_PER_UNIT,
}


@dataclass(frozen=True)
class Change:
    """What the edits now say about a prim.

    Attributes:
        path: The prim.
        new: Whether it is a new prim.
        fields: The properties and metadata that are said.
    """

    path: str
    new: bool
    fields: tuple[str, ...]


@dataclass(frozen=True)
class Adoption:
    """What was moved, or would be.

    Attributes:
        edits: The layer that receives it.
        changes: What was said in the saved file, prim by prim.
        left: Sentences about what was not moved.
        compared: How many values of a flattened file were compared; 0 for others.
        written: Whether files were written.
    """

    edits: Path
    changes: tuple[Change, ...] = ()
    left: tuple[str, ...] = ()
    compared: int = 0
    written: bool = False

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for ``--json``."""
        return {**asdict(self), "edits": str(self.edits)}


def adopt(scene: Path, saved: Path | None = None, *, dry_run: bool = False) -> Adoption:
    """Move what another program saved into ``layers/edits.usda``.

    What is moved is stronger than what the edits say already. A file that was flattened is compared
    with the composed stage, and only what differs is moved. Both files change together or not at
    all; a second call finds nothing.

    Args:
        scene: The ``scene.usda`` of a composed room. It is restored to what compose writes.
        saved: What the other program saved, where it lies elsewhere; ``scene`` then stays.
        dry_run: Write nothing.

    Raises:
        InputError: A file is missing, or is not USD.
        StageError: It is not a version of this scene, has other axes or units, or would not
            compose.
        OutputError: The layers cannot be written.
    """
    _check_name(scene)
    # What a killed call has left is swept also where there is nothing to move any more.
    alone = claims.claimed(scene.parent) if scene.is_file() and not dry_run else nullcontext()
    with alone, reading(saved or scene):
        return _adopted(scene, saved, dry_run=dry_run)


def _adopted(scene: Path, saved: Path | None, *, dry_run: bool) -> Adoption:
    out, source = scene.parent, saved or scene
    edits = out / names.LAYERS / f"{names.EDITS}.usda"
    stage = open_stage(source)
    layer = stage.GetRootLayer()
    foreign = foreign_to(layer, out)
    if not foreign:
        return Adoption(edits)
    _check_room(out)
    base = stacked_files(own_layers(out))
    blenders = is_blenders(layer)
    flattened = blenders or _is_flattened(layer, base, out, source)
    _check_frame(layer, source, flattened)
    differences = (BlenderDifferences if blenders else Differences)(stage, base)
    if flattened:
        differences.find()
    # A flattened file holds its layers; others are beside what it says itself.
    opinions = differences.opinions if flattened else with_sublayers(layer, foreign, source)
    make_absolute(opinions, layer)
    _only_over(opinions, base)
    outside: dict[str, None] = {}
    merged = merged_over(opinions, edits, outside)
    changes = tuple(_changes(opinions, base))
    left = (
        *differences.left,
        *(() if blenders else _list_ignored(foreign, layer)),
        *_outside(outside, out),
    )
    adoption = Adoption(edits, changes, left, differences.compared)
    same = merged.ExportToString() == merged_over(empty(), edits, {}).ExportToString()
    if dry_run or (same and saved):
        return adoption
    with drafting(out) as draft:
        if not same:
            draft.export(merged, names.EDITS)
        if not saved:
            runner.write_scene(draft)
        runner.check(draft)
    return Adoption(edits, changes, left, differences.compared, written=True)


def _check_name(scene: Path) -> None:
    """Refuse what is not the file that is restored at the end: that one may say more."""
    untrusted.check_path(scene)
    if scene.name != names.SCENE:
        raise InputError(
            f"this is not a {names.SCENE} of a room",
            place=scene,
            remedy=f"orusd edit import-changes OUT/{names.SCENE} --from {scene}",
        )


def _check_room(out: Path) -> None:
    # Settled poses exist only after a simulation.
    needed = [path for path in own_layers(out) if path.stem != names.SETTLED]
    missing = [path for path in needed if not path.is_file()]
    if missing:
        raise StageError(
            f"this is not a composed room: {missing[0].name} is missing",
            place=out / names.LAYERS,
            remedy="name the scene.usda in the folder that orusd compose wrote",
        )
    open_stage(own_layers(out)[0])


def _is_flattened(layer: Sdf.Layer, base: Usd.Stage, out: Path, source: Path) -> bool:
    """Whether a layer holds the whole room itself, instead of stacking our layers."""
    ours = {str(path) for path in own_layers(out)}
    if any(real_path(anchored(layer, path)) in ours for path in layer.subLayerPaths):
        return False
    if layer.rootPrims and not any(base.GetPrimAtPath(spec.path) for spec in layer.rootPrims):
        raise StageError(
            f"this is not a saved version of the scene: it has no {names.WORLD}, but "
            f"{', '.join(str(spec.path) for spec in list(layer.rootPrims)[:3])}",
            place=source,
            remedy="programs that rewrite USD lose its layers: export only what is new, and "
            f"refer to it in {names.LAYERS}/{names.EDITS}.usda",
        )
    # An anonymous stage of one layer: sublayers of other names may hold the room as well.
    rooms = (layer.GetPrimAtPath(path) for path in (names.ROOM, names.FURNITURE))
    return any(spec is not None and spec.specifier == Sdf.SpecifierDef for spec in rooms)


def _check_frame(layer: Sdf.Layer, source: Path, flattened: bool) -> None:
    """Reject other axes and units: it is unknown which values are in them."""
    root = layer.pseudoRoot
    for key, ours in _OURS.items():
        silent = _FALLBACKS[key] if flattened else ours
        found = root.GetInfo(key) if root.HasInfo(key) else silent
        if found != ours:
            raise StageError(
                f"it was saved with {key} = {found}, but the room has {ours}",
                place=source,
                remedy="save it with Z up and in metres (metersPerUnit = 1); nothing was changed",
            )


def _only_over(opinions: Sdf.Layer, base: Usd.Stage) -> None:
    """Let a layer define nothing that the room has already: each prim has one definer."""
    for spec in prim_specs(opinions):
        known = base.GetPrimAtPath(spec.path)
        if known and known.IsDefined() and spec.specifier == Sdf.SpecifierDef:
            spec.specifier = Sdf.SpecifierOver
            if spec.typeName == known.GetTypeName():
                spec.typeName = ""


def _changes(opinions: Sdf.Layer, base: Usd.Stage) -> Iterator[Change]:
    """What a layer says, prim by prim."""
    for spec in prim_specs(opinions):
        fields = (
            *(found.name for found in spec.properties),
            *sorted(set(spec.ListInfoKeys()) - {"specifier"}),
        )
        known = base.GetPrimAtPath(spec.path)
        if fields or not known:
            yield Change(str(spec.path), not known, fields)


def _list_ignored(foreign: Foreign, layer: Sdf.Layer) -> Iterator[str]:
    if foreign.metadata:
        yield f"metadata of the file is not adopted: {', '.join(foreign.metadata)}"
    if layer.HasStartTimeCode():
        yield "the room is static: animated values keep their first time sample"


def _outside(paths: dict[str, None], out: Path) -> Iterator[str]:
    home = f"{out.resolve()}{os.sep}"
    for path in sorted(paths):
        if not Path(path).exists():
            yield f"{path} is missing"
        elif not real_path(path).startswith(home):
            yield f"{path} is outside the room's folder: copy it there to move both together"
