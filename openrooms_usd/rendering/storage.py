"""How the channels of a view lie on disk: complete, or compact, for datasets of many views.

Complete storage keeps every number as the table of channels says. Compact storage keeps labels,
masks, depth, geometry and materials as they are; light is rounded to few binary digits, each pixel
by itself, and what follows from other channels is left out (`restoring`). So no light becomes
negative, and sums of lights are as exact as their parts. What that saves and costs stands in
docs/reference/storage.md.
"""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Floats
from openrooms_usd.channels import Channel, definition
from openrooms_usd.description.rendering import COMPLETE, StorageName
from openrooms_usd.rendering.contract import View
from openrooms_usd.rendering.exr import Rounded, Rows
from openrooms_usd.rendering.folder import (
    CHANNELS_FILE,
    DENOISED_FILES,
    LIGHT_FILE,
    LIGHTS_FILE,
    MASKS_FILE,
    PLAIN_FILES,
    PREVIEWED,
    grid_file,
)
from openrooms_usd.rendering.restoring import follows, sources_of

DIGITS: Final = {"view": 6, "light": 5, "grid": 2}
"""Binary digits of light behind the first one, by the scope of its channel."""

# Brought there by a power of two, channels of any unit lie well inside the range of halves.
_MEAN: Final = 8.0
# What a file holds at most (`Rounded`).
_MOST: Final = 32768.0
_MOST_EXPONENT: Final = 120


@dataclass(frozen=True)
class Way:
    """How a channel is stored on disk.

    Attributes:
        file: In the folder of its view; empty where it is left out.
        sample: ``half`` or ``float``.
        scale: What the channel is multiplied by before it is stored.
        bound: A number is off by at most this share of itself, or of 2^-13 / ``scale`` where it is
            smaller; 0 without loss.
        sources: The channels that it follows from, where it is left out.
    """

    file: str = ""
    sample: str = "float"
    scale: float = 1.0
    bound: float = 0.0
    sources: tuple[str, ...] = ()

    def rows(self, pixels: Floats) -> Rows:
        """The channel as it is stored."""
        if not self.bound:
            return pixels
        return Rounded(pixels, self.scale, round(-math.log2(self.bound)) - 1)


@dataclass(frozen=True)
class Storing:
    """How a view is stored on disk.

    Attributes:
        profile: The profile that this follows.
        channels: By the names of single images.
        denoised: The same for denoised versions.
    """

    profile: StorageName
    channels: Mapping[str, Way]
    denoised: Mapping[str, Way]

    @property
    def files(self) -> tuple[str, ...]:
        """The files of channels and of their denoised versions."""
        return (*by_file(self.channels), *by_file(self.denoised))

    @property
    def plain(self) -> dict[str, str]:
        """The files that channels have besides, for any viewer."""
        complete = self.profile == COMPLETE
        return {c: file for c, file in PLAIN_FILES.items() if complete and c in self.channels}

    def is_previewed(self, channel: str) -> bool:
        """Whether there is a picture of a channel for people."""
        return self.profile == COMPLETE or channel in PREVIEWED

    def entry(self, way: Way, view: str) -> dict[str, Any]:
        """What the manifest says of the way of a channel; nothing where the table says it.

        Args:
            way: The way.
            view: The name of the view.
        """
        if self.profile == COMPLETE:
            return {}
        if way.sources:
            return {"stored": {"sources": list(way.sources)}}
        row = asdict(way) | {"file": f"{view}/{way.file}"}
        del row["sources"]
        return {"stored": row}


def storing(view: View, profile: StorageName = COMPLETE) -> Storing:
    """How to store a view on disk."""
    images = {name: image.pixels for name, image in view.images.items()}
    clean = {name: image.pixels for name, image in view.denoised.items()}
    if profile == COMPLETE:
        ways = {name: _complete(name) for name in images}
    else:
        ways = {n: _left_out(n, images, view) or _compact(n, images[n]) for n in images}
    files = {scope: file for file, scope in DENOISED_FILES}
    denoised = {}
    for name, pixels in clean.items():
        sample = (definition(name).storage,) if profile == COMPLETE else _rounded(name, pixels)
        denoised[name] = Way(files[definition(name).scope], *sample)
    return Storing(profile, ways, denoised)


def by_file(ways: Mapping[str, Way]) -> dict[str, dict[str, Way]]:
    """The channels that are stored, by file, in their order."""
    files: dict[str, dict[str, Way]] = {}
    for name, way in ways.items():
        if way.file:
            files.setdefault(way.file, {})[name] = way
    return files


def _complete(name: str) -> Way:
    row = definition(name)
    file = {"view": CHANNELS_FILE, "light": LIGHTS_FILE, "grid": grid_file(name)}[row.scope]
    return Way(file, sample=row.storage)


def _compact(name: str, pixels: Floats) -> Way:
    row = definition(name)
    if not _is_light(row):
        return Way(MASKS_FILE if row.scope == "light" else CHANNELS_FILE, sample=row.storage)
    file = {"view": LIGHT_FILE, "light": LIGHTS_FILE, "grid": grid_file(name)}[row.scope]
    return Way(file, *_rounded(name, pixels))


def _is_light(row: Channel) -> bool:
    return row.kind == "light" or row.unit in ("nit", "lux")


def _rounded(name: str, pixels: Floats) -> tuple[str, float, float]:
    """Sample type, scale and bound of light."""
    return "half", scale_of(pixels), 0.5 ** (DIGITS[definition(name).scope] + 1)


def scale_of(pixels: Floats) -> float:
    """The power of two that brings a channel's mean well inside the range of halves.

    Args:
        pixels: (height, width, components).
    """
    sizes = np.abs(pixels[np.isfinite(pixels)])
    most = float(sizes.max(initial=0.0))
    mean = float(sizes.mean(dtype=np.float64)) if most else 0.0
    if not mean:
        return 1.0
    wanted = math.floor(min(math.log2(_MEAN / mean), math.log2(_MOST / most)))
    return float(2.0 ** max(-_MOST_EXPONENT, min(_MOST_EXPONENT, wanted)))


def _left_out(name: str, images: Mapping[str, Floats], view: View) -> Way | None:
    """The way of a channel that follows from others of the view."""
    sources = sources_of(name)
    if not sources or not {*sources} <= {*images}:
        return None
    parts = {source: _as_stored(source, images[source]) for source in sources}
    if not follows(name, images[name], parts, view.K, view.world_from_camera):
        return None
    return Way(sources=sources)


def _as_stored(name: str, pixels: Floats) -> NDArray[Any]:
    return pixels.astype(np.float16) if definition(name).storage == "half" else pixels
