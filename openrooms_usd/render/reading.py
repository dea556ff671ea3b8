"""Finished renders as plain arrays by name: pixels, lights and grids, whatever rendered them."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.geometry.hemisphere import HEMISPHERE, untiled
from openrooms_usd.render.folder import CHANNELS_FILE, LIGHTS_FILE, MANIFEST, listed_views

Pixels = NDArray[np.float32]

_NUMBERED: Final = re.compile(r"(.+)_(\d+)")


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
    entry: Mapping[str, Any]

    @property
    def width(self) -> int:
        """Pixels."""
        return int(self.entry["resolution"][0])

    @property
    def height(self) -> int:
        """Pixels."""
        return int(self.entry["resolution"][1])

    @property
    def K(self) -> NDArray[np.float64]:  # noqa: N802
        """(3, 3) intrinsics in pixels; the centre of the top-left pixel is (0.5, 0.5)."""
        return np.array(self.entry["K"], dtype=np.float64)

    @property
    def world_from_camera(self) -> NDArray[np.float64]:
        """(4, 4) from the OpenCV camera frame to the world, metres."""
        return np.array(self.entry["world_from_camera"], dtype=np.float64)

    @cached_property
    def pixels(self) -> dict[str, Pixels]:
        """(height, width, components) by channel name.

        Raises:
            InputError: The file is missing or is no image.
        """
        # A view may have nothing but lights or grids.
        if "channels" not in self.entry.get("files", ["channels"]):
            return {}
        return read_layers(self.folder / CHANNELS_FILE)

    @cached_property
    def lights(self) -> dict[str, dict[int, Pixels]]:
        """(height, width, components) by channel name and the light's number; empty without any.

        Raises:
            InputError: The file is no image.
        """
        path = self.folder / LIGHTS_FILE
        found: dict[str, dict[int, Pixels]] = {}
        for name, pixels in (read_layers(path) if path.exists() else {}).items():
            if parts := _NUMBERED.fullmatch(name):
                found.setdefault(parts[1], {})[int(parts[2])] = pixels
        return found

    def grid(self, name: str) -> Pixels | None:
        """(rows, columns, 16, 32, 3) hemispheres such as ``environment``; None without them.

        Raises:
            InputError: The file is no image, or no grid of hemispheres.
        """
        path = self.folder / f"{name}.exr"
        if not path.exists():
            return None
        picture = read_picture(path)
        height, width, depth = picture.shape
        if height % HEMISPHERE.rows or width % HEMISPHERE.columns or depth != 3:
            raise InputError(
                f"{width}x{height}x{depth} is no grid of hemispheres of "
                f"{HEMISPHERE.columns}x{HEMISPHERE.rows}",
                place=path,
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
        if not path.exists():
            return None
        try:
            found: Pixels = np.load(path, allow_pickle=False)
        except (OSError, ValueError) as error:
            raise InputError(f"not a readable array: {error}", place=path) from error
        return found


@dataclass(frozen=True, eq=False)
class RenderedScene:
    """A folder that ``orusd render`` wrote.

    Attributes:
        folder: Where it lies.
        manifest: What it says of itself.
        views: By name, sorted.
    """

    folder: Path
    manifest: Mapping[str, Any]
    views: Mapping[str, RenderedView]

    @property
    def lights(self) -> list[dict[str, Any]]:
        """What the manifest says of each light, in the order of their numbers."""
        return sorted(self.manifest.get("lights", []), key=lambda light: int(light["number"]))

    def legend(self, channel: str) -> dict[int, str]:
        """What the numbers of a label channel mean."""
        return {int(n): str(name) for n, name in self.manifest["legend"].get(channel, {}).items()}


def read_render(folder: Path) -> RenderedScene:
    """Open a finished render.

    Args:
        folder: What ``orusd render`` wrote.

    Raises:
        InputError: It is no render, or has no finished view.
    """
    entries = listed_views(folder)
    if not entries:
        raise InputError(
            "this is no finished render",
            place=folder,
            remedy="give a folder that 'orusd render' wrote: it holds a manifest.json with views",
        )
    manifest = json.loads((folder / MANIFEST).read_text("utf-8"))
    views = {name: RenderedView(name, folder / name, entries[name]) for name in sorted(entries)}
    return RenderedScene(folder, manifest, views)


def read_layers(path: Path) -> dict[str, Pixels]:
    """The layers of a picture, whatever their names.

    Args:
        path: An EXR file with channels ``<layer>.<part>``.

    Returns:
        (height, width, parts) by layer, in the file's order; parts as X Y Z, as R G B, or alone.

    Raises:
        InputError: It is missing or is no image.
    """
    names, picture = _read(path)
    layers: dict[str, dict[str, int]] = {}
    for place, name in enumerate(names):
        layer, _, part = name.rpartition(".")
        layers.setdefault(layer, {})[part] = place
    return {
        layer: picture[..., [places[part] for part in sorted(places, key=_rank)]]
        for layer, places in layers.items()
    }


def read_picture(path: Path) -> Pixels:
    """A picture without layers: (height, width, 3), red first.

    Raises:
        InputError: It is missing or is no image.
    """
    return read_layers(path)[""]


def _rank(part: str) -> int:
    return "RGBXYZ".find(part)


def _read(path: Path) -> tuple[list[str], Pixels]:
    import OpenImageIO

    source: Any = OpenImageIO.ImageInput.open(str(path))
    if source is None:
        raise InputError(f"not a readable image: {OpenImageIO.geterror()}", place=path)
    try:
        names = list(source.spec().channelnames)
        pixels = source.read_image(OpenImageIO.FLOAT)
        if pixels is None:
            raise InputError(f"a damaged image: {source.geterror()}", place=path)
    finally:
        source.close()
    return names, np.asarray(pixels, np.float32)
