"""The page: what the records tell, put together and written as one file."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from openrooms_usd import atomic
from openrooms_usd.dataset.records import Record
from openrooms_usd.dataset.report import charts, contact, sections, wording
from openrooms_usd.dataset.report.blocks import Chart
from openrooms_usd.dataset.scratch import Root, fetch_all, store_at
from openrooms_usd.dataset.stats import Stats, stats_of
from openrooms_usd.dataset.status import Status, status_of
from openrooms_usd.dataset.store import Store
from openrooms_usd.description import load_dataset
from openrooms_usd.errors import InputError, MissingPackageError, OrusdError, printable
from openrooms_usd.rendering.sheet import MAIN
from openrooms_usd.untrusted import read_text

if TYPE_CHECKING:
    import jinja2

MOST_PICTURES: Final = 72
"""How many views a report shows where nobody says."""

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
        InputError: There is no dataset, or the price is no number.
        MissingPackageError: What draws charts or fills the page is not installed.
        OutputError: The page cannot be written.
    """
    if price is not None and not math.isfinite(price):
        raise InputError(f"{price} is no price", place="price", remedy="give a number")
    charts.check_installed()
    template = _environment().get_template(_TEMPLATE)
    with store_at(root) as store:
        fetch_all(store)
        # What is known of the views is here now, wherever they are.
        stats, status = stats_of(store.root), status_of(store.root)
        strips = contact.variants(store, pictures)
        text = template.render(
            title=_title(store),
            facts=list(_facts(stats, status)),
            strips=strips,
            channels=contact.channels(store, MAIN),
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
        # Names of rooms and reasons of failures may be anybody's.
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
    yield "objects", wording.count(sum(stats.objects.values()))
    yield "size", wording.size(stats.bytes)
    if "radiance" in stats.errors:
        yield "median error of radiance", wording.digits(stats.errors["radiance"], 2)
    yield "time of one worker", wording.seconds(sum(stats.seconds.values()))


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
