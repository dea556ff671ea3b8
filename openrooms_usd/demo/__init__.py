"""Rooms to begin with: the bundled example with its sky, and a small one to be changed."""

import os
from collections.abc import Mapping
from importlib import resources
from pathlib import Path

from openrooms_usd.atomic import replacing_files, write_bytes
from openrooms_usd.description import schema
from openrooms_usd.errors import OutputError, writing


def copy_example(folder: str | os.PathLike[str]) -> Path:
    """Copy the bundled example, a living room with a sky, into a folder.

    Args:
        folder: Made when it is missing; an example that is there already is kept.

    Returns:
        Its ``room.yaml``.

    Raises:
        OutputError: The folder cannot be written, or holds another file of one of these names.
    """
    folder = Path(folder)
    if not (folder / "room.yaml").is_file():
        bundled = resources.files(__name__)
        files = {name: (bundled / name).read_bytes() for name in ("room.yaml", "sky.exr")}
        # The description's first line points editors to it.
        _write(folder, {**files, schema.FILE: schema.schema_text().encode()})
    return folder / "room.yaml"


def write_starter(folder: Path) -> tuple[Path, Path]:
    """Write a small living room to start from, and the JSON Schema beside it.

    Args:
        folder: Made when it is missing.

    Returns:
        The ``room.yaml`` and the schema.

    Raises:
        OutputError: The folder cannot be written, or holds another file of one of these names.
    """
    starter = resources.files("openrooms_usd.description").joinpath("starter.yaml")
    text = f"{schema.HINT}\n{starter.read_text(encoding='utf-8')}"
    texts = {schema.FILE: schema.schema_text(), "room.yaml": text}
    _write(folder, {name: text.encode() for name, text in texts.items()})
    return folder / "room.yaml", folder / schema.FILE


def _write(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write files to begin with: people change them, so that none gives way."""
    for name, data in files.items():
        path = folder / name
        with writing(path):
            is_same = path.is_file() and path.read_bytes() == data
        if os.path.lexists(path) and not is_same:
            raise OutputError(
                "this file exists already",
                place=path,
                remedy="choose another folder, or move the file away",
            )
    with replacing_files(folder) as beside:
        for name, data in files.items():
            write_bytes(beside / name, data)
