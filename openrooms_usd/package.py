"""One file of a scene: flattened into a binary layer, or packaged with everything it needs.

Both keep what makes a scene editable: references, payloads, variants, classes and instances. A
package keeps the layers too; it is the scene's folder in one archive.
"""

import posixpath
import zipfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path, PurePosixPath
from typing import Final

from pxr import Ar, Sdf, Usd, UsdUtils

from openrooms_usd import atomic, untrusted
from openrooms_usd.errors import OutputError, StageError
from openrooms_usd.portable import relative_text
from openrooms_usd.scratch import scratch_folder
from openrooms_usd.usd.files import layers
from openrooms_usd.usd.files.diagnostics import reading
from openrooms_usd.usd.outside import is_sublayer_of, refuse_outside

# What the USDZ specification allows: layers, and beside them images and packages as they are.
LAYERS: Final = (".usda", ".usdc", ".usd")
EMBEDDED: Final = (".png", ".jpg", ".jpeg", ".exr", ".avif", ".usdz")
# Nor may it hold these, which a scene can do without: lights shine evenly then.
DISPENSABLE: Final = (".ies",)

# Files in a package start at multiples of this, so that they can be mapped into memory.
_ALIGNMENT: Final = 64
# A zip file's local header without its name, with the header of the padding.
_HEADER: Final = 30 + 4
# The id of the extra field that USD's own writer pads with.
_PADDING: Final = 0x1986
_EPOCH: Final = (1980, 1, 1, 0, 0, 0)


def flatten(scene: Path, target: Path, *, include_outside: bool = False) -> None:
    """Merge the layer stack of a scene into one layer; references and variants stay.

    Args:
        scene: The scene's root layer.
        target: The layer to write. Asset paths in it are relative to its folder.
        include_outside: Whether layers of the stack may lie outside the scene's folder.

    Raises:
        InputError: The scene cannot be read.
        StageError: A layer of the stack lies outside the scene's folder.
        OutputError: The target cannot be written.
    """
    stage = layers.open_stage(scene)
    if not include_outside:
        refuse_outside(stage, target.name, is_sublayer_of(stage))
    with reading(scene):
        flat = UsdUtils.FlattenLayerStack(stage, layers.relative_assets(target.parent), "")
        ordered = _ordered(flat)
    layers.export(ordered, target)


def _ordered(layer: Sdf.Layer) -> Sdf.Layer:
    """The same layer with its fields in the order of their names.

    Flattening leaves them in the order of addresses in memory, which a binary file would keep.
    """
    ordered = Sdf.Layer.CreateAnonymous(".usda")
    ordered.ImportFromString(layer.ExportToString())
    return ordered


def package(
    scene: Path,
    target: Path,
    *,
    include_outside: bool = False,
    edit: Callable[[Sdf.Layer], None] | None = None,
) -> None:
    """Write a scene and all files that it depends on into one USDZ archive.

    Files below the scene's folder keep their place. Files from elsewhere are refused, or, where
    they are asked for, move to ``external/<number>/``, and the layers that name them are rewritten.
    Profiles of lights stay behind, for the format knows no such files.
    The same scene gives the same bytes, wherever it lies and whenever it is packaged.

    Args:
        scene: The scene's root layer.
        target: The ``.usdz`` to write.
        include_outside: Whether files outside the scene's folder go into the archive too.
        edit: Changes the archive's copy of the root layer; None leaves it as it is.

    Raises:
        InputError: The scene, or a file that it needs, cannot be read.
        StageError: A file that it needs is missing, lies outside the scene's folder, or may not be
            in a USDZ archive.
        OutputError: The target cannot be written.
    """
    stage = layers.open_stage(scene)
    if not include_outside:
        refuse_outside(stage, target.name)
    with reading(scene):
        places = _places(_dependencies(stage))
    with atomic.replacing(target) as beside, reading(scene):
        try:
            _write_archive(beside, places, edit)
        except zipfile.LargeZipFile as error:
            raise OutputError(
                "a USDZ archive cannot be larger than 4 GiB",
                place=target,
                remedy="keep the scene as a folder, or use smaller textures",
            ) from error


def _dependencies(stage: Usd.Stage) -> list[Path]:
    """All files of a scene, the root layer first, then by name."""
    root = stage.GetRootLayer()
    used, assets, missing = UsdUtils.ComputeAllDependencies(root.realPath)
    missing = {*missing, *_broken_links(used)}
    if missing:
        raise StageError(
            f"files are missing: {', '.join(sorted(missing))}",
            place=root.realPath,
            remedy="put them back or remove the references; orusd validate lists them",
        )
    names = {*(layer.realPath for layer in used), *assets} - {root.realPath}
    # A file inside a package stands for the whole package.
    outer = {Ar.SplitPackageRelativePathOuter(name)[0] for name in names if not _dispensable(name)}
    files = [Path(root.realPath), *(Path(name) for name in sorted(outer))]
    refused = [path.name for path in files if path.suffix.lower() not in (*LAYERS, *EMBEDDED)]
    if refused:
        raise StageError(
            f"a USDZ archive cannot hold {', '.join(refused)}",
            place=root.realPath,
            remedy="convert textures to PNG, JPEG or EXR",
        )
    return files


def _dispensable(file: str) -> bool:
    return Path(file).suffix.lower() in DISPENSABLE


def _broken_links(layers: Iterable[Sdf.Layer]) -> Iterator[str]:
    """The layers behind links that lead nowhere, which USD takes for found and passes over."""
    for layer in layers:
        for path in layer.GetCompositionAssetDependencies():
            whole = Sdf.ComputeAssetPathRelativeToLayer(layer, path) if path else ""
            file = Path(Ar.SplitPackageRelativePathOuter(whole)[0])
            if file.is_symlink() and not file.exists():
                yield str(file)


def _places(files: Sequence[Path]) -> dict[Path, PurePosixPath]:
    """Where each file goes in the archive, in the order of the archive."""
    home = files[0].parent
    # Numbered by their relative names, so that the numbers do not depend on where the scene lies.
    foreign = sorted(
        {relative_text(file.parent, home) for file in files if not file.is_relative_to(home)}
    )

    def place(file: Path) -> PurePosixPath:
        if file.is_relative_to(home):
            return PurePosixPath(file.relative_to(home).as_posix())
        number = foreign.index(relative_text(file.parent, home))
        return PurePosixPath("external", str(number), file.name)

    return {file: place(file) for file in files}


def _write_archive(
    target: Path, places: dict[Path, PurePosixPath], edit: Callable[[Sdf.Layer], None] | None
) -> None:
    moved = {file.parent: place.parent for file, place in places.items()}
    with target.open("wb") as out, zipfile.ZipFile(out, "w", allowZip64=False) as archive:
        for file, place in places.items():
            data = untrusted.read_bytes(file, _kind(file))
            if file.suffix.lower() in LAYERS:
                data = _relocated(file, data, moved, None if archive.filelist else edit)
            archive.writestr(_entry(str(place), out.tell()), data)


def _kind(file: Path) -> untrusted.Kind:
    if file.suffix.lower() in LAYERS:
        return "usd"
    return "archive" if file.suffix.lower() == ".usdz" else "picture"


def _relocated(
    file: Path,
    data: bytes,
    moved: dict[Path, PurePosixPath],
    edit: Callable[[Sdf.Layer], None] | None,
) -> bytes:
    """A layer's bytes with its asset paths as they are in the archive, edited."""
    layer = Sdf.Layer.FindOrOpen(str(file))
    changed = False

    def rewrite(path: str) -> str:
        nonlocal changed
        if _dispensable(path):
            # An asset without a path does not count.
            changed = True
            return ""
        target = Path(str(Ar.GetResolver().CreateIdentifier(path, layer.resolvedPath)))
        if not path or target.parent not in moved:
            return path
        place = moved[target.parent] / target.name
        text = posixpath.relpath(place, moved[file.parent])
        if text == posixpath.normpath(path):
            return path
        changed = True
        return text if text.startswith("../") else f"./{text}"

    copy = Sdf.Layer.CreateAnonymous(file.suffix)
    copy.TransferContent(layer)
    UsdUtils.ModifyAssetPaths(copy, rewrite)
    if edit is not None:
        edit(copy)
    return _serialised(copy, file.suffix) if changed or edit is not None else data


def _serialised(layer: Sdf.Layer, suffix: str) -> bytes:
    with scratch_folder() as folder:
        path = folder / f"layer{suffix}"
        layers.export(layer, path)
        return path.read_bytes()


def _entry(name: str, offset: int) -> zipfile.ZipInfo:
    """The header of an uncompressed file at ``offset``, padded so that its data is aligned."""
    info = zipfile.ZipInfo(name, _EPOCH)
    info.create_system = 3  # Unix, whatever the machine
    info.external_attr = 0o644 << 16
    room = -(offset + _HEADER + len(name.encode())) % _ALIGNMENT
    info.extra = _PADDING.to_bytes(2, "little") + room.to_bytes(2, "little") + bytes(room)
    return info
