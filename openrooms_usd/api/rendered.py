"""What was rendered, read like mappings from names to arrays."""

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from openrooms_usd.api.given import AnyPath, path_of, unknown_name

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from openrooms_usd.rendering.reading import RenderedScene, RenderedView

_MASKS: Final = ("valid", "mask_i")


@dataclass(frozen=True, eq=False, repr=False)
class View(Mapping[str, "NDArray[Any]"], os.PathLike[str]):
    """One camera's picture: channels by name, as arrays that are read when they are asked for.

    A number for each pixel is (height, width), colours and vectors are (height, width, 3); labels
    are whole numbers, ``valid`` and ``mask_i`` true or false. What there is of every light goes by
    the light's number, such as ``direct_0``. Grids are (rows, columns, 16, 32, 3).
    """

    rendered: "RenderedView"

    def __fspath__(self) -> str:
        return str(self.folder)

    def __getitem__(self, channel: str) -> "NDArray[Any]":
        """The pixels of a channel.

        Raises:
            UnknownNameError: The view has no such channel.
            InputError: Its file is missing or damaged.
        """
        if channel not in self._names():
            raise unknown_name("channel", channel, self._names(), self.folder, _remedy(channel))
        return _array(self.rendered, channel)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names())

    def __len__(self) -> int:
        return len(self._names())

    def __contains__(self, channel: object) -> bool:
        return channel in self._names()

    def __repr__(self) -> str:
        return f"View({self.name!r}, {self.width}x{self.height}: {', '.join(self) or 'nothing'})"

    def _names(self) -> list[str]:
        return [*self.rendered.entry.channels, *self.rendered.fits]

    @property
    def name(self) -> str:
        """Its name in the render: the camera's."""
        return self.rendered.name

    @property
    def folder(self) -> Path:
        """Where its files lie: EXRs, and a PNG for every channel to look at."""
        return self.rendered.folder

    @property
    def width(self) -> int:
        """Pixels."""
        return self.rendered.width

    @property
    def height(self) -> int:
        """Pixels."""
        return self.rendered.height

    @property
    def K(self) -> "NDArray[np.float64]":  # noqa: N802
        """(3, 3) intrinsics in pixels; the centre of the top-left pixel is (0.5, 0.5)."""
        return self.rendered.K

    @property
    def world_from_camera(self) -> "NDArray[np.float64]":
        """(4, 4) from the camera (x right, y down, z forward) to the world, metres."""
        return self.rendered.world_from_camera


@dataclass(frozen=True, eq=False, repr=False)
class Render(Mapping[str, View], os.PathLike[str]):
    """A finished render: views by the names of their cameras."""

    rendered: "RenderedScene"

    def __fspath__(self) -> str:
        return str(self.folder)

    def __getitem__(self, view: str) -> View:
        """A view.

        Raises:
            UnknownNameError: The render has no such view.
        """
        if view not in self.rendered.views:
            raise unknown_name("view", view, self.rendered.views, self.folder)
        return View(self.rendered.views[view])

    def __iter__(self) -> Iterator[str]:
        return iter(self.rendered.views)

    def __len__(self) -> int:
        return len(self.rendered.views)

    def __contains__(self, view: object) -> bool:
        return view in self.rendered.views

    def __repr__(self) -> str:
        channels = ", ".join(self.rendered.manifest.channels)
        return f"Render({str(self.folder)!r}, views: {', '.join(self)}; channels: {channels})"

    @property
    def folder(self) -> Path:
        """Where it lies, with ``contact_sheet.png`` and ``manifest.json``."""
        return self.rendered.folder

    @property
    def lights(self) -> tuple[str, ...]:
        """The names of the lights; their places are the numbers in the names of channels."""
        return tuple(light.name for light in self.rendered.lights)

    def legend(self, channel: str) -> dict[int, str]:
        """What the numbers of a label channel mean: such as ``semantic``."""
        return self.rendered.legend(channel)


def open_render(folder: AnyPath) -> Render:
    """Open a finished render.

    Args:
        folder: What `render` or ``orusd render`` wrote.

    Raises:
        InputError: It is not a render, has no finished view, or its manifest is damaged.
    """
    from openrooms_usd.rendering.reading import read_render as read

    return Render(read(path_of(folder, "a render's folder")))


def _remedy(channel: str) -> str | None:
    """How a view would have a channel, where there is such a channel at all."""
    from openrooms_usd.channels import definition

    try:
        asked = definition(channel).name
    except (KeyError, TypeError):
        return None
    return f"render again with {asked!r} among the channels"


def form_of(channel: str, pixels: "NDArray[np.float32]") -> "NDArray[Any]":
    """A channel's pixels with the shape and type that suit its meaning.

    Args:
        channel: Its name.
        pixels: (height, width, components); of a grid its tiles side by side.

    Returns:
        As of `View`.
    """
    import numpy as np

    from openrooms_usd.channels import definition
    from openrooms_usd.geometry.hemisphere import untiled

    row = definition(channel)
    if row.scope == "grid":
        return untiled(pixels)
    if row.unit == "id":
        return pixels[..., 0].astype(np.int64)
    if row.name in _MASKS:
        return pixels[..., 0] > 0.5
    return pixels[..., 0] if len(row.components) == 1 else pixels


def _array(view: "RenderedView", channel: str) -> "NDArray[Any]":
    """A channel's pixels with the shape and type that suit its meaning."""
    from openrooms_usd.channels import CHANNELS, definition

    row = definition(channel) if channel not in ("environment_sg", "environment_sh") else None
    if row is None or row.scope == "grid":
        found = view.fit(channel) if row is None else view.grid(channel)
        if found is None:
            raise unknown_name("file of the channel", channel, (), view.folder)
        return found
    if row.unit == "id":
        return view.labels(channel)
    if channel in CHANNELS:
        pixels = view.pixels[channel]
    else:
        base, _, light = channel.rpartition("_")
        pixels = view.lights[base][int(light)]
    return form_of(channel, pixels)
