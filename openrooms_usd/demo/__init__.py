"""Rooms to begin with: the bundled example with its sky, and a small one to be changed."""

import os
from importlib import resources
from pathlib import Path

from openrooms_usd.atomic import filling, write_text
from openrooms_usd.description import schema
from openrooms_usd.errors import OutputError


def copy_example(folder: str | os.PathLike[str]) -> Path:
    """Copy the bundled example, a living room with a sky, into a folder.

    Args:
        folder: Made when it is missing; an example that is there already is kept.

    Returns:
        Its ``room.yaml``.

    Raises:
        OutputError: The folder cannot be written.
    """
    folder = Path(folder)
    if (folder / "room.yaml").is_file():
        return folder / "room.yaml"
    bundled = resources.files(__name__)
    with filling(folder) as beside:
        for name in ("room.yaml", "sky.exr"):
            (beside / name).write_bytes((bundled / name).read_bytes())
        # The description's first line points editors to it.
        (beside / schema.FILE).write_text(schema.schema_text(), encoding="utf-8")
    return folder / "room.yaml"


def write_starter(folder: Path) -> tuple[Path, Path]:
    """Write a small living room to start from, and the JSON Schema beside it.

    Args:
        folder: Made when it is missing.

    Returns:
        The ``room.yaml`` and the schema.

    Raises:
        OutputError: The folder cannot be written, or one of them is there already.
    """
    starter = resources.files("openrooms_usd.description").joinpath("starter.yaml")
    texts = {
        schema.FILE: schema.schema_text(),
        "room.yaml": f"{schema.HINT}\n{starter.read_text(encoding='utf-8')}",
    }
    for name in texts:
        if (folder / name).exists():
            raise OutputError(
                "this file exists already",
                place=folder / name,
                remedy="choose another folder, or move the file away",
            )
    with filling(folder) as beside:
        for name, text in texts.items():
            write_text(beside / name, text)
    return folder / "room.yaml", folder / schema.FILE
