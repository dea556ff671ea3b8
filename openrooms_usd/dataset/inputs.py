"""What else than its own text a room.yaml depends on: scans, models, textures, panoramas."""

import hashlib
import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from openrooms_usd.description import load_room
from openrooms_usd.errors import InputError, OrusdError
from openrooms_usd.untrusted import check_path, opened


def file_digest(path: Path) -> str:
    """The SHA-256 of a file.

    Raises:
        InputError: It is not there, or cannot be read.
    """
    remedy = "names of files in a dataset.yaml begin in its folder"
    with opened(path, "frames", remedy=remedy) as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def capture_digest(folder: Path, file: str, options: Mapping[str, str]) -> str:
    """A digest of a capture, and of the files that its importer's options name.

    Args:
        folder: Where names of files begin.
        file: What the importer reads; of a folder the names and the sizes of its files count, for
            it may hold gigabytes.
        options: What is asked of the importer.

    Raises:
        InputError: It is not there, or cannot be read.
    """
    root = folder / file
    check_path(root)
    if not root.is_dir():
        own = file_digest(root)
    else:
        found = sorted(path for path in root.rglob("*") if path.is_file())
        rows = [(path.relative_to(root).as_posix(), path.stat().st_size) for path in found]
        own = hashlib.sha256(json.dumps(rows).encode()).hexdigest()
    named = [folder / value for _, value in sorted(options.items()) if _is_file(folder / value)]
    digests = [own, *map(file_digest, named)]
    return own if not named else hashlib.sha256(json.dumps(digests).encode()).hexdigest()


def _is_file(path: Path) -> bool:
    """Whether a value names a file; most are something else."""
    with suppress(InputError):
        check_path(path)
        return path.is_file()
    return False


def inputs_digest(description: Path) -> str | None:
    """A digest of all files that a room is made of because its room.yaml names them.

    Args:
        description: The room.yaml.

    Returns:
        None where there are none; and where the room.yaml is wrong or a file is missing, which is
        said when the room's turn comes.
    """
    from openrooms_usd.stages import runner

    with suppress(OrusdError):
        room, folder = load_room(description), description.parent
        names = sorted({name for stage in runner.stages() for name in stage.inputs(room, folder)})
        digest = hashlib.sha256()
        for name in names:
            digest.update(f"{file_digest(folder / name)}  {name}\n".encode())
        return digest.hexdigest() if names else None
    return None
