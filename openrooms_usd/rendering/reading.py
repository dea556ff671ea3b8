"""Finished renders as plain arrays by name: pixels, lights and grids, whatever rendered them."""

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd import names
from openrooms_usd.arrays import Array, Ints
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.hemisphere import HEMISPHERE, untiled
from openrooms_usd.rendering.compact import CompactChannels, Numbered, is_compact, unscaled
from openrooms_usd.rendering.exr import Pixels, read_channels, read_picture
from openrooms_usd.rendering.fits import harmonics
from openrooms_usd.rendering.folder import CHANNELS_FILE, DENOISED_FILES, LIGHTS_FILE
from openrooms_usd.rendering.manifest_schema import (
    AGAIN,
    MOST_LABELS,
    Manifest,
    ViewEntry,
    read_manifest,
)
from openrooms_usd.rendering.scene.lights import LightRecord
from openrooms_usd.unpickling.arrays import read_array

_NUMBERED: Final = re.compile(r"(.+)_([0-9]{1,9})")
# Of the fits of environment maps: the numbers of a lobe, or of a coefficient.
_FITS: Final = {"environment_sg": 6, "environment_sh": 3}


@dataclass(frozen=True, eq=False)
class RenderedView:
    """A view of a finished render. Files are read when they are first asked for.

    Attributes:
        name: Its name.
        folder: Where its files lie.
        entry: What the manifest says of it.
    """

    name: str
    folder: Path
    entry: ViewEntry

    @property
    def width(self) -> int:
        """Pixels."""
        return self.entry.resolution[0]

    @property
    def height(self) -> int:
        """Pixels."""
        return self.entry.resolution[1]

    @property
    def K(self) -> Array:  # noqa: N802
        """(3, 3) intrinsics in pixels; the centre of the top-left pixel is (0.5, 0.5).

        Raises:
            InputError: The view is not a pinhole camera's, which the caller needs.
        """
        if self.entry.projection != "pinhole":
            raise InputError(
                f"the view is {self.entry.projection}, but this needs pinhole cameras",
                place=self.folder,
                remedy="leave out such views",
            )
        return np.array(self.entry.K, dtype=np.float64)

    @property
    def world_from_camera(self) -> Array:
        """(4, 4) from the OpenCV camera frame to the world, metres."""
        return np.array(self.entry.world_from_camera, dtype=np.float64)

    @cached_property
    def pixels(self) -> Mapping[str, Pixels]:
        """(height, width, components) by channel name.

        Raises:
            InputError: The file is missing, damaged, or not of the view's size; of compact storage
                this comes when a channel is asked for.
        """
        if is_compact(self.entry):
            return CompactChannels(self.folder, self.entry, "view")
        # A view may have nothing but lights or grids.
        if self.entry.files is not None and "channels" not in self.entry.files:
            return {}
        return read_channels(self.folder / CHANNELS_FILE, self.entry.resolution)

    def labels(self, channel: str) -> Ints:
        """(height, width) the numbers of a label channel.

        Raises:
            InputError: It is missing, or holds a value that is not the number of a label.
        """
        path = self.folder / CHANNELS_FILE
        if channel not in self.pixels:
            raise InputError(f"it has no channel {channel!r}", place=path, remedy=AGAIN)
        found = self.pixels[channel][..., 0]
        # A NaN lies between nothing.
        if not ((found >= 0.0) & (found <= MOST_LABELS) & (found == np.trunc(found))).all():
            raise InputError(
                f"the channel {channel!r} holds values that are not whole numbers",
                place=path,
                remedy=AGAIN,
            )
        return found.astype(np.int64)

    @cached_property
    def lights(self) -> Mapping[str, Mapping[int, Pixels]]:
        """(height, width, components) by channel name and the light's number; empty without any.

        Raises:
            InputError: The file is damaged, or not of the view's size; of compact storage this
                comes when a light is asked for.
        """
        path = self.folder / LIGHTS_FILE
        layers: Mapping[str, Pixels] = {}
        if is_compact(self.entry):
            layers = CompactChannels(self.folder, self.entry, "light")
        elif os.path.lexists(path):
            layers = read_channels(path, self.entry.resolution)
        found: dict[str, dict[int, str]] = {}
        for name in layers:
            if parts := _NUMBERED.fullmatch(name):
                found.setdefault(parts[1], {})[int(parts[2])] = name
        return {channel: Numbered(layers, each) for channel, each in found.items()}

    @cached_property
    def denoised(self) -> dict[str, Pixels]:
        """(height, width, components) denoised versions by channel name; empty without any.

        Raises:
            InputError: A file is damaged, or not of the view's size.
        """
        paths = [self.folder / file for file, _ in DENOISED_FILES]
        return {
            name: unscaled(pixels, self.entry.denoised.get(name))
            for path in paths
            if os.path.lexists(path)
            for name, pixels in read_channels(path, self.entry.resolution).items()
        }

    def grid(self, name: str) -> Pixels | None:
        """(rows, columns, 16, 32, 3) hemispheres such as ``environment``; None without them.

        Raises:
            InputError: The file is not an image, or not a grid of hemispheres.
        """
        path = self.folder / f"{name}.exr"
        if not os.path.lexists(path):
            return None
        picture = unscaled(read_picture(path), self.entry.channels.get(name))
        height, width, _ = picture.shape
        if height % HEMISPHERE.rows or width % HEMISPHERE.columns:
            raise InputError(
                f"{width}x{height} is not a grid of hemispheres of "
                f"{HEMISPHERE.columns}x{HEMISPHERE.rows}",
                place=path,
                remedy=AGAIN,
            )
        return untiled(picture)

    def fit(self, name: str) -> Pixels | None:
        """A fit at the points of a grid, such as ``environment_sg``; None without one.

        Returns:
            (rows, columns, lobes or coefficients, numbers).

        Raises:
            InputError: The file is damaged.
        """
        path = self.folder / f"{name}.npy"
        if not os.path.lexists(path):
            grid = self.grid("environment") if self._follows(name) else None
            return None if grid is None else harmonics(grid)
        found = read_array(path, 4, "f")
        if found.shape[-1] != _FITS[name]:
            raise InputError(
                f"{name} has {found.shape[-1]} numbers, not {_FITS[name]}", place=path, remedy=AGAIN
            )
        return np.asarray(found, np.float32)

    @property
    def fits(self) -> list[str]:
        """The names of all that `fit` gives."""
        files = self.entry.fits.files if self.entry.fits else {}
        return [name for name in _FITS if name in files or (files and self._follows(name))]

    def _follows(self, fit: str) -> bool:
        """Whether a fit was left out, since it is quickly made again."""
        return fit == "environment_sh" and is_compact(self.entry)


@dataclass(frozen=True, eq=False)
class RenderedScene:
    """A folder that ``orusd render`` wrote.

    Attributes:
        folder: Where it lies.
        manifest: What it says of itself.
        views: By name, in the order of their numbers.
    """

    folder: Path
    manifest: Manifest
    views: Mapping[str, RenderedView]

    @property
    def lights(self) -> list[LightRecord]:
        """What is known of each light, in the order of their numbers."""
        return sorted(
            (light.record() for light in self.manifest.lights), key=lambda light: light.number
        )

    def each(self) -> Iterator[RenderedView]:
        """The views, one after the other, each without what was read of the one before."""
        # A view keeps the arrays that it has read: a copy takes them along when it goes.
        return (replace(view) for view in self.views.values())

    def check(self, channels: Sequence[str]) -> None:
        """See that the render has channels.

        Raises:
            InputError: It lacks one.
        """
        missing = [name for name in channels if name not in self.manifest.channels]
        if missing:
            raise InputError(
                f"the render has no channel {' and no channel '.join(missing)}",
                place=self.folder,
                remedy=f"render again with --channels all, or with {','.join(channels)} among them",
            )

    def legend(self, channel: str) -> dict[int, str]:
        """What the numbers of a label channel, or the ``category`` of an instance, mean."""
        return self.manifest.legend.get(channel, {})


def read_render(folder: Path, channels: tuple[str, ...] = ()) -> RenderedScene:
    """Open a finished render.

    Args:
        folder: What ``orusd render`` wrote.
        channels: What it must have.

    Raises:
        InputError: It is not a render, has no finished view, has a damaged manifest, or lacks a
            channel.
    """
    manifest = read_manifest(folder)
    views = {
        name: RenderedView(name, folder / name, manifest.views[name])
        for name in sorted(manifest.views, key=names.natural_sort_key)
    }
    found = RenderedScene(folder, manifest, views)
    found.check(channels)
    return found
