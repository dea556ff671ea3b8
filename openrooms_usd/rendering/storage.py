"""How the channels of a view lie on disk: complete, or compact, for datasets of many views.

Complete storage keeps every number as the table of channels says. Compact storage keeps labels,
masks, depth, geometry and materials as they are; light goes through OpenEXR's DWA compression,
which is lossy as JPEG is but works in half floats, and what follows from other channels is left
out (`restoring`). What that saves and costs stands in docs/storage.md.
"""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.channels import Channel, definition
from openrooms_usd.description.rendering import COMPLETE, StorageName
from openrooms_usd.rendering.contract import View
from openrooms_usd.rendering.exr import ZIP, Rows, Scaled
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

Pixels = NDArray[np.float32]

LOSSY: Final = {"view": "dwaa:100", "light": "dwaa:200", "grid": "dwaa:1000"}
"""The compression of light by the scope of its channel, with its level: more is lossier."""

# Black nearly everywhere: there halves alone take less, and lose next to nothing.
SPARSE: Final = ("environment_direct",)

# Brought there by a power of two, channels of any unit meet the same steps of DWA, which are
# relative above 1 and finer below.
_MEAN: Final = 8.0
# The largest number in half precision is twice this: the compression overshoots at edges.
_MOST: Final = 32768.0
_MOST_EXPONENT: Final = 120


@dataclass(frozen=True)
class Way:
    """How a channel lies on disk.

    Attributes:
        file: In the folder of its view; empty where it is left out.
        compression: ``zip``, without loss, or ``dwaa:`` and a level.
        sample: ``half`` or ``float``.
        scale: What the channel is multiplied by before it is stored.
        sources: The channels that it follows from, where it is left out.
    """

    file: str = ""
    compression: str = ZIP
    sample: str = "float"
    scale: float = 1.0
    sources: tuple[str, ...] = ()

    def rows(self, pixels: Pixels) -> Rows:
        """The channel as it is stored."""
        lossy = self.compression != ZIP or self.scale != 1.0
        return Scaled(pixels, self.scale) if lossy else pixels


@dataclass(frozen=True)
class Storing:
    """How a view lies on disk.

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
    """How a view shall lie on disk."""
    images = {name: image.pixels for name, image in view.images.items()}
    clean = {name: image.pixels for name, image in view.denoised.items()}
    if profile == COMPLETE:
        ways = {name: _complete(name) for name in images}
    else:
        ways = {n: _left_out(n, images, view) or _compact(n, images[n]) for n in images}
    files = {scope: file for file, scope in DENOISED_FILES}
    denoised = {}
    for name, pixels in clean.items():
        lossy = _lossy(name, pixels) if profile != COMPLETE else (ZIP, definition(name).storage)
        denoised[name] = Way(files[definition(name).scope], *lossy)
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


def _compact(name: str, pixels: Pixels) -> Way:
    row = definition(name)
    if not _is_light(row):
        return Way(MASKS_FILE if row.scope == "light" else CHANNELS_FILE, sample=row.storage)
    file = {"view": LIGHT_FILE, "light": LIGHTS_FILE, "grid": grid_file(name)}[row.scope]
    return Way(file, *_lossy(name, pixels))


def _is_light(row: Channel) -> bool:
    return row.kind == "light" or row.unit in ("nit", "lux")


def _lossy(name: str, pixels: Pixels) -> tuple[str, str, float]:
    """Compression, sample type and scale of light."""
    compression = ZIP if name in SPARSE else LOSSY[definition(name).scope]
    return compression, "half", scale_of(pixels)


def scale_of(pixels: Pixels) -> float:
    """The power of two that brings a channel's mean to where it is stored best.

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


def _left_out(name: str, images: Mapping[str, Pixels], view: View) -> Way | None:
    """The way of a channel that follows from others of the view."""
    sources = sources_of(name)
    if not sources or not {*sources} <= {*images}:
        return None
    parts = {source: _as_stored(source, images[source]) for source in sources}
    if not follows(name, images[name], parts, view.K, view.world_from_camera):
        return None
    return Way(sources=sources)


def _as_stored(name: str, pixels: Pixels) -> NDArray[Any]:
    return pixels.astype(np.float16) if definition(name).storage == "half" else pixels
