"""The page: what the records tell, put together and written as one file."""

import base64
import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import cycle, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic, claims, imagefile
from openrooms_usd.arrays import Bytes
from openrooms_usd.dataset.plan import Job, PlannedRoom, view_name
from openrooms_usd.dataset.records import SCENE, Record
from openrooms_usd.dataset.report import charts, sections
from openrooms_usd.dataset.report.charts import Chart
from openrooms_usd.dataset.scratch import Root, fetch_all, store_at
from openrooms_usd.dataset.stats import Stats, stats_of
from openrooms_usd.dataset.status import Status, status_of
from openrooms_usd.dataset.store import Store
from openrooms_usd.description import load_dataset
from openrooms_usd.errors import InputError, MissingPackageError, OrusdError, printable
from openrooms_usd.rendering.folder import MANIFEST, preview_file
from openrooms_usd.rendering.previews import preview
from openrooms_usd.rendering.reading import read_render
from openrooms_usd.rendering.sheet import MAIN
from openrooms_usd.scratch import scratch_folder
from openrooms_usd.untrusted import read_text
from openrooms_usd.usd.shading.textures import read_texture

if TYPE_CHECKING:
    import jinja2


MOST_PICTURES: Final = 72
"""How many views a report shows by default."""

_TEMPLATE: Final = "page.html"
# A dataset.yaml may name thousands of files.
_LONGEST_FILE: Final = 8000


@dataclass(frozen=True)
class ReportSummary:
    """A report that was written.

    Attributes:
        path: The page.
        views: How many finished views it tells of.
        pictures: How many of them it shows.
        bytes: Its size.
    """

    path: Path
    views: int
    pictures: int
    bytes: int

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for ``--json``."""
        return {**vars(self), "path": str(self.path)}


def write_report(
    root: Root, out: Path, *, pictures: int = MOST_PICTURES, price: float | None = None
) -> ReportSummary:
    """Write the report of a dataset: one HTML page that loads nothing else.

    The same dataset gives the same bytes; seconds are those of its timing files.

    Args:
        root: The dataset's folder, or a URL.
        out: The page; it appears whole or not at all.
        pictures: How many views it shows at most.
        price: Of an hour of a core, in any money.

    Raises:
        InputError: There is no dataset, or the price is not a number.
        MissingPackageError: What draws charts or fills the page is not installed.
        OutputError: The page cannot be written, or is there and not ours.
    """
    if price is not None and not math.isfinite(price):
        raise InputError(f"{price} is not a price", place="price", remedy="give a number")
    charts.check_installed()
    claims.check_output(out)
    template = _environment().get_template(_TEMPLATE)
    with store_at(root) as store:
        fetch_all(store)
        # What is known of the views is here now, wherever they are.
        stats, status = stats_of(store.root), status_of(store.root)
        strips = variants(store, pictures)
        text = template.render(
            title=_title(store),
            facts=list(_facts(stats, status)),
            strips=strips,
            channels=channels(store, MAIN),
            contents=_numbered("contents", *sections.contents(stats)),
            errors=_numbered("errors", sections.errors_chart(stats)),
            phases=_numbered("phases", sections.phases_chart(stats)),
            per_channel=sections.channels_table(stats),
            cost=sections.cost_table(stats, price),
            faults=sections.counts_table(stats.faults, "fault", "views"),
            rejected=sections.rejected_table(status.rejected),
            failures=sections.failures_table(status.failures),
            left_out=sections.left_out_table(status.left_out),
            splits=sections.counts_table(stats.splits, "split", "rooms"),
            licences=sections.counts_table(stats.licences, "licence", "rooms"),
            made_by=list(_made_by(store)),
            file=_file(store),
        )
    with claims.output(out):
        atomic.write_text(out, text)
    shown = sum(bool(picture.data) for strip in strips for picture in strip.pictures)
    return ReportSummary(out, status.finished, shown, len(text.encode()))


def _environment() -> "jinja2.Environment":
    try:
        import jinja2
    except ImportError as error:
        raise MissingPackageError(
            "a report needs the package 'jinja2'", remedy="pip install 'openrooms-usd[report]'"
        ) from error
    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        # Names of rooms and reasons of failures are untrusted text.
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def _numbered(name: str, *found: Chart | None) -> list[Chart]:
    """Charts whose parts have names of their own in the page."""
    shown = [chart for chart in found if chart]
    return [
        replace(chart, svg=charts.distinct(chart.svg, f"{name}-{number}"))
        for number, chart in enumerate(shown)
    ]


def _title(store: Store) -> str:
    try:
        return load_dataset(store.file).name
    except OrusdError:
        return printable(store.root.absolute().name, lines=False)


def _facts(stats: Stats, status: Status) -> Iterator[tuple[str, str]]:
    """The few numbers that people ask for first."""
    yield "rooms", f"{sum(stats.rooms.values()):,}"
    yield "views", f"{status.finished:,} of {status.units:,}"
    yield "failed", f"{len(status.failures):,}"
    if status.left_out:
        yield "rooms left out", f"{len(status.left_out):,}"
    yield "objects", charts.count(sum(stats.objects.values()))
    yield "size", charts.size(stats.bytes)
    if "radiance" in stats.errors:
        yield "median error of radiance", charts.digits(stats.errors["radiance"], 2)
    yield "time of one worker", charts.seconds(sum(stats.seconds.values()))


def _made_by(store: Store) -> Iterator[tuple[str, str]]:
    """What rendered it, as the first finished room says."""
    entry = _first_entry(store)
    if entry is None:
        return
    renderer = entry.get("renderer", {})
    stop = (f"{value:g} {name}" for name, value in entry.get("stop", {}).items())
    yield "made by", entry.get("generator", "")
    yield "renderer", renderer.get("backend") or renderer.get("name", "")
    yield "method", entry.get("method", "")
    yield "a view stops at", ", ".join(stop)
    yield "bounces", str(entry.get("bounces", ""))


def _first_entry(store: Store) -> Record | None:
    for job in store.jobs():
        if shared := store.scene_record(job):
            return dict(shared["entry"])
    return None


def _file(store: Store) -> str:
    """The dataset.yaml, as far as people read."""
    try:
        text = read_text(store.file, "description")
    except InputError as error:
        return str(error.message)
    if len(text) <= _LONGEST_FILE:
        return text
    return f"{text[:_LONGEST_FILE]}\n... and {len(text) - _LONGEST_FILE:,} characters more\n"


# Views that stand for the rest, and small pictures of them that a page holds in itself.

LIGHT: Final = ("denoised", "radiance")
"""What people look at of a view, the best first."""

_WIDTH: Final = 240
_HOW: Final = {"oiio:ColorSpace": "srgb_rec709_scene", "Compression": "jpeg:80"}


@dataclass(frozen=True)
class Picture:
    """A small picture.

    Attributes:
        name: What is written below it.
        alt: What it shows, for those who cannot see it.
        data: The picture as an address; empty where it cannot be read.
    """

    name: str
    alt: str
    data: str


@dataclass(frozen=True)
class Strip:
    """Pictures that are looked at side by side.

    Attributes:
        title: What they have in common.
        pictures: One or several.
    """

    title: str
    pictures: tuple[Picture, ...]


def variants(store: Store, most: int) -> list[Strip]:
    """A view of some rooms in all their variants: of every type, and spread over the rooms.

    Args:
        store: Where everything lies.
        most: At most so many pictures, but of one room at least.
    """
    jobs: dict[int, list[Job]] = defaultdict(list)
    rooms: dict[int, PlannedRoom] = {}
    for job in store.jobs():
        # The others are not started yet.
        if store.record_path(job, SCENE).is_file():
            rooms[job.room.number] = job.room
            jobs[job.room.number].append(job)
    across = max(map(len, jobs.values()), default=1)
    strips: list[Strip] = []
    for place, room in enumerate(spread(rooms.values(), max(1, most // across))):
        if strip := _room_strip(store, room, jobs[room.number], place):
            strips.append(strip)
    return strips


def channels(store: Store, wanted: Sequence[str]) -> Strip | None:
    """A finished view in its channels; None where no view is finished.

    Args:
        store: Where everything lies.
        wanted: Their names, as far as the view has them.
    """
    for job in store.jobs():
        for view, _ in store.records(job):
            pictures = tuple(_channel_pictures(store, job, view, wanted))
            if pictures:
                return Strip(f"{job.name}/{view_name(view)}", pictures)
    return None


def _channel_pictures(
    store: Store, job: Job, view: int, wanted: Sequence[str]
) -> Iterator[Picture]:
    """Those that are stored, and those that are made of the channels."""
    render, folder = store.render(job), store.render(job) / view_name(view)
    try:
        if store.remote is not None:
            store.remote.get([store.name_of(render / MANIFEST)], store.root)
            store.remote.get_all(f"{store.name_of(folder)}/", store.root)
        found = read_render(render).views[view_name(view)]
        for name in wanted:
            picture = _picture(store, job, view, [name])
            data = picture.data
            if not data and name in found.pixels:
                data = _data(preview(name, found.pixels[name]).pixels)
            if data:
                yield Picture(name, f"{name} of {job.name}/{view_name(view)}", data)
    except (InputError, KeyError):
        return


def spread(rooms: Iterable[PlannedRoom], most: int) -> list[PlannedRoom]:
    """Some of many rooms: types by turns, and of each type rooms from the first to the last."""
    by_type: dict[str, list[PlannedRoom]] = defaultdict(list)
    for room in rooms:
        by_type[str(room.source.get("type", ""))].append(room)
    left = min(most, sum(map(len, by_type.values())))
    shares = dict.fromkeys(sorted(by_type), 0)
    for kind in cycle(shares):
        if not left:
            break
        if shares[kind] < len(by_type[kind]):
            shares[kind] += 1
            left -= 1
    chosen = [
        by_type[kind][(2 * number + 1) * len(by_type[kind]) // (2 * share)]
        for kind, share in shares.items()
        for number in range(share)
    ]
    return sorted(chosen, key=lambda room: room.number)


def _room_strip(store: Store, room: PlannedRoom, jobs: Sequence[Job], place: int) -> Strip | None:
    every = [(job, [view for view, _ in store.records(job)]) for job in jobs]
    finished = [(job, views) for job, views in every if views]
    if not finished:
        return None
    # One that all variants have, if there is one; from room to room another.
    shared = sorted(set.intersection(*(set(views) for _, views in finished)))
    pictures = []
    for job, views in finished:
        chosen = next(islice(cycle(shared or views), place, None))
        pictures.append(replace(_picture(store, job, chosen, LIGHT), name=job.variant))
    return Strip(room.name, tuple(pictures))


def _picture(store: Store, job: Job, view: int, wanted: Sequence[str]) -> Picture:
    """The first of some channels that has a stored picture, as far as that can be read."""
    name = f"{job.name}/{view_name(view)}"
    for channel in wanted:
        path = store.render(job) / view_name(view) / preview_file(channel)
        with suppress(InputError):
            if store.remote is not None:
                store.remote.get([store.name_of(path)], store.root)
            if path.is_file():
                return Picture(name, f"{channel} of {name}", _data(read_texture(str(path))))
    return Picture(name, f"{name}: there is no picture of it", "")


def _data(pixels: NDArray[Any]) -> str:
    """A picture as a small JPEG in an address."""
    with scratch_folder() as folder:
        file = folder / "small.jpg"
        imagefile.write(file, _reduced(pixels), "uint8", _HOW)
        return f"data:image/jpeg;base64,{base64.b64encode(file.read_bytes()).decode()}"


def _reduced(pixels: NDArray[Any]) -> Bytes:
    """Three channels of bytes, no wider than `_WIDTH`."""
    import OpenImageIO

    colored = np.repeat(pixels[..., :1], 3, axis=-1) if pixels.shape[-1] < 3 else pixels[..., :3]
    height, width = colored.shape[:2]
    source: Any = OpenImageIO.ImageBuf(np.ascontiguousarray(colored))
    if width > _WIDTH:
        size = OpenImageIO.ROI(0, _WIDTH, 0, max(1, round(_WIDTH * height / width)), 0, 1, 0, 3)
        source = OpenImageIO.ImageBufAlgo.resize(source, "box", roi=size)
    return np.asarray(source.get_pixels(OpenImageIO.UINT8))
