"""The files of a scan that lie in folders, as far as a room needs them."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from openrooms_usd.capture import NO_OPTIONS, Packed


def packed_folder(
    root: Path,
    files: Iterable[Path | None],
    options: Mapping[str, str] = NO_OPTIONS,
    name: str | None = None,
    more: Mapping[str, bytes | Path] | None = None,
) -> Packed:
    """Files below a folder, as a folder of the same shape that lies beside a description.

    Args:
        root: The folder.
        files: What of it is needed; None is passed over.
        options: Of the importer that reads them.
        name: Name of the folder there; by default its own.
        more: Further files beside it, by path.
    """
    name = name or root.resolve().name
    inside = {f"{name}/{p.relative_to(root).as_posix()}": p for p in files if p is not None}
    return Packed(name, inside | dict(more or {}), options)


def there(*files: Path) -> list[Path]:
    """The existing ones of some files."""
    return [file for file in files if file.is_file()]
