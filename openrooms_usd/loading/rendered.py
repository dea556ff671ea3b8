"""A view of a render as a sample: which files it needs, and the arrays that they hold."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Floats
from openrooms_usd.channels import CHANNELS, definition
from openrooms_usd.errors import InputError
from openrooms_usd.loading.sample import Sample, is_label
from openrooms_usd.rendering.compact import is_compact
from openrooms_usd.rendering.exr import Pixels
from openrooms_usd.rendering.manifest_schema import Manifest, StoredEntry, ViewEntry
from openrooms_usd.rendering.reading import RenderedView
from openrooms_usd.spelling import did_you_mean

_REMEDY: Final = "request channels that exist, or render it with them"


def full_name(view: str, about: Mapping[str, str]) -> str:
    """What a view is called among all of its dataset, such as ``room_0003/main/view_1``."""
    return "/".join(word for word in (about.get("room"), about.get("variant"), view) if word)


def needed_files(entry: ViewEntry, channels: Sequence[str]) -> set[str]:
    """The files that channels are made of, by what the manifest says.

    Args:
        entry: Of the view.
        channels: Names of the table.

    Returns:
        Paths in the folder of the render.

    Raises:
        InputError: There is no such channel.
    """
    if not is_compact(entry):
        grids = {name for name in channels if _scope(name) == "grid"}
        lights = any(_scope(name) == "light" for name in channels)
        kinds = {"channels", *grids, *(["lights"] if lights else [])}
        return {path for kind, path in (entry.files or {}).items() if kind in kinds}
    known: dict[str, StoredEntry | None] = {}
    waiting = {name for name in entry.channels if _is_of(name, channels)}
    while waiting:
        known |= {name: entry.channels[name].stored for name in waiting & {*entry.channels}}
        sources = {source for row in known.values() if row for source in row.sources}
        waiting = (sources - {*known}) & {*entry.channels}
    return {row.file for row in known.values() if row and row.file}


def _is_of(name: str, channels: Sequence[str]) -> bool:
    """Whether a single image, such as ``direct_3``, is of one of some channels."""
    try:
        return definition(name).name in channels
    except KeyError:  # another tool's
        return False


def _scope(name: str) -> str:
    if name not in CHANNELS:
        raise InputError(
            f"there is no channel {name!r}{did_you_mean(name, CHANNELS)}",
            remedy="'orusd channels' lists them by their names",
        )
    return CHANNELS[name].scope


def sample_of(
    view: RenderedView, manifest: Manifest, channels: Sequence[str], about: Mapping[str, str]
) -> Sample:
    """A view as a sample.

    Args:
        view: As it was rendered.
        manifest: Of its render.
        channels: Names of the table.
        about: What else is known of it: ``room``, ``variant`` and ``split``.

    Raises:
        InputError: A channel is missing, or a file is damaged.
    """
    by_scope = {scope: [n for n in channels if _scope(n) == scope] for scope in ("light", "grid")}
    images = {n: _image(view, n) for n in channels if CHANNELS[n].scope == "view"}
    lights = {n: _lights(view, manifest, n) for n in by_scope["light"]}
    numbers = _numbers(view, lights)
    boxes = {light.number: light for light in manifest.lights}
    known = [boxes[number] for number in numbers if number in boxes]
    if len(known) < len(numbers):
        raise InputError("some of its lights are not in the manifest", place=view.folder)
    return Sample(
        name=full_name(view.name, about),
        size=(view.width, view.height),
        K=view.K,
        world_from_camera=view.world_from_camera,
        images=images,
        lights={n: _stacked(view, n, found) for n, found in lights.items()},
        grids={n: _grid(view, n) for n in by_scope["grid"]},
        light_numbers=tuple(numbers),
        world_from_box=np.array([light.world_from_box for light in known]).reshape(-1, 4, 4),
        box_size=np.array([light.size for light in known]).reshape(-1, 3),
        about=about,
    )


def _image(view: RenderedView, name: str) -> NDArray[Any]:
    if name not in view.pixels:
        raise _missing(view.folder, name)
    if is_label(CHANNELS[name]):
        return view.labels(name)[..., None]
    return view.pixels[name]


def _grid(view: RenderedView, name: str) -> Floats:
    found = view.grid(name)
    if found is None:
        raise _missing(view.folder, name)
    return found


def _lights(view: RenderedView, manifest: Manifest, name: str) -> Mapping[int, Pixels]:
    """What a channel has of each light, by its number; a room without lights has none."""
    found = view.lights.get(name.removesuffix("_i"))
    if found is None and (manifest.lights or name not in manifest.channels):
        raise _missing(view.folder, name)
    return found or {}


def _numbers(view: RenderedView, lights: Mapping[str, Mapping[int, Pixels]]) -> list[int]:
    """The numbers of the lights that channels have, which all have the same."""
    found = [sorted(one) for one in lights.values()]
    if any(numbers != found[0] for numbers in found):
        raise InputError("its channels of lights have different lights", place=view.folder)
    return found[0] if found else []


def _stacked(view: RenderedView, name: str, found: Mapping[int, Pixels]) -> Pixels:
    """(lights, height, width, components) in the order of the lights' numbers."""
    shape = (len(found), view.height, view.width, len(CHANNELS[name].components))
    return np.array([found[number] for number in sorted(found)], np.float32).reshape(shape)


def _missing(folder: Path, channel: str) -> InputError:
    return InputError(f"it has no channel {channel!r}", place=folder, remedy=_REMEDY)
