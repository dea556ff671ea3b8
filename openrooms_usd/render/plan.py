"""What a run shall render: cameras, channels, size and quality; the absurd is refused first."""

import difflib
import math
import operator
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Final, SupportsFloat, SupportsIndex, TypeVar

from openrooms_usd.channels import CHANNELS, FLOWS
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.hemisphere import HEMISPHERE
from openrooms_usd.render.contract import (
    COMPLETE,
    DEFAULT_GRID,
    DEFAULT_SAMPLES,
    PHOTOGRAPH,
    STORAGES,
    TONES,
    RenderRequest,
)
from openrooms_usd.render.denoise import DENOISED
from openrooms_usd.render.given import remedy_for

_Name = TypeVar("_Name", bound=str)

ALL: Final = "all"  # stands for all channels that can be had
USUAL: Final = "usual"  # stands for those that need not be asked for
FRAMING: Final = "framing"  # the view's name where a stage has no camera and the scene is framed

# What is never asked for by its channel's name, and what to do instead.
_MADE: Final = {
    DENOISED: "add --denoise instead",
    **dict.fromkeys(FLOWS, "the frames of a path have it: `views: {from: path}` in a dataset.yaml"),
}
_MOST_PIXELS: Final = 2**27
# One of a hemisphere's cell is taken for so many of a pixel.
_SAMPLES_PER_CELL_SAMPLE: Final = 16
_LIMITS: Final[dict[str, tuple[float, float]]] = {
    "texture side (--texture-side)": (1, 65_536),
    "width": (1, 2**15),
    "height": (1, 2**15),
    "grid's width": (1, 2**11),
    "grid's height": (1, 2**11),
    "samples (--spp)": (1, 2**20),
    "error (--error)": (1e-9, 1e3),
    "seconds (--time)": (1e-3, 1e7),
    "seed": (0, 2**31 - 1),
    "bounces": (0, 1024),
    "f-stop (--f-stop)": (0.5, 128),
    "time code (--time-code)": (-1e12, 1e12),
}


def paths_of(request: RenderRequest, views: int) -> float:
    """About how many paths a render follows, for `openrooms_usd.render.given.choose_method`.

    Args:
        request: For each view, with its size.
        views: How many there are.
    """
    lit = [CHANNELS[name].scope for name in request.channels if CHANNELS[name].kind == "light"]
    # Those that stop by error or time: as many as where nobody says.
    samples = request.samples or DEFAULT_SAMPLES
    pixels = request.width * request.height if any(scope != "grid" for scope in lit) else 0
    points = math.prod(request.grid) if "grid" in lit else 0
    cells = HEMISPHERE.count * max(1, samples // _SAMPLES_PER_CELL_SAMPLE)
    return float(views * (pixels * samples + points * cells))


def plan(
    channels: tuple[str, ...],
    resolution: tuple[int, int] | None,
    *,
    samples: int | None,
    error: float | None,
    seconds: float | None,
    seed: int,
    bounces: int,
    grid: tuple[int, int] = DEFAULT_GRID,
    tone: str = PHOTOGRAPH,
    f_stop: float | None = None,
    storage: str = COMPLETE,
) -> RenderRequest:
    """The request that all views share, still without a camera.

    Args:
        channels: What `choose_channels` gave.
        resolution: Width and height; None where the stage, not opened yet, will say (`sized`).
        samples: As in `openrooms_usd.render.RenderRequest`, like the rest.
        error: At most one of samples, error and seconds; none means `DEFAULT_SAMPLES`.
        seconds: See there.
        seed: See there.
        bounces: See there.
        grid: See there.
        tone: See there.
        f_stop: See there.
        storage: See there.

    Raises:
        InputError: The tone or the storage is unknown, a number is absurd, or samples, error and
            seconds contradict each other.
    """
    given = {"samples (--spp)": samples, "error (--error)": error, "seconds (--time)": seconds}
    stops = [name for name, value in given.items() if value is not None]
    if len(stops) > 1:
        raise InputError(
            f"{' and '.join(stops)} are given, but a render stops by one of them",
            remedy="give one of them",
        )
    if not stops:
        samples = DEFAULT_SAMPLES
    request = RenderRequest(
        camera=None,
        channels=channels,
        width=1,
        height=1,
        samples=None if samples is None else _whole("samples (--spp)", samples),
        error=None if error is None else _number("error (--error)", error),
        seconds=None if seconds is None else _number("seconds (--time)", seconds),
        seed=_whole("seed", seed),
        bounces=_whole("bounces", bounces),
        grid=(_whole("grid's width", grid[0]), _whole("grid's height", grid[1])),
        tone=_one_of("tone", TONES, tone),
        storage=_one_of("storage", STORAGES, storage),
        f_stop=None if f_stop is None else _number("f-stop (--f-stop)", f_stop),
    )
    return sized(request, resolution) if resolution else request


def sized(request: RenderRequest, resolution: tuple[int, int]) -> RenderRequest:
    """The request at a size in pixels.

    Raises:
        InputError: The size is absurd.
    """
    width, height = _whole("width", resolution[0]), _whole("height", resolution[1])
    if width * height > _MOST_PIXELS:
        raise InputError(
            f"{width}x{height} are more than {_MOST_PIXELS:,} pixels", place="resolution"
        )
    return replace(request, width=width, height=height)


def check_time_code(time_code: float) -> float:
    """A time code that a stage may be seen at.

    Raises:
        InputError: It is no number, or an absurd one.
    """
    return _number("time code (--time-code)", time_code)


def check_texture_side(side: int) -> int:
    """A longest side that textures may have.

    Raises:
        InputError: It is less than a pixel, or more than anybody's.
    """
    return _whole("texture side (--texture-side)", side)


def _one_of(what: str, known: tuple[_Name, ...], name: str) -> _Name:
    found = next((one for one in known if one == name), None)
    if found is None:
        remedy = f"one of: {', '.join(known)}"
        raise InputError(f"there is no {what} {name!r}", place=what, remedy=remedy)
    return found


def _whole(name: str, value: SupportsIndex) -> int:
    """Python's own number for what may be one of numpy, within its limits."""
    try:
        found = operator.index(value)
    except TypeError:
        raise InputError(f"{value!r} is no whole number", place=name) from None
    _check(name, found)
    return found


def _number(name: str, value: SupportsFloat) -> float:
    if not isinstance(value, SupportsFloat):
        raise InputError(f"{value!r} is no number", place=name)
    found = float(value)
    _check(name, found)
    return found


def _check(name: str, value: float) -> None:
    low, high = _LIMITS[name]
    # A NaN lies between nothing.
    if not low <= value <= high:
        raise InputError(f"{value} is not between {low:,} and {high:,}", place=name)


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
                f"no channel is named {name!r}", place="channels", remedy=_nearest(name, CHANNELS)
            )
        if name in _MADE:
            raise InputError(
                f"the channel {name!r} is made from others", place="channels", remedy=_MADE[name]
            )
        if name not in given:
            raise InputError(
                f"this renderer does not give the channel {name!r}",
                place="channels",
                remedy=f"{remedy_for(name)}; this one gives: {', '.join(given)}",
            )
    if not asked:
        raise InputError("no channel is asked for", place="channels", remedy="orusd channels")
    return tuple(name for name in CHANNELS if name in asked)


def view_names(cameras: Sequence[str]) -> dict[str, str]:
    """A short file name for every camera: the prim's name where it is the only one, else its path.

    A path is written with dots, which no prim's name contains. Names that differ only in case
    count as equal, because some file systems think so.

    Args:
        cameras: Prim paths.

    Returns:
        Name by prim path, such as ``camera_0`` or ``World.Cameras.left``.
    """
    short = {path: path.rpartition("/")[2] for path in cameras}
    folded = [name.casefold() for name in short.values()]
    return {
        path: name if folded.count(name.casefold()) == 1 else path.strip("/").replace("/", ".")
        for path, name in short.items()
    }


def choose_cameras(asked: Sequence[str], cameras: Sequence[str]) -> dict[str, str | None]:
    """The views to render, in the order asked for.

    Args:
        asked: Names or prim paths; all cameras where empty.
        cameras: The stage's cameras, as prim paths.

    Returns:
        Prim path by view name; the framing camera, without a path, where the stage has none.

    Raises:
        InputError: A name fits no camera, or several.
    """
    names = view_names(cameras)
    if not cameras and not asked:
        return {FRAMING: None}
    chosen = [_find(text, names) for text in asked] if asked else cameras
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
        f"no camera is named {text!r}",
        place="camera",
        remedy=_nearest(text, [*names, *names.values()], shown=list(names.values())),
    )


def _nearest(text: str, known: Iterable[str], shown: Iterable[str] | None = None) -> str:
    near = difflib.get_close_matches(text, list(known), n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    listed = ", ".join(shown if shown is not None else known)
    return f"{hint}there are: {listed or 'none'}"
