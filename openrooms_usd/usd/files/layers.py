"""Layers: open, stack, split arrays off, save whole.

A stage authors ordinary USD on one stage object. What it wrote is then saved as two files: a light
text layer that people read and edit, and a binary sublayer beside it with the long arrays. The
binary file is named by its content, so that replacing the text layer switches both at once.
"""

import hashlib
import zipfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from pxr import Ar, Sdf, Usd, UsdGeom

from openrooms_usd import atomic, names, removal, unfinished, untrusted
from openrooms_usd.errors import InputError, writing
from openrooms_usd.portable import anchored_text
from openrooms_usd.usd.files import preflight
from openrooms_usd.usd.files.diagnostics import UNREADABLE, reading, reason
from openrooms_usd.usd.places.frames import TIME

# Arrays with more elements than this leave the text layer.
LONG_ARRAY: Final = 24


def apply_metadata(layer: Sdf.Layer) -> None:
    """Write the metadata that every layer of a room carries alike."""
    world = Sdf.Path(names.WORLD)
    layer.defaultPrim = world.name
    root = layer.pseudoRoot
    root.SetInfo(UsdGeom.Tokens.upAxis, names.UP_AXIS)
    root.SetInfo(UsdGeom.Tokens.metersPerUnit, names.METERS_PER_UNIT)
    root.SetInfo("kilogramsPerUnit", names.KILOGRAMS_PER_UNIT)
    custom = dict(layer.customLayerData)
    custom["creator"] = names.CREATOR
    layer.customLayerData = custom


def open_stage(path: Path) -> Usd.Stage:
    """Open a USD stage from disk.

    Raises:
        InputError: The file is missing, is not USD, or is not fit to be opened (`preflight`).
    """
    untrusted.check_path(path)
    if path.suffix.lower() == ".usdz" and path.is_file() and not zipfile.is_zipfile(path):
        # USD reads the first files of an archive that is cut off, and misses the others.
        raise InputError(
            "not a complete USDZ archive", place=path, remedy="copy it again, or export it again"
        )
    # USD caches layers by name as long as they are referenced: they are read once.
    held = preflight.check_stage_file(path, is_whole=True)
    with reading(path):
        stage = Usd.Stage.Open(str(path))
        # What was missing when a stage of before was composed may be there now.
        stage.Reload()
    del held
    return stage


def attribute_specs(layer: Sdf.Layer) -> list[Sdf.AttributeSpec]:
    """Every attribute spec of a layer, in the order of their paths."""
    paths: list[Sdf.Path] = []
    layer.Traverse(Sdf.Path.absoluteRootPath, lambda path: paths.append(path))
    specs = (layer.GetAttributeAtPath(path) for path in sorted(paths) if path.IsPropertyPath())
    return [spec for spec in specs if spec is not None]


def split_arrays(layer: Sdf.Layer) -> Sdf.Layer | None:
    """Move the long arrays of a layer into a new one that shall be its sublayer.

    Args:
        layer: The layer to lighten, in place.

    Returns:
        An anonymous layer that holds only overs with the arrays, or None when there are none.
    """
    long = [
        spec.path
        for spec in attribute_specs(layer)
        if spec.HasDefaultValue() and _length(spec.default) > LONG_ARRAY
    ]
    if not long:
        return None
    arrays = Sdf.Layer.CreateAnonymous(".usdc")
    apply_metadata(arrays)
    for path in long:
        Sdf.CreatePrimInLayer(arrays, path.GetPrimPath())
        Sdf.CopySpec(layer, path, arrays, path)
        owner = layer.GetPrimAtPath(path.GetPrimPath())
        owner.RemoveProperty(layer.GetAttributeAtPath(path))
    return arrays


def _length(value: Any) -> int:
    # Strings have a length too, but they are not arrays.
    return len(value) if hasattr(value, "__len__") and not isinstance(value, str) else 0


def arrays_file(layer: Sdf.Layer, folder: Path) -> Path | None:
    """Move a layer's long arrays into a binary sublayer in a folder beside it.

    Args:
        layer: The authored layer; it is lightened in place.
        folder: Where files that only this layer refers to are kept, beside the layer's file.

    Returns:
        The binary file, or None when the layer has no long arrays.

    Raises:
        OutputError: The file cannot be written.
    """
    arrays = split_arrays(layer)
    if arrays is None:
        return None
    binary = export_by_content(arrays, folder, "arrays", ".usdc")
    layer.subLayerPaths.append(f"./{folder.name}/{binary.name}")
    return binary


def create(path: Path) -> Sdf.Layer:
    """A new layer with a file of its own.

    Raises:
        OSError: The file cannot be written.
    """
    try:
        return Sdf.Layer.CreateNew(str(path))
    except UNREADABLE as error:
        raise OSError(reason(error)) from error


def save(layer: Sdf.Layer) -> None:
    """Save a layer to its own file.

    Raises:
        OSError: The file cannot be written.
    """
    try:
        layer.Save()
    except UNREADABLE as error:
        raise OSError(reason(error)) from error


def export(layer: Sdf.Layer, target: Path) -> None:
    """Export a layer to a file that appears whole or not at all."""
    with atomic.replacing(target) as beside:
        _export(layer, beside)


def export_by_content(layer: Sdf.Layer, folder: Path, stem: str, suffix: str) -> Path:
    """Export a layer under a name that carries the hash of its bytes.

    Returns:
        ``folder/stem-<12 hex digits>suffix``.
    """
    beside = unfinished.beside(folder / f"{stem}{suffix}")
    with writing(folder), atomic.making_folder(folder):
        try:
            _export(layer, beside)
            digest = hashlib.sha256(beside.read_bytes()).hexdigest()[:12]
            target = folder / f"{stem}-{digest}{suffix}"
            atomic.take_places([(beside, target)])
            return target
        finally:
            removal.remove_file(beside)


def _export(layer: Sdf.Layer, path: Path) -> None:
    try:
        done = layer.Export(str(path))
    except UNREADABLE as error:
        raise OSError(reason(error)) from error
    if not done:
        raise OSError("USD could not write the file")


@contextmanager
def stacked(
    target: Sdf.Layer, stronger: Iterable[Path], weaker: Iterable[Path]
) -> Iterator[Usd.Stage]:
    """A stage that shows ``target`` between other layers and writes only to ``target``.

    Args:
        target: The layer that receives every edit.
        stronger: Layer files above it, strongest first; missing files are left out.
        weaker: Layer files below it, strongest first; missing files are left out.

    Yields:
        The composed stage, its edit target set to ``target``.
    """
    above, held = _fresh(stronger)
    below, others = _fresh(weaker)
    stage = _stage([*above, target.identifier, *below])
    del held, others
    stage.SetEditTarget(target)
    yield stage


def stacked_files(stack: Iterable[Path]) -> Usd.Stage:
    """A stage of layer files, strongest first; missing files are left out."""
    files, held = _fresh(stack)
    stage = _stage(files)
    del held
    return stage


def _stage(sublayers: list[str]) -> Usd.Stage:
    root = Sdf.Layer.CreateAnonymous(".usda")
    apply_metadata(root)
    root.subLayerPaths = sublayers
    return Usd.Stage.Open(root)


def _fresh(files: Iterable[Path]) -> tuple[list[str], list[Sdf.Layer]]:
    """The files that are there, read again, and all their layers, to be held until one is open."""
    there = [path for path in files if path.exists()]
    # Layers are cached by path for the whole process: a file may have been replaced since.
    held = [layer for path in there for layer in preflight.check_stage_file(path)]
    return [str(path) for path in there], held


def relative_assets(folder: Path) -> Callable[[Sdf.Layer, str], str]:
    """For `UsdUtils.FlattenLayerStack`: rewrite asset paths relative to ``folder``, anchored.

    Returns:
        A function of (layer, authored path).
    """
    base = folder.resolve()

    def rewrite(layer: Sdf.Layer, path: str) -> str:
        if not path:
            return path
        absolute = Path(str(Ar.GetResolver().CreateIdentifier(path, layer.resolvedPath)))
        if not absolute.is_absolute():
            return path
        return anchored_text(absolute.resolve(), base)

    return rewrite


_MARK: Final = "openrooms_deactivated"


def deactivations(layer: Sdf.Layer, roots: Iterable[str]) -> list[Sdf.PrimSpec]:
    """The prim specs of a layer, also those in variants, that deactivate a prim.

    Args:
        layer: Where to look.
        roots: Only specs at these prim paths and below them.
    """
    paths: list[Sdf.Path] = []
    layer.Traverse(Sdf.Path.absoluteRootPath, lambda path: paths.append(path))
    prefixes = [Sdf.Path(root) for root in roots]
    below = (
        path
        for path in sorted(paths)
        if any(path.StripAllVariantSelections().HasPrefix(prefix) for prefix in prefixes)
    )
    specs = (layer.GetPrimAtPath(path) for path in below if not path.IsPropertyPath())
    return [spec for spec in specs if spec is not None and not spec.active]


def reactivate(specs: Iterable[Sdf.PrimSpec]) -> None:
    """Take the deactivation of prim specs away, and leave a mark for `is_off`."""
    for spec in specs:
        spec.ClearActive()
        spec.customData[_MARK] = True


def prim_specs(layer: Sdf.Layer) -> Iterator[Sdf.PrimSpec]:
    """The prim specs of a layer outside variants, parents before children."""
    waiting = list(reversed(list(layer.rootPrims)))
    while waiting:
        spec = waiting.pop()
        yield spec
        waiting.extend(reversed(list(spec.nameChildren)))


def is_deactivated(stage: Usd.Stage, path: str) -> bool:
    """Whether a prim, one above it or one below it is inactive."""
    prim = stage.GetPrimAtPath(path)
    if prim:
        return any(not part.IsActive() for part in Usd.PrimRange.AllPrims(prim))
    above = filter(None, map(stage.GetPrimAtPath, Sdf.Path(path).GetPrefixes()))
    return any(not prim.IsActive() for prim in above)


def is_off(prim: Usd.Prim) -> bool:
    """Whether a prim itself is deactivated, or was before `reactivate`, or is hidden."""
    if not prim or not prim.IsActive() or prim.GetCustomDataByKey(_MARK):
        return True
    shown = UsdGeom.Imageable(prim).GetVisibilityAttr()
    return bool(shown and shown.Get(TIME) == UsdGeom.Tokens.invisible)
