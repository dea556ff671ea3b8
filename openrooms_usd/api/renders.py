"""Pictures with ground truth: what was rendered reads like mappings from names to arrays."""

import logging
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from openrooms_usd.api import given
from openrooms_usd.api.given import AnyPath, choice_of, path_of, size_of, unknown_name, usd_file
from openrooms_usd.progress import Progress, silent

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from openrooms_usd.comparison.driver import Comparison
    from openrooms_usd.render.datasets import Crowded, DatasetSummary, Layout, Order, Subset
    from openrooms_usd.render.reading import RenderedScene, RenderedView

_LOG: Final = logging.getLogger("openrooms_usd")
_MASKS: Final = ("valid", "mask_i")
_RENDER: Final = "render"


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
        entry = self.rendered.entry
        fits = entry.fits.files if entry.fits else {}
        return [*entry.channels, *(name for name, file in fits.items() if file.endswith(".npy"))]

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


def _remedy(channel: str) -> str | None:
    """How a view would have a channel, where there is such a channel at all."""
    from openrooms_usd.channels import definition

    try:
        asked = definition(channel).name
    except (KeyError, TypeError):
        return None
    return f"render again with {asked!r} among the channels"


def _array(view: "RenderedView", channel: str) -> "NDArray[Any]":
    """The pixels of a channel in the form that its meaning has."""
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
    if row.name in _MASKS:
        return pixels[..., 0] > 0.5
    return pixels[..., 0] if len(row.components) == 1 else pixels


def render(
    scene: AnyPath,
    out: AnyPath | None = None,
    *,
    cameras: str | Sequence[str] = (),
    channels: str | Iterable[str] | None = None,
    resolution: tuple[int, int] | None = None,
    field_of_view: float | None = None,
    samples: int | None = None,
    error: float | None = None,
    seconds: float | None = None,
    seed: int = 0,
    bounces: int | None = None,
    method: str | None = None,
    tone: str = "photograph",
    f_stop: float | None = None,
    grid: tuple[int, int] | None = None,
    error_maps: bool = False,
    denoise: bool | Literal["all"] = False,
    renderer: str = "mitsuba",
    options: Mapping[str, str] | None = None,
    progress: Progress = silent,
) -> Render:
    """Render the cameras of a scene with their ground truth.

    Args:
        scene: A composed room or any USD file.
        out: The folder to write; by default ``render`` beside the scene.
        cameras: Names or prim paths; all cameras by default.
        channels: Names such as ``depth`` (docs/channels.md), ``all`` or ``usual``, the default.
        resolution: Width and height in pixels; by default what the scene says.
        field_of_view: Horizontal, degrees, of all cameras; by default what each has.
        samples: Samples a pixel; 64 by default where neither ``error`` nor ``seconds`` is given.
        error: Stop a view at this estimated robust error of its radiance.
        seconds: Stop a view after about this time.
        seed: Fixes every random number.
        bounces: At most this many scatterings between a light and the camera; 7 by default.
        method: ``reference``, without bias, or ``cache``; by default what takes less time.
        tone: How PNGs show light: ``photograph`` as a camera, ``film`` by the curve alone, ``srgb``
            with nothing but the encoding. Data is never toned.
        f_stop: F-number of a lens before film 36 mm wide, such as 2.8 (docs/light.md).
        grid: Columns and rows of hemispheres, where channels of them are asked for; (160, 120).
        error_maps: Whether to write the estimated standard error of each pixel too.
        denoise: Whether to write ``denoised`` beside ``radiance`` (extra ``denoise``); ``"all"``:
            also ``denoised_channels.exr`` and ``denoised_lights.exr`` (docs/light.md).
        renderer: A registered renderer.
        options: What is asked of the renderer, by name: Mitsuba has ``variant`` and ``bsdf``.
        progress: Called with the view's name and the finished fraction of the whole.

    Returns:
        The render: views by name, which hold arrays by the channel's name.

    Raises:
        InputError: The scene is unreadable, a name is unknown or a number is absurd.
        MissingPackageError: The denoiser is asked for and not installed.
        OutputError: The folder cannot be written.
        RenderError: The renderer cannot do it.
    """
    from openrooms_usd.render.contract import DEFAULT_BOUNCES, DEFAULT_GRID
    from openrooms_usd.render.driver import render_stage
    from openrooms_usd.usd.diagnostics import quiet
    from openrooms_usd.usd.layers import open_stage
    from openrooms_usd.usd.metrics import find_misfits

    file = usd_file(scene)
    folder = file.parent / _RENDER if out is None else path_of(out)
    with quiet():
        for misfit in find_misfits(open_stage(file)):
            _LOG.warning("%s: see orusd edits fit", misfit)
        summary = render_stage(
            file,
            folder,
            cameras=[cameras] if isinstance(cameras, str) else list(cameras),
            channels=given.names_of(channels),
            resolution=None if resolution is None else size_of(resolution, "resolution"),
            field_of_view=field_of_view,
            grid=DEFAULT_GRID if grid is None else size_of(grid, "grid"),
            error_maps=error_maps,
            samples=samples,
            error=error,
            seconds=seconds,
            seed=seed,
            bounces=DEFAULT_BOUNCES if bounces is None else bounces,
            method=method,
            tone=tone,
            f_stop=f_stop,
            renderer=renderer,
            denoise=denoise,
            options=options or {},
            progress=progress,
        )
    if summary.advice:
        _LOG.warning(summary.advice)
    for path in summary.stay:
        _LOG.warning("%s stays: it is no view of this run, and holds what no run wrote", path)
    return read_render(folder)


def read_render(folder: AnyPath) -> Render:
    """Open a finished render.

    Args:
        folder: What `render` or ``orusd render`` wrote.

    Raises:
        InputError: It is no render, has no finished view, or its manifest is not sound.
    """
    from openrooms_usd.render.reading import read_render as read

    return Render(read(path_of(folder, "a render's folder")))


def compare(
    scene: AnyPath,
    out: AnyPath,
    *,
    room: AnyPath | None = None,
    photographs: AnyPath | None = None,
    frames: str | Sequence[str] = (),
    count: int | None = None,
    width: int | None = None,
    samples: int | None = None,
    renderer: str = "mitsuba",
    options: Mapping[str, str] | None = None,
    progress: Progress = silent,
) -> "Comparison":
    """Render a room from the cameras of its photographs, and put all side by side.

    Args:
        scene: A room that was composed from a capture with cameras.
        out: The folder to write: ``comparison.json``, ``contact_sheet.png``, ``frames/``.
        room: The room.yaml it was composed from; by default beside the folder of the scene.
        photographs: The folder of the pictures; by default that of the capture.
        frames: Identifiers of frames; by default ``count`` of all, evenly spread.
        count: How many frames at most; 8 by default.
        width: Of the pictures, pixels; 480 by default.
        samples: Samples a pixel; 32 by default.
        renderer: A registered renderer.
        options: What is asked of the renderer, by name.
        progress: Called with the frame's name and the finished fraction of the whole.

    Returns:
        ``.frames``: of each how many edges of the render the photograph has, and how far its depth
        is from the scan's.

    Raises:
        InputError: A file is missing or damaged, the room comes from no capture with cameras, or
            there is no such frame.
        OutputError: The folder cannot be written.
        RenderError: The renderer cannot do it.
    """
    from openrooms_usd.comparison import driver
    from openrooms_usd.usd.diagnostics import quiet

    with quiet():
        return driver.compare_stage(
            usd_file(scene),
            path_of(out),
            description=None if room is None else path_of(room, "a room.yaml"),
            pictures=None if photographs is None else path_of(photographs),
            frames=[frames] if isinstance(frames, str) else list(frames),
            count=driver.DEFAULT_COUNT if count is None else count,
            width=driver.DEFAULT_WIDTH if width is None else width,
            samples=driver.DEFAULT_SAMPLES if samples is None else samples,
            renderer=renderer,
            options=options or {},
            progress=progress,
        )


def dataset(
    renders: AnyPath | Sequence[AnyPath],
    out: AnyPath,
    *,
    kind: str = "openrooms",
    scene: str = "scene0000_00",
    splits: str | Sequence[str] = ("main_xml",),
    subset: "Subset" = "train",
    layout: "Layout" = "split",
    order: "Order" = "legacy",
    first: int = 1,
    crowded: "Crowded" = "leave-out",
    stages: Sequence[AnyPath] = (),
    progress: Progress = silent,
) -> "DatasetSummary":
    """Write finished renders as the files of a published dataset.

    Args:
        renders: One render, or several variants of one scene.
        out: The dataset's folder; other scenes in it stay.
        kind: Whose dataset.
        scene: The scene's name in it.
        splits: What each render is, in their order.
        subset: The list that the scene is added to.
        layout: A tree for each channel, or one folder.
        order: In which order the channels of environment maps are stored.
        first: The number of the first view.
        crowded: What becomes of views with more lights than loaders have room for.
        stages: The composed stage of each render: its scene is written, too.
        progress: Called with each finished view and the finished fraction.

    Returns:
        How many files of which views, and what is ``.missing`` and why.

    Raises:
        InputError: There is no such dataset, or the renders or options do not fit each other.
        OutputError: A file cannot be written.
    """
    from openrooms_usd.render import datasets as forms

    chosen = {"subset": subset, "layout": layout, "order": order, "crowded": crowded}
    for what, value in chosen.items():
        choice_of(value, getattr(forms, what.title()), what)
    several = [renders] if isinstance(renders, (str, os.PathLike)) else renders
    folders = [path_of(render, "a render's folder") for render in several]
    names = (splits,) if isinstance(splits, str) else tuple(splits)
    of = tuple(map(path_of, stages))
    options = forms.DatasetOptions(scene, names, subset, layout, order, first, crowded, of)
    return forms.write_dataset(folders, path_of(out), kind=kind, options=options, progress=progress)
