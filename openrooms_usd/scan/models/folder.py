"""Reads a folder of CADs: meshes of common formats, and what its ``index.json`` says of them."""

import json
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeVar

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.scan.models.cad import Symmetry, Up

Known = TypeVar("Known")

INDEX: Final = "index.json"
# Spellings without case: ours, the group's, and Scan2CAD's.
_SYMMETRIES: Final[dict[str, Symmetry]] = {
    **dict.fromkeys(("none", "1", "c1", "__sym_none"), "none"),
    **dict.fromkeys(("2", "c2", "__sym_rotate_up_2"), "2"),
    **dict.fromkeys(("4", "c4", "__sym_rotate_up_4"), "4"),
    **dict.fromkeys(("inf", "cinf", "__sym_rotate_up_inf"), "inf"),
}
_UPS: Final[dict[str, Up]] = {"x": "X", "y": "Y", "z": "Z"}


@dataclass(frozen=True)
class CadFile:
    """A mesh file of a folder of CADs, and what the folder's index says of it.

    Attributes:
        id: What hints and reports call it.
        path: The file.
        category: By the index, else the name of its folder; empty in the folder itself.
        symmetry: About its vertical; None where nobody says it.
        up: Its vertical axis; None where nobody says it.
        entry: All that the index says.
    """

    id: str
    path: Path
    category: str
    symmetry: Symmetry | None
    up: Up | None
    entry: Mapping[str, Any]


def cad_files(folder: Path, suffixes: Collection[str]) -> tuple[CadFile, ...]:
    """The mesh files of a folder and of those below it, by id.

    A CAD's id is the name of its file without suffix; where several have the same (as ShapeNet's
    ``model_normalized``), it is the first folder above that tells them apart. ``index.json`` may
    give, by id or path, a category, or ``{category, symmetry, up}``. Those that it does not name
    have the category of their folder.

    Args:
        folder: The folder.
        suffixes: Of the files that count, in lower case.

    Raises:
        InputError: The folder or the index cannot be read.
    """
    untrusted.check_path(folder)
    if not folder.is_dir():
        raise InputError("no such folder of CADs", place=folder, remedy="check alignment.cad")
    index = _read_index(folder / INDEX)
    return tuple(
        _described(folder, path, name, _entry(index, folder, path, name))
        for name, path in sorted(_named(folder, suffixes).items())
    )


def _described(folder: Path, path: Path, name: str, entry: Mapping[str, Any]) -> CadFile:
    parent = path.parent.name if path.parent != folder else ""
    return CadFile(
        name,
        path,
        str(entry.get("category", parent)),
        _chosen(_SYMMETRIES, entry, "symmetry", folder),
        _chosen(_UPS, entry, "up", folder),
        entry,
    )


def _named(folder: Path, suffixes: Collection[str]) -> dict[str, Path]:
    paths = sorted(path for path in folder.rglob("*") if path.suffix.lower() in suffixes)
    paths = [path for path in paths if path.is_file()]
    names = {path: path.relative_to(folder).with_suffix("").parts for path in paths}
    stems = Counter(parts[-1] for parts in names.values())
    return {
        parts[-1] if stems[parts[-1]] == 1 else _distinct(parts, names.values()): path
        for path, parts in names.items()
    }


def _distinct(parts: tuple[str, ...], all_parts: Collection[tuple[str, ...]]) -> str:
    """The innermost folder that no other CAD of the same name lies in, else the whole path."""
    same = [other for other in all_parts if other[-1] == parts[-1] and other != parts]
    for folder in reversed(parts[:-1]):
        if all(folder not in other[:-1] for other in same):
            return folder
    return "/".join(parts)


def _read_index(path: Path) -> Mapping[str, Any]:
    if not path.exists():
        return {}
    try:
        index = json.loads(untrusted.read_text(path, "json"))
    except (ValueError, RecursionError) as error:
        raise InputError(
            f"the index of the CADs cannot be read: {error}", place=path, remedy="mend the JSON"
        ) from error
    if not isinstance(index, dict):
        raise InputError(
            "the index of the CADs is no object",
            place=path,
            remedy='write {"<id>": {"category": "chair", "symmetry": "none"}}',
        )
    return index


def _entry(index: Mapping[str, Any], folder: Path, path: Path, name: str) -> Mapping[str, Any]:
    """What the index says of a CAD."""
    relative = path.relative_to(folder)
    for key in _keys(relative, name):
        if key in index:
            entry = index[key]
            if isinstance(entry, str):
                return {"category": entry}
            if isinstance(entry, dict):
                return entry
            raise InputError(
                f"the entry of {key!r} is neither a category nor an object",
                place=folder / INDEX,
                remedy='write {"category": "chair", "symmetry": "none"}',
            )
    return {}


def _keys(relative: Path, name: str) -> Iterator[str]:
    yield name
    yield relative.as_posix()
    yield relative.with_suffix("").as_posix()
    yield relative.name


def _chosen(
    table: Mapping[str, Known], entry: Mapping[str, Any], key: str, folder: Path
) -> Known | None:
    value = entry.get(key)
    if value is None:
        return None
    found = table.get(str(value).lower())
    if found is None:
        raise InputError(
            f"{key} {value!r} is not known",
            place=folder / INDEX,
            remedy=f"write one of: {', '.join(sorted({str(v) for v in table.values()}))}",
        )
    return found
