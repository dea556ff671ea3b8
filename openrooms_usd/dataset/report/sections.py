"""What the views show, how well they were made and what that took, as charts and tables."""

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from openrooms_usd.channels import CHANNELS
from openrooms_usd.dataset.report import charts
from openrooms_usd.dataset.report.charts import Chart, Table
from openrooms_usd.dataset.stats import KELVIN_STEP, PHASES, Stats
from openrooms_usd.dataset.status import DEPTH_BINS, DEPTH_STEP_M, Failure

_HOUR_S: Final = 3600.0
_VIEWS: Final = 1000
_PHASES: Final = dict(
    zip(PHASES, ("composing the room", "translating it", "rendering", "writing"), strict=True)
)


@dataclass(frozen=True)
class _Ranking:
    """How counts by name are shown: a bar each, the largest first."""

    title: str
    counts: Callable[[Stats], Mapping[str, float]]
    unit: str
    note: str = ""
    as_share: bool = False

    def chart(self, stats: Stats) -> Chart | None:
        counts = {name: value for name, value in self.counts(stats).items() if value}
        if not counts:
            return None
        total = math.fsum(counts.values())

        def shown(value: float) -> str:
            return charts.share(value, total) if self.as_share else charts.count(value)

        rows = sorted(counts.items(), key=lambda row: (-row[1], row[0]))
        table = Table.of(
            ("", self.unit, "share"),
            [(name, f"{value:,.0f}", charts.share(value, total)) for name, value in rows],
        )
        svg = charts.bars(charts.most(counts), shown, has_rest=len(counts) > charts.MOST_BARS)
        return Chart(self.title, svg, table, self.note)


@dataclass(frozen=True)
class _Histogram:
    """How bins are shown: a column each, in order.

    Attributes:
        title: What it shows.
        bins: Counts by the lower ends of bins.
        end: The upper end of a bin by its lower one.
        below: What is on the axis below.
        beside: What is on the axis beside.
        at_least: What the axis below spans, whatever there is.
        note: What must be known to read it.
        log: Whether the axis below goes by decades.
        as_share: Whether columns are percent of all.
        whole: Whether bins are whole numbers, each alone.
        open_from: The lower end of the bin that takes all beyond.
    """

    title: str
    bins: Callable[[Stats], Mapping[str, int]]
    end: Callable[[float], float]
    below: str
    beside: str
    at_least: tuple[float, float]
    note: str = ""
    log: bool = False
    as_share: bool = False
    whole: bool = False
    open_from: float = math.inf

    def chart(self, stats: Stats) -> Chart | None:
        bins = {float(low): number for low, number in self.bins(stats).items()}
        total = sum(bins.values())
        if not total:
            return None
        # A whole number is the middle of its column.
        left, factor = (0.5 if self.whole else 0.0), (100.0 / total if self.as_share else 1.0)
        drawn = {low - left: factor * number for low, number in bins.items()}
        svg = charts.histogram(
            drawn, self.end, self.below, self.beside, at_least=self.at_least, log=self.log
        )
        rows = [
            (self._named(low), f"{number:,}", charts.share(number, total))
            for low, number in sorted(bins.items())
        ]
        return Chart(self.title, svg, Table.of((self.below, "count", "share"), rows), self.note)

    def _named(self, low: float) -> str:
        if low >= self.open_from:
            return f"{low:g} and more"
        return f"{low:g}" if self.whole else f"{low:g} to {self.end(low):g}"


def _after(step: float) -> Callable[[float], float]:
    return lambda low: low + step


def _next_step(low: float) -> float:
    """The end of a bin of 1, 2, 5, 10, 20, 50 and so on."""
    return low * (2.5 if f"{low:e}".startswith("2") else 2.0)


_EVERY_VARIANT: Final = "Counted in each room and variant."
_CONTENTS: Final = (
    _Ranking("Rooms by type", lambda stats: stats.rooms, "rooms"),
    _Ranking("Views by variant", lambda stats: stats.views, "views"),
    _Ranking("Objects by category", lambda stats: stats.objects, "objects", "Each room once."),
    _Ranking(
        "Pixels by class",
        lambda stats: stats.pixels,
        "pixels",
        "OpenRooms' 45 classes.",
        as_share=True,
    ),
    _Ranking("Pixels by material", lambda stats: stats.materials, "pixels", as_share=True),
    _Ranking("Pixels by family of textures", lambda stats: stats.families, "pixels", as_share=True),
    _Histogram(
        "Depth",
        lambda stats: stats.depth_m,
        _after(DEPTH_STEP_M),
        "depth in m",
        "% of pixels",
        (0.0, 5.0),
        "The last column has everything farther away.",
        as_share=True,
        open_from=DEPTH_STEP_M * (DEPTH_BINS - 1),
    ),
    _Ranking(
        "Lights by kind",
        lambda stats: stats.lights,
        "lights",
        "Elsewhere is light that enters outside all openings. " + _EVERY_VARIANT,
    ),
    _Histogram(
        "Lamps that are on in a room",
        lambda stats: stats.lamps_a_room,
        _after(1.0),
        "lamps",
        "rooms and variants",
        (-0.5, 5.5),
        whole=True,
    ),
    _Histogram(
        "Power of lamps",
        lambda stats: stats.lamp_lumen,
        _next_step,
        "lumen",
        "lamps",
        (10.0, 1e4),
        "Lamps that are on. " + _EVERY_VARIANT,
        log=True,
    ),
    _Histogram(
        "Colour of lamps",
        lambda stats: stats.lamp_kelvin,
        _after(KELVIN_STEP),
        "colour temperature in K",
        "lamps",
        (2000.0, 7000.0),
        "Lamps that are on. " + _EVERY_VARIANT,
    ),
    _Histogram(
        "Light through openings",
        lambda stats: stats.opening_lumen,
        _next_step,
        "lumen",
        "openings",
        (10.0, 1e5),
        _EVERY_VARIANT,
        log=True,
    ),
)


def contents(stats: Stats) -> Iterator[Chart]:
    """What the views show: rooms, objects, pixels, materials, depth, lights."""
    for one in _CONTENTS:
        if chart := one.chart(stats):
            yield chart


def errors_chart(stats: Stats) -> Chart | None:
    """The median error of every channel that has one."""
    if not stats.errors:
        return None
    rows = [(name, f"{stats.errors[name]:.3g}") for name in _in_order(stats.errors)]
    svg = charts.bars(
        sorted(stats.errors.items(), key=lambda row: (-row[1], row[0]))[: charts.MOST_BARS],
        lambda value: charts.digits(value, 2),
    )
    return Chart("Median error of channels", svg, Table.of(("channel", "error"), rows))


def channels_table(stats: Stats) -> Table:
    """Error and seconds of each channel; those that one exact ray tells in one row."""
    every = _in_order({*stats.errors, *stats.channel_seconds})
    exact = [name for name in every if name not in stats.errors and _is_exact(name)]
    rows = [_channel_row(stats, name) for name in every if name not in exact]
    if exact:
        longest = max(stats.channel_seconds[name] for name in exact)
        rows.append((f"{len(exact)} others", "exact", "", f"{charts.seconds(longest)} at most"))
    return Table.of(("channel", "median error", "90 % are below", "a view takes"), rows)


def _channel_row(stats: Stats, name: str) -> tuple[str, ...]:
    error, high = stats.errors.get(name), stats.high_errors.get(name)
    took = stats.channel_seconds.get(name)
    return (
        name,
        "none" if error is None else charts.digits(error, 2),
        "" if high is None else charts.digits(high, 2),
        "" if took is None else charts.seconds(took),
    )


def _is_exact(channel: str) -> bool:
    return channel in CHANNELS and CHANNELS[channel].kind in ("geometry", "material", "label")


def phases_chart(stats: Stats) -> Chart | None:
    """Seconds a view by phase."""
    views = sum(stats.views.values())
    if not views or not sum(stats.seconds.values()):
        return None
    rows = [(_PHASES[phase], stats.seconds.get(phase, 0.0) / views) for phase in PHASES]
    table = Table.of(("", "a view"), [(name, charts.seconds(took)) for name, took in rows])
    return Chart("Seconds a view by phase", charts.bars(rows, charts.seconds), table)


def cost_table(stats: Stats, price: float | None) -> Table:
    """What a thousand views like these take: hours, and money at a price.

    Args:
        stats: What the records tell.
        price: Of an hour of a core, in any money.
    """
    views = sum(stats.views.values())
    if not views:
        return Table((), ())
    hours = sum(stats.seconds.values()) / views * _VIEWS / _HOUR_S
    core_hours = stats.core_seconds / views * _VIEWS / _HOUR_S
    rows = [
        ("hours of one worker", f"{charts.digits(hours)}"),
        ("cores of a worker", charts.digits(core_hours / hours if hours else 0.0)),
        ("core-hours", charts.digits(core_hours)),
        ("storage", charts.size(stats.bytes / views * _VIEWS)),
    ]
    if price is not None:
        cost = charts.digits(core_hours * price)
        rows.append((f"money, at {price:g} for an hour of a core", cost))
    return Table.of(("", "for 1,000 views"), rows)


def rejected_table(rejected: Sequence[Mapping[str, Any]]) -> Table:
    """Cameras that gave way to others, and why."""
    rows = [(row["unit"], row["camera"], ", ".join(row["faults"])) for row in rejected]
    return Table.of(("view", "camera that was left out", "why"), rows)


def left_out_table(left_out: Mapping[str, str]) -> Table:
    """Rooms that were left out on purpose, and why."""
    return Table.of(("room", "why"), sorted(left_out.items()))


def failures_table(failures: Sequence[Failure]) -> Table:
    """Why views could not be made, the most frequent reason first."""
    units: dict[tuple[str, str], list[str]] = defaultdict(list)
    for failure in failures:
        units[failure.code, failure.reason].append(failure.unit)
    ranked = sorted(units.items(), key=lambda row: (-len(row[1]), row[0]))
    rows = [(reason, f"{len(names):,}", names[0]) for (_, reason), names in ranked]
    return Table.of(("reason", "views", "such as"), rows)


def counts_table(counts: Mapping[str, int], name: str, unit: str) -> Table:
    """Counts by name, the largest first, with their shares."""
    total = sum(counts.values())
    ranked = Counter(dict(sorted(counts.items()))).most_common()
    rows = [(key, f"{value:,}", charts.share(value, total)) for key, value in ranked]
    return Table.of((name, unit, "share"), rows)


def _in_order(channels: Mapping[str, float] | set[str]) -> list[str]:
    """As the table of channels has them; what is not in it last."""
    places = {name: place for place, name in enumerate(CHANNELS)}
    return sorted(channels, key=lambda name: (places.get(name, len(places)), name))
