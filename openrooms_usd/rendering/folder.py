"""The folder of a run: checked before the long work, and views that appear whole or not at all."""

import json
import os
import shutil
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final

from openrooms_usd import atomic
from openrooms_usd.channels import CHANNELS, definition
from openrooms_usd.errors import InputError, OutputError, writing
from openrooms_usd.ledger import Ledger
from openrooms_usd.names import CREATOR, LAYERS
from openrooms_usd.untrusted import is_plain_name, read_text

MANIFEST: Final = "manifest.json"
TIMING: Final = "timing.json"
SHEET: Final = "contact_sheet.png"
CHANNELS_FILE: Final = "channels.exr"
# What there is of every light.
LIGHTS_FILE: Final = "lights.exr"
# Of compact storage: channels of light, which CHANNELS_FILE has otherwise, and masks of lights.
LIGHT_FILE: Final = "light.exr"
MASKS_FILE: Final = "masks.exr"
# Denoised versions of channels of light, and of those of every light.
DENOISED_FILES: Final = (("denoised_channels.exr", "view"), ("denoised_lights.exr", "light"))
# Estimated standard errors, pixel by pixel.
ERRORS_FILE: Final = "errors.exr"
LIGHTS_FOLDER: Final = "lights"
# What the centres of openings see of the surroundings.
OPENINGS_FOLDER: Final = "openings"
_TOP_FILES: Final = (MANIFEST, TIMING, SHEET)
# Folders of these names are not views: a room may lie in the same folder.
_TAKEN: Final = (OPENINGS_FOLDER, LAYERS, LIGHTS_FOLDER)
# Channels that are also written as plain pictures, for any viewer.
PLAIN_FILES: Final = {"radiance": "radiance.exr", "denoised": "denoised.exr"}
# Those that people have a picture of in compact storage, too.
PREVIEWED: Final = ("radiance", "denoised", "instance")


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
    with writing(out), tempfile.TemporaryFile(dir=_nearest(out)):
        pass


def check_space(out: Path, needed: int) -> None:
    """See whether the disk has room for a number of bytes.

    Raises:
        OutputError: It has not.
    """
    with writing(out):
        free = shutil.disk_usage(_nearest(out)).free
    if free < needed:
        raise OutputError(
            f"one view may need {needed / 1e6:.3g} MB, and {free / 1e6:.3g} MB are free",
            place=out,
            remedy="free space, choose another output folder, or ask for fewer channels",
        )


def _nearest(out: Path) -> Path:
    """The folder itself, or the first one above it that is there."""
    there = out.absolute()
    while True:
        try:
            there.lstat()
        except (FileNotFoundError, NotADirectoryError):
            if there == there.parent:  # a drive that is not there
                raise
            there = there.parent
        else:
            return there


def check_view_names(out: Path, views: Iterable[str]) -> None:
    """See that views can have folders of these names, and that none leads elsewhere.

    Raises:
        OutputError: A name is that of something else, or not one of a folder.
    """
    for name in views:
        taken = name in _TAKEN
        if taken or not is_plain_name(name) or name.startswith("."):
            reason = "that folder is reserved" if taken else "it is not a valid name"
            raise OutputError(
                f"a view cannot be named {name!r}: {reason}",
                place=out,
                remedy="give the camera another name, without / and not beginning with a dot",
            )


def check_replaceable(out: Path, views: Iterable[str]) -> None:
    """Check that only earlier renders would be replaced, not other files.

    Args:
        out: The folder of the run, which this process has claimed.
        views: The names of the views to be.

    Raises:
        OutputError: What has the name of a view, or of a list beside them, was not written so by
            an earlier run.
    """
    check_view_names(out, views)
    for name in _TOP_FILES:
        atomic.check_replaceable(out / name)
    atomic.check_free(out / name for name in (*_TOP_FILES, *views, OPENINGS_FOLDER))


# At least one of them is in every view.
_EXACT_FILES: Final = (
    CHANNELS_FILE,
    LIGHTS_FILE,
    LIGHT_FILE,
    *(grid_file(name) for name, row in CHANNELS.items() if row.scope == "grid"),
)


def _is_view(folder: Path) -> bool:
    return any((folder / file).is_file() for file in _EXACT_FILES)


def load_manifest(folder: Path) -> tuple[str, dict[str, Any]]:
    """The text of a manifest and the JSON object that it is, otherwise unchecked.

    Raises:
        InputError: It is missing, or is not the JSON object of a render with views.
    """
    text, found = _load(folder)
    if not isinstance(found.get("views"), dict) or not found["views"]:
        place = folder / MANIFEST
        raise InputError("the render has no finished view", place=place, remedy="render again")
    return text, found


def _load(folder: Path) -> tuple[str, dict[str, Any]]:
    path, remedy = folder / MANIFEST, "give a folder that 'orusd render' wrote"
    if not os.path.lexists(path):
        raise InputError(
            "this is not a finished render",
            place=folder,
            remedy=f"{remedy}: it holds a {MANIFEST} with views",
        )
    text = read_text(path, "annotations", remedy=remedy)
    try:
        found = json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise InputError(f"not readable as JSON: {error}", place=path, remedy=remedy) from error
    if not isinstance(found, dict) or not str(found.get("generator", "")).startswith(CREATOR):
        raise InputError("this is not the manifest of a render", place=path, remedy=remedy)
    return text, found


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is not a JSON number")


def is_render_manifest(folder: Path) -> bool:
    """Whether the manifest in a folder is that of a render."""
    try:
        load_manifest(folder)
    except InputError:
        return False
    return True


def listed_views(out: Path) -> dict[str, Any]:
    """The views in the manifest of a render in a folder, with their entries, unchecked.

    Empty where no render wrote it; names that no folder can have are left out.
    """
    views = load_manifest(out)[1]["views"] if is_render_manifest(out) else {}
    named = views.items() if isinstance(views, dict) else ()
    return {name: entry for name, entry in named if is_plain_name(name)}


def earlier_views(out: Path, written: Ledger) -> frozenset[str]:
    """The views of earlier runs: those that the manifest lists, and those that the ledger knows.

    A run that was killed may have listed its own views and not yet removed all of the earlier ones.
    """
    listed = {name for name in listed_views(out) if _is_view(out / name)}
    exact = (path.relative_to(written.folder) for path in written.below(out))
    known = {path.parts[0] for path in exact if path.name in _EXACT_FILES}
    return frozenset({*listed, *known} - {*_TAKEN})


def remove_views(out: Path, views: Iterable[str], written: Ledger) -> list[Path]:
    """Remove views of an earlier run that the new manifest does not describe.

    Args:
        out: The folder of the run.
        views: Their names.
        written: The folder's ledger.

    Returns:
        What stays, because no earlier run wrote it as it is now.

    Raises:
        OutputError: A file cannot be removed.
    """
    stay = []
    with writing(out):
        for name in sorted(views):
            written.remove(written.below(out / name))
            if os.path.lexists(out / name):
                stay.append(out / name)
    return stay
