"""What a run shall render: which channels, which cameras, and about how many paths that takes."""

import math
import re
from collections.abc import Mapping, Sequence
from typing import Final

from openrooms_usd.channels import CHANNELS, FLOWS
from openrooms_usd.description.rendering import ALL, DEFAULT_SAMPLES, USUAL
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.hemisphere import HEMISPHERE
from openrooms_usd.names import CAMERAS, SPARE_CAMERA
from openrooms_usd.portable import RESERVED
from openrooms_usd.rendering.contract import RenderRequest
from openrooms_usd.rendering.denoise import DENOISED
from openrooms_usd.rendering.given import remedy_for
from openrooms_usd.spelling import did_you_mean

FRAMING: Final = "framing"  # the view's name where a stage has no camera and the scene is framed

_SPARE: Final = re.compile(rf"{CAMERAS}/{SPARE_CAMERA}_\d+")
# What is never asked for by its channel's name, and what to do instead.
_MADE: Final = {
    DENOISED: "add --denoise instead",
    **dict.fromkeys(FLOWS, "the frames of a path have it: `views: {from: path}` in a dataset.yaml"),
}
# One of a hemisphere's cell is taken for so many of a pixel.
_SAMPLES_PER_CELL_SAMPLE: Final = 16


def paths_of(request: RenderRequest, views: int) -> float:
    """About how many paths a render follows, for `openrooms_usd.rendering.given.choose_method`.

    Args:
        request: For each view, with its size.
        views: How many there are.
    """
    lit = [CHANNELS[name].scope for name in request.channels if CHANNELS[name].kind == "light"]
    # Views that stop by error or time: the default number.
    samples = request.samples or DEFAULT_SAMPLES
    pixels = request.width * request.height if any(scope != "grid" for scope in lit) else 0
    points = math.prod(request.grid) if "grid" in lit else 0
    cells = HEMISPHERE.count * max(1, samples // _SAMPLES_PER_CELL_SAMPLE)
    return float(views * (pixels * samples + points * cells))


def choose_channels(asked: Sequence[str] | None, given: Sequence[str]) -> tuple[str, ...]:
    """The channels to render, in the order of the table.

    Args:
        asked: Names; None or `USUAL` for what need not be asked for, `ALL` for all that is given.
        given: What the renderer gives, and what can be made of it.

    Raises:
        InputError: A name is unknown, or the renderer cannot give it.
    """
    if asked is None:
        return tuple(name for name, row in CHANNELS.items() if name in given and not row.extra)
    if ALL in asked:
        return tuple(name for name in CHANNELS if name in given)
    if USUAL in asked:
        usual = choose_channels(None, given)
        return choose_channels([*usual, *(name for name in asked if name != USUAL)], given)
    for name in asked:
        if name not in CHANNELS:
            raise InputError(
                f"no channel is named {name!r}{did_you_mean(name, CHANNELS)}",
                place="channels",
                remedy=f"there are: {', '.join(CHANNELS)}",
            )
        if name in _MADE:
            raise InputError(
                f"the channel {name!r} is computed from others",
                place="channels",
                remedy=_MADE[name],
            )
        if name not in given:
            raise InputError(
                f"this renderer does not give the channel {name!r}",
                place="channels",
                remedy=f"{remedy_for(name)}; this one gives: {', '.join(given)}",
            )
    if not asked:
        raise InputError("no channel is requested", place="channels", remedy="orusd channels")
    return tuple(name for name in CHANNELS if name in asked)


def view_names(cameras: Sequence[str]) -> dict[str, str]:
    """A short file name for every camera: the prim's name where it is the only one, else its path.

    A path is written with dots, which no prim's name contains. Names that differ only in case
    count as equal, because some file systems think so. So is one that Windows keeps for devices.

    Args:
        cameras: Prim paths.

    Returns:
        Name by prim path, such as ``camera_0`` or ``World.Cameras.left``.
    """
    short = {path: path.rpartition("/")[2] for path in cameras}
    folded = [name.casefold() for name in short.values()]
    return {
        path: name
        if folded.count(name.casefold()) == 1 and name.casefold() not in RESERVED
        else path.strip("/").replace("/", ".")
        for path, name in short.items()
    }


def is_spare(camera: str) -> bool:
    """Whether a camera, by its prim path, is one that a room keeps in case another is of no use."""
    return _SPARE.fullmatch(camera) is not None


def choose_cameras(
    asked: Sequence[str], cameras: Sequence[str], *, spares: bool = False
) -> dict[str, str | None]:
    """The views to render, in the order asked for.

    Args:
        asked: Names or prim paths; all cameras where empty, but for the spare ones.
        cameras: The stage's cameras, as prim paths.
        spares: Whether spare cameras are among all.

    Returns:
        Prim path by view name; the framing camera, without a path, where the stage has none.

    Raises:
        InputError: A name fits no camera, or several.
    """
    names = view_names(cameras)
    if not cameras and not asked:
        return {FRAMING: None}
    usual = [path for path in cameras if spares or not is_spare(path)] or cameras
    chosen = [_find(text, names) for text in asked] if asked else usual
    return {names[path]: path for path in chosen}


def _find(text: str, names: Mapping[str, str]) -> str:
    found = [path for path, name in names.items() if text in (path, name, path.rpartition("/")[2])]
    if len(found) == 1:
        return found[0]
    if found:
        raise InputError(
            f"{len(found)} cameras are named {text!r}",
            place="camera",
            remedy=f"give a path: {', '.join(found)}",
        )
    raise InputError(
        f"no camera is named {text!r}{did_you_mean(text, [*names.values(), *names])}",
        place="camera",
        remedy=f"there are: {', '.join(names.values()) or 'none'}",
    )
