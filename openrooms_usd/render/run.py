"""One run on disk: views are added one by one, and what is there is whole at any moment."""

import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from openrooms_usd import atomic
from openrooms_usd.channels import CHANNELS
from openrooms_usd.convert import Report
from openrooms_usd.errors import RenderError
from openrooms_usd.render import exr, folder, manifest, sheet
from openrooms_usd.render.contract import RenderRequest, View
from openrooms_usd.render.previews import Preview, preview, write_png


def raw_bytes(request: RenderRequest) -> int:
    """What one view's ``channels.exr`` takes before compression."""
    size = {"half": 2, "float": 4}
    rows = [CHANNELS[name] for name in request.channels]
    return request.width * request.height * sum(len(r.components) * size[r.storage] for r in rows)


class Run:
    """The finished views of a run, their manifest, timing and contact sheet.

    Args:
        out: The folder.
        entry: What all views share, from `manifest.run_entry`.
        report: What became of every prim; the manifest has what it says when a view is added.
    """

    def __init__(self, out: Path, entry: manifest.Plain, report: Report) -> None:
        self.manifest: manifest.Plain = {**entry, "views": {}}
        self.timing: manifest.Plain = {"views": {}}
        self._out = out
        self._report = report
        self._earlier = folder.earlier_views(out)
        self._rows: dict[str, list[sheet.Tile]] = {}

    def add(
        self,
        name: str,
        view: View,
        channels: tuple[str, ...],
        seconds: float,
        photograph: Mapping[str, str] | None = None,
    ) -> None:
        """Write a finished view, and say so in the manifest.

        Args:
            name: The view's name, which is its folder.
            view: What was rendered.
            channels: What was asked for.
            seconds: What it took to render.
            photograph: What it stands for in a capture, if anything.

        Raises:
            OutputError: It cannot be written.
            RenderError: The renderer did not give what was asked for.
        """
        _check(name, view, channels)
        began = time.perf_counter()
        # Where one of them finds no space, neither appears: the view first, then what lists it.
        with (
            atomic.filling(self._out) as lists,
            folder.replacing_folder(self._out / name) as beside,
        ):
            previews = write_view(beside, view)
            entry = manifest.view_entry(name, view, previews, photograph)
            took = {
                # Channels that share rays each count them: their sum may exceed the whole.
                "channels": {channel: image.seconds for channel, image in view.images.items()},
                "render": seconds,
                "output": time.perf_counter() - began,
            }
            listed = _with_view(self.manifest, name, entry) | {"report": self._report.as_dict()}
            timed = _with_view(self.timing, name, took)
            manifest.write_json(lists / folder.MANIFEST, listed)
            manifest.write_json(lists / folder.TIMING, timed)
            self._rows[name] = sheet.tiles(name, previews)
            self.manifest, self.timing = listed, timed
        folder.remove_views(self._out, self._earlier - listed["views"].keys())

    def finish(self) -> None:
        """Write the contact sheet of the views that were finished.

        Those are in the manifest on disk: an interruption may come while a view appears.
        """
        there = folder.listed_views(self._out)
        entries = self.manifest["views"]
        rows = [row for name, row in self._rows.items() if there.get(name) == entries[name]]
        if rows:
            sheet.write_sheet(self._out / folder.SHEET, rows[: sheet.MOST_VIEWS])


def _with_view(entry: manifest.Plain, name: str, view: manifest.Plain) -> manifest.Plain:
    return {**entry, "views": {**entry["views"], name: view}}


def _check(name: str, view: View, channels: tuple[str, ...]) -> None:
    for channel in channels:
        shape = (view.height, view.width, len(CHANNELS[channel].components))
        image = view.images.get(channel)
        if image is None or image.pixels.shape != shape:
            got = "nothing" if image is None else f"an array of shape {image.pixels.shape}"
            raise RenderError(f"the renderer gave {got} for the channel {channel!r}", place=name)


def write_view(target: Path, view: View) -> dict[str, Preview]:
    """Write the files of a view into an empty folder.

    Args:
        target: The folder.
        view: What was rendered.

    Returns:
        The pictures that were written, by channel name.

    Raises:
        OutputError: A file cannot be written.
    """
    pixels = {n: np.asarray(image.pixels, np.float32) for n, image in view.images.items()}

    def picture(name: str) -> Preview:
        shown = preview(name, pixels[name], view.exposure)
        write_png(target / f"{name}.png", shown.pixels)
        return shown

    # Encoding leaves the interpreter's lock: the longest goes first, the rest beside it.
    with ThreadPoolExecutor(max_workers=4) as pool:
        exact = [pool.submit(exr.write_channels, target / folder.CHANNELS_FILE, pixels)]
        for name, file in folder.PLAIN_FILES.items():
            if name in pixels:
                exact.append(pool.submit(exr.write_rgb, target / file, pixels[name]))
        previews = dict(zip(pixels, pool.map(picture, pixels), strict=True))
    for written in exact:
        written.result()
    return previews
