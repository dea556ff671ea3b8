"""What the views show, as charts: rooms, objects, pixels, materials, depth, lights."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from openrooms_usd.dataset.report import charts, wording
from openrooms_usd.dataset.report.blocks import Chart, Table
from openrooms_usd.dataset.stats import KELVIN_STEP, Stats
from openrooms_usd.dataset.tally import DEPTH_BINS, DEPTH_STEP_M


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
            return wording.share(value, total) if self.as_share else wording.count(value)

        rows = sorted(counts.items(), key=lambda row: (-row[1], row[0]))
        table = Table.of(
            ("", self.unit, "share"),
            [(name, f"{value:,.0f}", wording.share(value, total)) for name, value in rows],
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
        svg = charts.histogram(drawn, self.end, self.below, self.beside,
                               at_least=self.at_least, log=self.log)  # fmt: skip
        rows = [
            (self._named(low), f"{number:,}", wording.share(number, total))
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
    _Ranking("Pixels by class", lambda stats: stats.pixels, "pixels",
             "OpenRooms' 45 classes.", as_share=True),
    _Ranking("Pixels by material", lambda stats: stats.materials, "pixels", as_share=True),
    _Ranking("Pixels by family of textures", lambda stats: stats.families, "pixels",
             as_share=True),
    _Histogram("Depth", lambda stats: stats.depth_m, _after(DEPTH_STEP_M), "depth in m",
               "% of pixels", (0.0, 5.0), "The last column takes all that is farther.",
               as_share=True, open_from=DEPTH_STEP_M * (DEPTH_BINS - 1)),
    _Ranking("Lights by kind", lambda stats: stats.lights, "lights",
             "Elsewhere is what comes in past all openings. " + _EVERY_VARIANT),
    _Histogram("Lamps that are on in a room", lambda stats: stats.lamps_a_room, _after(1.0),
               "lamps", "rooms and variants", (-0.5, 5.5), whole=True),
    _Histogram("Power of lamps", lambda stats: stats.lamp_lumen, _next_step, "lumen", "lamps",
               (10.0, 1e4), "Lamps that are on. " + _EVERY_VARIANT, log=True),
    _Histogram("Colour of lamps", lambda stats: stats.lamp_kelvin, _after(KELVIN_STEP),
               "colour temperature in K", "lamps", (2000.0, 7000.0),
               "Lamps that are on. " + _EVERY_VARIANT),
    _Histogram("Light through openings", lambda stats: stats.opening_lumen, _next_step, "lumen",
               "openings", (10.0, 1e5), _EVERY_VARIANT, log=True),
)  # fmt: skip


def contents(stats: Stats) -> Iterator[Chart]:
    """What the views show: rooms, objects, pixels, materials, depth, lights."""
    for one in _CONTENTS:
        if chart := one.chart(stats):
            yield chart
