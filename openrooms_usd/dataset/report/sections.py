"""How well and how dearly it was made, as tables and charts: errors, cost, quality, failures."""

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from typing import Any, Final

from openrooms_usd.channels import CHANNELS
from openrooms_usd.dataset.report import charts, wording
from openrooms_usd.dataset.report.blocks import Chart, Table
from openrooms_usd.dataset.stats import PHASES, Stats
from openrooms_usd.dataset.status import Failure

_HOUR_S: Final = 3600.0
_VIEWS: Final = 1000
_PHASES: Final = dict(
    zip(
        PHASES,
        ("composing the room", "translating it", "rendering", "writing"),
        strict=True,
    )
)


def errors_chart(stats: Stats) -> Chart | None:
    """The median error of every channel that has one."""
    if not stats.errors:
        return None
    rows = [(name, f"{stats.errors[name]:.3g}") for name in _in_order(stats.errors)]
    svg = charts.bars(
        sorted(stats.errors.items(), key=lambda row: (-row[1], row[0]))[: charts.MOST_BARS],
        lambda value: wording.digits(value, 2),
    )
    return Chart("Median error of channels", svg, Table.of(("channel", "error"), rows))


def channels_table(stats: Stats) -> Table:
    """Error and seconds of each channel; those that one exact ray tells in one row."""
    every = _in_order({*stats.errors, *stats.channel_seconds})
    exact = [name for name in every if name not in stats.errors and _is_exact(name)]
    rows = [_channel_row(stats, name) for name in every if name not in exact]
    if exact:
        longest = max(stats.channel_seconds[name] for name in exact)
        rows.append((f"{len(exact)} others", "exact", "", f"{wording.seconds(longest)} at most"))
    return Table.of(("channel", "median error", "90 % are below", "a view takes"), rows)


def _channel_row(stats: Stats, name: str) -> tuple[str, ...]:
    error, high = stats.errors.get(name), stats.high_errors.get(name)
    took = stats.channel_seconds.get(name)
    return (
        name,
        "none" if error is None else wording.digits(error, 2),
        "" if high is None else wording.digits(high, 2),
        "" if took is None else wording.seconds(took),
    )


def _is_exact(channel: str) -> bool:
    return channel in CHANNELS and CHANNELS[channel].kind in ("geometry", "material", "label")


def phases_chart(stats: Stats) -> Chart | None:
    """Seconds a view by phase."""
    views = sum(stats.views.values())
    if not views or not sum(stats.seconds.values()):
        return None
    rows = [(_PHASES[phase], stats.seconds.get(phase, 0.0) / views) for phase in PHASES]
    table = Table.of(("", "a view"), [(name, wording.seconds(took)) for name, took in rows])
    return Chart("Seconds a view by phase", charts.bars(rows, wording.seconds), table)


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
        ("hours of one worker", f"{wording.digits(hours)}"),
        ("cores of a worker", wording.digits(core_hours / hours if hours else 0.0)),
        ("core-hours", wording.digits(core_hours)),
        ("storage", wording.size(stats.bytes / views * _VIEWS)),
    ]
    if price is not None:
        cost = wording.digits(core_hours * price)
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
    rows = [(key, f"{value:,}", wording.share(value, total)) for key, value in ranked]
    return Table.of((name, unit, "share"), rows)


def _in_order(channels: Mapping[str, float] | set[str]) -> list[str]:
    """As the table of channels has them; what is not in it last."""
    places = {name: place for place, name in enumerate(CHANNELS)}
    return sorted(channels, key=lambda name: (places.get(name, len(places)), name))
