"""Files whose paths are written for another system: found where their layers are, and told.

Backslashes, drives, ``file://``, ``%20`` and another case lead nowhere here, though the file may
well have been passed on beside the layer that names it.
"""

import os
import unicodedata
from collections.abc import Sequence
from pathlib import Path
from typing import Final
from urllib.parse import unquote

from pxr import Ar, Sdf, Usd

MISSING: Final = "is missing"
"""What stands in each sentence of what is not where a path leads."""

_SCHEME: Final = "file://"


def locate(attribute: Usd.Attribute, asset: object) -> tuple[str, str]:
    """The file of an asset path, and a note to report about it.

    Args:
        attribute: That holds the path.
        asset: Its value.

    Returns:
        The file, empty if it is missing or not named; and a note, empty if all is well.
    """
    authored = str(getattr(asset, "path", "") or "")
    resolved = str(getattr(asset, "resolvedPath", "") or "")
    if resolved or not authored:
        return resolved, ""
    for spec in attribute.GetPropertyStack():
        if found := _beside(spec.layer, attribute.GetStage(), authored):
            return found, f"{authored} {MISSING}; {Path(found).name} beside its layer is used"
    return "", f"{authored} {MISSING}"


def _beside(layer: Sdf.Layer, stage: Usd.Stage, authored: str) -> str:
    """The file that is meant, within the folder of the stage; empty where there is none."""
    if Ar.IsPackageRelativePath(layer.identifier):
        said = _decode(authored)
        return str(Ar.GetResolver().Resolve(Sdf.ComputeAssetPathRelativeToLayer(layer, said)))
    if not layer.realPath:
        return ""
    root = Path(stage.GetRootLayer().realPath or layer.realPath).parent
    return str(meant(Path(layer.realPath).parent, authored, [root]) or "")


def meant(home: Path, name: str, allowed: Sequence[Path]) -> Path | None:
    """The file that a path of another system means; None where there is none.

    Args:
        home: The folder of the file that names it; ends of the path are looked for below it, too.
        name: As it is written there, with slashes of either kind, ``%20`` or a drive.
        allowed: Folders in one of which it must lie, links followed.
    """
    parts = [part for part in _decode(name).split("/") if part not in ("", ".")]
    down = [part for part in parts if part != ".."]
    places = [(_above(home, parts), down), *((home, down[start:]) for start in range(len(down)))]
    found = (_below(folder, names) for folder, names in places)
    whole = [os.path.realpath(folder) for folder in allowed]
    return next((f for f in found if f and is_in(Path(os.path.realpath(f)), whole)), None)


def is_in(path: Path, folders: Sequence[str | Path]) -> bool:
    """Whether a path lies in one of some folders; nothing is looked up."""
    return any(path.is_relative_to(folder) for folder in folders)


def _decode(name: str) -> str:
    return unquote(name.removeprefix(_SCHEME)).replace("\\", "/")


def _above(folder: Path, parts: Sequence[str]) -> Path:
    for part in parts:
        if part != "..":
            break
        folder = folder.parent
    return folder


def _below(folder: Path, names: Sequence[str]) -> Path | None:
    """A file below a folder by names in any case; None where there is none, or they lead above."""
    if ".." in names:
        return None
    try:
        for name in names:
            exact = folder / name
            alike = (one for one in sorted(folder.iterdir()) if _plain(one.name) == _plain(name))
            folder = exact if exact.exists() else next(alike, exact)
        return folder if folder.is_file() else None
    except (OSError, ValueError):
        return None


def _plain(name: str) -> str:
    return unicodedata.normalize("NFC", name).casefold()
