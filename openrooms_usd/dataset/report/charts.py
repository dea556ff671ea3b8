"""Charts as SVG that a page holds in itself: the same numbers give the same bytes.

Words in them are text, which can be searched, and have the colour of the text around them.
"""

import io
import itertools
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from openrooms_usd.errors import MissingPackageError
from openrooms_usd.names import CREATOR

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


MOST_BARS: Final = 24
"""More than these are one bar together, where they can be added."""

# As wide as a phone, inches at 72 to each.
_WIDTH: Final = 4.7
_BAR_HEIGHT, _HISTOGRAM_HEIGHT = 0.25, 2.4
_BAR: Final = "#4a80b5"
_FAINT: Final = 0.45
# Stands for the colour of the text around, which no drawing knows.
_INK: Final = "#010203"
_LONGEST_NAME: Final = 28
_STYLE: Final = {
    "svg.fonttype": "none",
    "svg.hashsalt": CREATOR,
    "text.parse_math": False,
    "axes.unicode_minus": False,
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 11.0,
    "text.color": _INK,
    "axes.labelcolor": _INK,
    "axes.edgecolor": _INK,
    "xtick.color": _INK,
    "ytick.color": _INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
}


def check_installed() -> None:
    """See that there is what draws.

    Raises:
        MissingPackageError: There is not.
    """
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise MissingPackageError(
            "the charts of a report need the package 'matplotlib'",
            remedy="pip install 'openrooms-usd[report]'",
        ) from error


def bars(
    rows: Sequence[tuple[str, float]], shown: Callable[[float], str], *, has_rest: bool = False
) -> str:
    """A bar for each name, the first on top, with its number beside it.

    Args:
        rows: Names and numbers, none negative.
        shown: Words a number.
        has_rest: Whether the last one stands for many.
    """
    values = [value for _, value in rows]
    height = 0.15 + _BAR_HEIGHT * len(rows)
    with _drawing(height) as (figure, axes):
        drawn = axes.barh(range(len(rows)), values, height=0.7, color=_BAR)
        if has_rest:
            drawn[-1].set_alpha(_FAINT)
        axes.bar_label(drawn, labels=[shown(value) for value in values], padding=3)
        axes.set_yticks(range(len(rows)), labels=[_short(name) for name, _ in rows])
        axes.tick_params(left=False)
        axes.xaxis.set_visible(False)
        axes.spines[:].set_visible(False)
        axes.set_ylim(len(rows) - 0.4, -0.6)
        # Room for the longest number.
        axes.set_xlim(0.0, 1.22 * max(*values, 1e-12))
        return _svg(figure)


def histogram(
    bins: Mapping[float, float],
    ends: Callable[[float], float],
    below: str,
    beside: str,
    *,
    at_least: tuple[float, float],
    log: bool = False,
) -> str:
    """A column for each bin.

    Args:
        bins: Numbers by the lower ends of their bins.
        ends: The upper end of a bin by its lower one.
        below: What is on the axis below, with its unit.
        beside: What is on the axis beside.
        at_least: What the axis below spans, whatever there is.
        log: Whether it goes by decades.
    """
    lows, values = sorted(bins), [bins[low] for low in sorted(bins)]
    with _drawing(_HISTOGRAM_HEIGHT) as (figure, axes):
        widths = [ends(low) - low for low in lows]
        axes.bar(lows, values, width=widths, align="edge", color=_BAR, edgecolor="none", lw=0.0)
        if log:
            axes.set_xscale("log")
        axes.set_xlim(min(at_least[0], lows[0]), max(at_least[1], ends(lows[-1])))
        if log:
            axes.minorticks_off()
        else:
            axes.locator_params(axis="x", nbins=7, integer=True)
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:,.0f}")
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:,.6g}")
        axes.locator_params(axis="y", nbins=4, integer=max(values) >= 1.0)
        axes.set_xlabel(below)
        axes.set_ylabel(beside)
        return _svg(figure)


def most(rows: Mapping[str, float]) -> list[tuple[str, float]]:
    """The largest numbers first; what is beyond `MOST_BARS` added up."""
    ranked = sorted(rows.items(), key=lambda row: (-row[1], row[0]))
    if len(ranked) <= MOST_BARS:
        return ranked
    rest = ranked[MOST_BARS - 1 :]
    return [*ranked[: MOST_BARS - 1], (f"{len(rest)} others", math.fsum(v for _, v in rest))]


def distinct(svg: str, name: str) -> str:
    """The same chart with names of its parts that no other chart of a page has."""
    return re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}-", svg)


@contextmanager
def _drawing(height: float) -> Iterator[tuple["Figure", "Axes"]]:
    import matplotlib
    from matplotlib.figure import Figure

    style: dict[Any, Any] = {**_STYLE}
    with matplotlib.rc_context(style):
        figure = Figure(figsize=(_WIDTH, height), layout="constrained")
        yield figure, figure.subplots()


def _svg(figure: "Figure") -> str:
    file = io.StringIO()
    nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
    figure.savefig(file, format="svg", transparent=True, metadata=nothing)
    text = file.getvalue()
    text = text[text.index("<svg") :].replace(_INK, "currentColor")
    # Its size is the page's affair; its frame stays.
    return re.sub(r' (?:width|height)="[0-9.]+pt"', "", text, count=2).rstrip() + "\n"


def _short(name: str) -> str:
    # Line breaks would push others away.
    plain = "".join(itertools.islice(" ".join(name.split()), _LONGEST_NAME))
    return plain if len(name) <= _LONGEST_NAME else f"{plain[:-1]}…"


# What the sections of a report are made of: tables, and charts with their numbers.

MOST_ROWS: Final = 60
"""Of a table; further rows are counted."""


@dataclass(frozen=True)
class Table:
    """A table; the first column names the rows.

    Attributes:
        heads: Of the columns.
        rows: As text.
        left: How many rows more there are.
    """

    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    left: int = 0

    @classmethod
    def of(cls, heads: Sequence[str], rows: Sequence[Sequence[str]]) -> "Table":
        """A table that is no longer than people read."""
        kept = tuple(tuple(row) for row in rows[:MOST_ROWS])
        return cls(tuple(heads), kept, max(0, len(rows) - MOST_ROWS))


@dataclass(frozen=True)
class Chart:
    """A chart, with its numbers as a table for those who cannot see it.

    Attributes:
        title: What it shows.
        svg: The drawing.
        table: Its numbers.
        note: What must be known to read it.
    """

    title: str
    svg: str
    table: Table
    note: str = ""


# Numbers as people read them: few digits, units that fit.

_THOUSAND: Final = 1000.0
_COUNTS: Final = ((1e9, "G"), (1e6, "M"), (1e3, "k"))
_BYTES: Final = ((1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB"))
_SECONDS: Final = ((86400.0, "days"), (3600.0, "h"), (60.0, "min"))
# From how many of the next larger unit on it is used: 90 s stay seconds.
_LEAST: Final = 2.0
_LEAST_PERCENT: Final = 0.1


def count(value: float) -> str:
    """Such as ``1.2 M``; small whole numbers stay as they are."""
    if value < 10 * _THOUSAND:
        return f"{value:,.0f}"
    return _in_units(value, _COUNTS, 1.0)


def size(value: float) -> str:
    """Bytes, such as ``27 MB``."""
    return _in_units(value, _BYTES, 1.0) if value >= _THOUSAND else f"{value:.0f} bytes"


def seconds(value: float) -> str:
    """Such as ``0.12 s`` or ``3.5 h``."""
    if value >= _LEAST * _SECONDS[-1][0]:
        return _in_units(value, _SECONDS, _LEAST)
    return f"{digits(value, 2 if value < 10.0 else 3)} s"


def share(part: float, whole: float) -> str:
    """Such as ``12 %`` or ``3.1 %``."""
    percent = 100.0 * part / whole if whole else 0.0
    if 0.0 < percent < _LEAST_PERCENT:
        return f"under {_LEAST_PERCENT} %"
    return f"{percent:.0f} %" if percent >= 10.0 or percent == 0.0 else f"{percent:.1f} %"


def digits(value: float, most: int = 3) -> str:
    """With so many significant digits, never as a power of ten."""
    rounded = float(f"{value:.{most}g}")
    return f"{rounded:,.0f}" if abs(rounded) >= 10 ** (most - 1) else f"{rounded:.12g}"


def _in_units(value: float, units: tuple[tuple[float, str], ...], least: float) -> str:
    for one, name in units:
        if value >= least * one:
            return f"{digits(value / one)} {name}"
    return digits(value)
