"""Renders that are finished: their manifest, and the pixels of their label channels."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.render import exr
from openrooms_usd.render.folder import CHANNELS_FILE, MANIFEST, listed_views


@dataclass(frozen=True, eq=False)
class FinishedView:
    """A view of a finished render.

    Attributes:
        name: Its name, which is its folder.
        entry: What the manifest says of it.
        labels: (height, width) numbers by channel name.
    """

    name: str
    entry: dict[str, Any]
    labels: dict[str, NDArray[np.int64]]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        width, height = self.entry["resolution"]
        return width, height

    @property
    def intrinsics(self) -> NDArray[np.float64]:
        """(3, 3) intrinsics, pixels."""
        return np.array(self.entry["K"], dtype=np.float64)

    @property
    def world_from_camera(self) -> NDArray[np.float64]:
        """(4, 4) from the OpenCV camera frame to the world, metres."""
        return np.array(self.entry["world_from_camera"], dtype=np.float64)

    def masks(self) -> dict[int, NDArray[np.bool_]]:
        """(height, width) the pixels of every instance that is seen, by its number."""
        numbers = self.labels["instance"]
        return {int(n): numbers == n for n in np.unique(numbers) if n > 0}


@dataclass(frozen=True, eq=False)
class FinishedRender:
    """A folder of `orusd render`.

    Attributes:
        folder: Where it lies.
        manifest: What it says of itself.
        channels: The label channels that are read with every view.
    """

    folder: Path
    manifest: dict[str, Any]
    channels: tuple[str, ...]

    @property
    def names(self) -> list[str]:
        """The views, sorted."""
        return sorted(self.manifest["views"])

    def legend(self, channel: str) -> dict[int, str]:
        """What the numbers of a label channel, or the ``category`` of an instance, mean."""
        return {int(n): str(name) for n, name in self.manifest["legend"].get(channel, {}).items()}

    def view(self, name: str) -> FinishedView:
        """Read one view.

        Raises:
            InputError: Its file is missing or is no image.
        """
        pixels = exr.read_channels(self.folder / name / CHANNELS_FILE)
        labels = {c: pixels[c][..., 0].astype(np.int64) for c in self.channels}
        return FinishedView(name, self.manifest["views"][name], labels)


def open_render(folder: Path, channels: tuple[str, ...]) -> FinishedRender:
    """Open a finished render.

    Args:
        folder: What `orusd render` wrote.
        channels: The label channels that all of its views must have.

    Raises:
        InputError: It is no render, or it lacks a channel.
    """
    views = listed_views(folder)
    if not views:
        raise InputError(
            "this is no finished render",
            place=folder,
            remedy="give a folder that 'orusd render' wrote: it holds a manifest.json with views",
        )
    manifest = json.loads((folder / MANIFEST).read_text("utf-8"))
    missing = [name for name in channels if name not in manifest["channels"]]
    if missing:
        raise InputError(
            f"the render has no channel {' and no channel '.join(missing)}",
            place=folder,
            remedy=f"render again with --channels all, or with {','.join(channels)} among them",
        )
    return FinishedRender(folder, {**manifest, "views": views}, channels)
