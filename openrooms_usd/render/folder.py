"""The folder of a run: checked before the long work, and views that appear whole or not at all."""

import json
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from openrooms_usd.atomic import making, naming
from openrooms_usd.channels import CHANNELS, definition
from openrooms_usd.errors import OutputError, writing

MANIFEST: Final = "manifest.json"
TIMING: Final = "timing.json"
SHEET: Final = "contact_sheet.png"
CHANNELS_FILE: Final = "channels.exr"
# What there is of every light.
LIGHTS_FILE: Final = "lights.exr"
# Estimated standard errors, pixel by pixel.
ERRORS_FILE: Final = "errors.exr"
LIGHTS_FOLDER: Final = "lights"
# What the centres of openings see of the surroundings.
OPENINGS_FOLDER: Final = "openings"
# Channels that are also written as plain pictures, for any viewer.
PLAIN_FILES: Final = {"radiance": "radiance.exr", "denoised": "denoised.exr"}


def preview_file(channel: str) -> str:
    """Where a channel's picture lies in the folder of its view."""
    inside = f"{LIGHTS_FOLDER}/" if definition(channel).scope == "light" else ""
    return f"{inside}{channel}.png"


def grid_file(channel: str, *, errors: bool = False) -> str:
    """Where the tiles of a channel of hemispheres lie in the folder of its view."""
    return f"{channel}{'_errors' if errors else ''}.exr"


def opening_file(name: str) -> str:
    """Where the surroundings of an opening lie in the folder of a run."""
    return f"{OPENINGS_FOLDER}/{name}.exr"


def check_writable(out: Path) -> None:
    """See whether files can be made in a folder that may not exist yet; leaves no trace.

    Raises:
        OutputError: They cannot.
    """
    there = out.absolute()
    while not there.exists():
        there = there.parent
    with writing(out), tempfile.TemporaryFile(dir=there):
        pass


def check_space(out: Path, needed: int) -> None:
    """See whether the disk has room for a number of bytes.

    Raises:
        OutputError: It has not.
    """
    there = out.absolute()
    while not there.exists():
        there = there.parent
    free = shutil.disk_usage(there).free
    if free < needed:
        raise OutputError(
            f"one view may need {needed / 1e6:.3g} MB, and {free / 1e6:.3g} MB are free",
            place=out,
            remedy="free space, choose another output folder, or ask for fewer channels",
        )


def check_replaceable(out: Path, views: Iterable[str]) -> None:
    """See that only earlier renders would be replaced, nothing that somebody else put there.

    Raises:
        OutputError: A folder or file of a view's name is not a render.
    """
    for name in views:
        target = out / name
        if target.exists() and not _is_view(target):
            raise OutputError(
                "this is not an earlier render and will not be replaced",
                place=target,
                remedy="choose another output folder, or remove it yourself",
            )


def _is_view(folder: Path) -> bool:
    grids = (grid_file(name) for name, row in CHANNELS.items() if row.scope == "grid")
    return any((folder / file).is_file() for file in (CHANNELS_FILE, LIGHTS_FILE, *grids))


@contextmanager
def replacing_folder(target: Path) -> Iterator[Path]:
    """Give a folder beside ``target`` to fill, and swap it in on success.

    When the block raises, what was written is removed and ``target`` is as it was.

    Args:
        target: The folder that shall appear.

    Yields:
        The empty folder to write to.

    Raises:
        OutputError: It cannot be written.
    """
    beside, old = (target.with_name(f".{target.name}.{word}") for word in ("tmp", "old"))
    with writing(target), making(target.parent), naming(target, beside):
        try:
            _remove(beside)
            beside.mkdir()
            yield beside
            if target.exists():
                target.replace(old)
            beside.replace(target)
        finally:
            if old.exists() and not target.exists():
                old.replace(target)
            _remove(beside)
            _remove(old)


def listed_views(out: Path) -> dict[str, Any]:
    """The views in the manifest of a folder, with their entries; empty without a sound one."""
    try:
        views = json.loads((out / MANIFEST).read_text("utf-8"))["views"]
        return {name: entry for name, entry in views.items() if Path(name).name == name}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def earlier_views(out: Path) -> frozenset[str]:
    """The views that the manifest of an earlier run lists and that lie there; empty without one."""
    return frozenset(name for name in listed_views(out) if _is_view(out / name))


def remove_views(out: Path, views: Iterable[str]) -> None:
    """Remove views of an earlier run that the new manifest does not describe."""
    with writing(out):
        for name in views:
            _remove(out / name)


def _remove(folder: Path) -> None:
    if folder.exists():
        shutil.rmtree(folder)
