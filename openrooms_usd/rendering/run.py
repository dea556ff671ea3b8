"""One run on disk: views are added one by one, and what is there is whole at any moment."""

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd import atomic
from openrooms_usd.arrays import Floats
from openrooms_usd.channels import definition, each
from openrooms_usd.description.rendering import COMPACT, COMPLETE, PHOTOGRAPH, StorageName, ToneName
from openrooms_usd.errors import RenderError
from openrooms_usd.exporters import Report
from openrooms_usd.geometry.hemisphere import HEMISPHERE, untiled
from openrooms_usd.imagefile import write_png
from openrooms_usd.ledger import Ledger
from openrooms_usd.rendering import exr, folder, manifest, sheet
from openrooms_usd.rendering.contract import RenderRequest, View
from openrooms_usd.rendering.fits import write_fits
from openrooms_usd.rendering.previews import Preview, preview
from openrooms_usd.rendering.scene.lights import LightRecord
from openrooms_usd.rendering.storage import Storing, Way, by_file, storing
from openrooms_usd.rendering.tone import white_balance

# The channel whose hemispheres are also fitted.
FITTED: Final = "environment"


def raw_bytes(request: RenderRequest, lights: int) -> int:
    """What one view's channels take before compression."""
    size = {"half": 2, "float": 4}
    return sum(
        math.prod(shape_of(name, request)) * size[definition(name).storage]
        for name in each(request.channels, lights)
    )


def shape_of(name: str, request: RenderRequest) -> tuple[int, int, int]:
    """Height, width and components of a channel's image."""
    row, depth = definition(name), len(definition(name).components)
    if row.scope == "grid":
        columns, rows = request.grid
        return rows * HEMISPHERE.rows, columns * HEMISPHERE.columns, depth
    return request.height, request.width, depth


class Run:
    """The finished views of a run, their manifest, timing and contact sheet.

    Args:
        out: The folder.
        entry: What all views share, from `manifest.run_entry`.
        report: What became of every prim; the manifest has what it says when a view is added.
        written: The ledger of ``out``, which this process has claimed.
        lights: Those of the scene, by their numbers.
        storage: How files hold channels.
        tone: How pictures show light.

    Attributes:
        stay: Views of an earlier run that are not described any more, and not ours to remove.
    """

    def __init__(
        self,
        out: Path,
        entry: manifest.Plain,
        report: Report,
        written: Ledger,
        lights: Sequence[LightRecord] = (),
        *,
        storage: StorageName = COMPLETE,
        tone: ToneName = PHOTOGRAPH,
    ) -> None:
        self._storage, self._tone = storage, tone
        self.manifest: manifest.Plain = {**entry, "views": {}}
        self.timing: manifest.Plain = {"views": {}}
        self._out = out
        self._report = report
        self._lights = lights
        self.stay: list[Path] = []
        self._ledger = written
        self._earlier = folder.earlier_views(out, written)
        self._rows: dict[str, list[sheet.Tile]] = {}

    def add(
        self,
        name: str,
        view: View,
        request: RenderRequest,
        seconds: float,
        photograph: Mapping[str, str] | None = None,
        report: manifest.Plain | None = None,
        check: Callable[[], None] = lambda: None,
    ) -> None:
        """Write a finished view, and say so in the manifest.

        Args:
            name: The view's name, which is its folder.
            view: What was rendered.
            request: What was asked for.
            seconds: What it took to render.
            photograph: What it stands for in a capture, if anything.
            report: What became of every prim so far; None for what the report says now.
            check: Called before every file; it raises where the view shall not be written.

        Raises:
            OutputError: It cannot be written.
            RenderError: The renderer did not give what was asked for.
        """
        check_view(name, view, request, len(self._lights))
        began = time.perf_counter()
        # Where one of them finds no space, neither appears: the view first, then what lists it.
        with (
            atomic.replacing_files(self._out) as lists,
            atomic.replacing_folder(self._out / name) as beside,
        ):
            stored = storing(view, self._storage)
            previews = write_view(beside, view, stored, self._tone, check)
            check()
            entry = describe_view(beside, name, view, stored, previews, self._lights, photograph)
            took = {
                # Channels that share rays each count them: their sum may exceed the whole.
                "channels": {channel: image.seconds for channel, image in view.images.items()},
                "render": seconds,
                "output": time.perf_counter() - began,
            }
            listed = _with_view(self.manifest, name, entry) | {
                "report": self._report.as_dict() if report is None else report
            }
            timed = _with_view(self.timing, name, took)
            if manifest.by_light(request) and not self._rows:
                write_openings(lists, self._lights)
            manifest.write_json(lists / folder.MANIFEST, listed)
            manifest.write_json(lists / folder.TIMING, timed)
            rows = {**self._rows, name: sheet.tiles(name, previews)}
            if len(rows) <= sheet.MOST_VIEWS:
                sheet.write_sheet(lists / folder.SHEET, list(rows.values()))
            self._rows, self.manifest, self.timing = rows, listed, timed
        gone = self._earlier - listed["views"].keys()
        self.stay = folder.remove_views(self._out, gone, self._ledger)


def write_openings(target: Path, lights: Iterable[LightRecord]) -> None:
    """Write the surroundings as each opening sees them, the same for all views, into a folder."""
    for light in lights:
        if light.environment is not None:
            path = target / folder.opening_file(light.name)
            path.parent.mkdir(exist_ok=True)
            exr.write_rgb(path, light.environment)


def describe_view(
    target: Path,
    name: str,
    view: View,
    stored: Storing,
    previews: Mapping[str, Preview],
    lights: Sequence[LightRecord] = (),
    photograph: Mapping[str, str] | None = None,
) -> manifest.Plain:
    """What the manifest says of a view whose files were written; fits are written beside them.

    Args:
        target: The folder of its files.
        name: The view's name.
        view: What was rendered.
        stored: How its channels lie on disk.
        previews: What `write_view` gave.
        lights: Those of the scene.
        photograph: What it stands for in a capture, if anything.
    """
    entry = manifest.view_entry(name, view, stored, previews, lights, photograph)
    fits = _fit(target, name, view, stored) if FITTED in view.images else None
    return entry | ({"fits": fits} if fits else {})


def _error_files(target: Path, view: View) -> list[tuple[Any, ...]]:
    """What writes the estimated errors of pixels: functions and their arguments."""
    known = {name: image.halves.deviation for name, image in view.images.items() if image.halves}
    tiles = {name: d for name, d in known.items() if definition(name).scope == "grid"}
    pixels = {name: d for name, d in known.items() if name not in tiles}
    jobs: list[tuple[Any, ...]] = [
        (exr.write_rgb, target / folder.grid_file(name, errors=True), deviation)
        for name, deviation in tiles.items()
    ]
    if pixels:
        jobs.append((exr.write_channels, target / folder.ERRORS_FILE, pixels))
    return jobs


def _stored_files(
    target: Path, pixels: Mapping[str, Floats], ways: Mapping[str, Way]
) -> list[tuple[Any, ...]]:
    """What writes channels as they shall lie on disk: functions and their arguments."""
    jobs: list[tuple[Any, ...]] = []
    for file, inner in by_file(ways).items():
        planes = {name: way.rows(pixels[name]) for name, way in inner.items()}
        samples = {name: way.sample for name, way in inner.items()}
        first = next(iter(inner))
        if definition(first).scope == "grid":
            jobs.append((exr.write_rgb, target / file, planes[first], samples[first]))
        else:
            jobs.append((exr.write_channels, target / file, planes, samples))
    return jobs


def _fit(target: Path, name: str, view: View, stored: Storing) -> manifest.Plain:
    """Write the fits of a view's environment maps; what the manifest says of them."""
    grid = untiled(view.images[FITTED].pixels)
    found = write_fits(target, grid, compact=stored.profile == COMPACT)
    return found | {"files": {fit: f"{name}/{file}" for fit, file in found["files"].items()}}


def _with_view(entry: manifest.Plain, name: str, view: manifest.Plain) -> manifest.Plain:
    return {**entry, "views": {**entry["views"], name: view}}


def check_view(name: str, view: View, request: RenderRequest, lights: int) -> None:
    """See that a view has all that was asked for.

    Raises:
        RenderError: A channel is missing, or has another size.
    """
    for channel in each(request.channels, lights):
        shape = shape_of(channel, request)
        image = view.images.get(channel)
        if image is None or image.pixels.shape != shape:
            got = "nothing" if image is None else f"an array of shape {image.pixels.shape}"
            raise RenderError(f"the renderer gave {got} for the channel {channel!r}", place=name)


def write_view(
    target: Path,
    view: View,
    stored: Storing,
    tone: ToneName = PHOTOGRAPH,
    check: Callable[[], None] = lambda: None,
) -> dict[str, Preview]:
    """Write the files of a view into an empty folder.

    Args:
        target: The folder.
        view: What was rendered.
        stored: How its channels shall lie on disk.
        tone: How pictures show light.
        check: Called before every file; it raises where no more shall be written.

    Returns:
        The pictures that were written, by channel name; of those that no contact sheet shows, only
        what they show.

    Raises:
        OutputError: A file cannot be written.
    """
    pixels = {n: np.asarray(image.pixels, np.float32) for n, image in view.images.items()}

    # One white for all pictures of a view: what a single lamp sends keeps its hue.
    balance = white_balance(pixels["radiance"]) if "radiance" in pixels else None
    on_sheet = sheet.chosen(pixels)
    pictured = [name for name in pixels if name in on_sheet or stored.is_previewed(name)]
    if any(stored.is_previewed(name) and definition(name).scope == "light" for name in pictured):
        (target / folder.LIGHTS_FOLDER).mkdir()

    def picture(name: str) -> Preview:
        check()
        shown = preview(name, pixels[name], view.exposure, tone, balance)
        if stored.is_previewed(name):
            write_png(target / folder.preview_file(name), shown.pixels)
        return shown if name in on_sheet else replace(shown, pixels=shown.pixels[:0])

    def file(write: Callable[..., None], *what: Any) -> None:
        check()
        write(*what)

    # Encoding leaves the interpreter's lock: the longest goes first, the rest beside it.
    with ThreadPoolExecutor(max_workers=4) as pool:
        clean = {name: image.pixels for name, image in view.denoised.items()}
        jobs = [
            *_stored_files(target, pixels, stored.channels),
            *_error_files(target, view),
            *_stored_files(target, clean, stored.denoised),
            *((exr.write_rgb, target / path, pixels[name]) for name, path in stored.plain.items()),
        ]
        exact = [pool.submit(file, *job) for job in jobs]
        previews = dict(zip(pictured, pool.map(picture, pictured), strict=True))
    for written in exact:
        written.result()
    return previews
