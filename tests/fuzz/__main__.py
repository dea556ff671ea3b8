"""Runs the campaign, ``python -m tests.fuzz --cases 20000``, and says what became of its cases."""

import json
import os
import shutil
import sys
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Final

import click

from tests.fuzz.case import BAD, VERDICTS, Outcome
from tests.fuzz.kinds import Kind
from tests.fuzz.running import SOURCES, Campaign, Case, kinds_of, run
from tests.fuzz.spoiling import prepare

TITLES: Final = ("kind", "cases", *VERDICTS, "mean ms", "worst s", "worst MiB")
_EXAMPLES: Final = 3


def row(name: str, found: Sequence[Outcome]) -> list[Any]:
    """What became of a kind's cases, as `TITLES` says."""
    counts = Counter(outcome.verdict for outcome in found)
    seconds = [outcome.seconds for outcome in found] or [0.0]
    return [
        name,
        len(found),
        *(counts[verdict] for verdict in VERDICTS),
        round(1000 * sum(seconds) / len(seconds), 1),
        round(max(seconds), 2),
        round(max((outcome.mebibytes for outcome in found), default=0.0)),
    ]


def rows(found: Sequence[Outcome]) -> list[list[Any]]:
    """One for each kind, the last one for all of them."""
    kinds: defaultdict[str, list[Outcome]] = defaultdict(list)
    for outcome in found:
        kinds[outcome.kind].append(outcome)
    return [*(row(name, kinds[name]) for name in sorted(kinds)), row("all", found)]


def unsound(found: Sequence[Outcome]) -> list[Outcome]:
    """Those that were refused although nothing was spoilt."""
    return [o for o in found if o.sound and o.verdict != "accepted" and o.verdict not in BAD]


def defects(found: Sequence[Outcome]) -> list[dict[str, Any]]:
    """Those that are alike once, the most frequent first."""
    alike: defaultdict[tuple[str, str, str], list[Outcome]] = defaultdict(list)
    for outcome in found:
        if outcome.verdict in BAD:
            alike[outcome.verdict, outcome.what, outcome.where].append(outcome)
    return [
        {
            "verdict": verdict,
            "what": what,
            "where": where,
            "cases": len(outcomes),
            "kinds": sorted({outcome.kind for outcome in outcomes}),
            "examples": [again(o) for o in _one_of_each_kind(outcomes)[:_EXAMPLES]],
            "said": outcomes[0].said,
        }
        for (verdict, what, where), outcomes in sorted(
            alike.items(), key=lambda item: (-len(item[1]), item[0])
        )
    ]


def _one_of_each_kind(outcomes: Sequence[Outcome]) -> list[Outcome]:
    return list({outcome.kind: outcome for outcome in reversed(outcomes)}.values())


def again(outcome: Outcome) -> str:
    """A case, as the command line takes it."""
    return f"--only {outcome.kind} --case {outcome.number}"


def as_dict(found: Sequence[Outcome]) -> dict[str, Any]:
    """All of it as plain data."""
    return {
        "rows": [dict(zip(TITLES, cells, strict=True)) for cells in rows(found)],
        "unsound": [asdict(outcome) for outcome in unsound(found)],
        "defects": defects(found),
    }


def text(found: Sequence[Outcome]) -> str:
    """All of it for people."""
    cells = [[str(cell) for cell in line] for line in (TITLES, *rows(found))]
    widths = [max(len(line[i]) for line in cells) for i in range(len(TITLES))]
    lines = [
        "  ".join([line[0].ljust(widths[0]), *map(str.rjust, line[1:], widths[1:])])
        for line in cells
    ]
    if refused := unsound(found):
        lines.append(f"refused although nothing was spoilt: {', '.join(map(again, refused))}")
    for defect in defects(found):
        what = "{cases} x {verdict}: {what} at {where}".format(**defect)
        lines.append(f"\n{what} ({', '.join(defect['kinds'][:4])})")
        lines.append(f"  {defect['examples'][0]}\n  {defect['said'][:200]!r}")
    return "\n".join(lines)


_EVERY = 20.0  # seconds between lines of progress


@click.command()
@click.option("--cases", type=click.IntRange(1), default=20_000, show_default=True)
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--only", metavar="KIND", help="This kind alone, or those that begin so.")
@click.option("--case", "number", type=click.IntRange(0), help="This case of the kind alone.")
@click.option("--keep", type=click.Path(path_type=Path), help="Where to save what went wrong.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write all.")
@click.option("--workers", type=click.IntRange(1, 64), default=2, show_default=True)
@click.option("--seconds", type=float, default=20.0, show_default=True, help="A case may take.")
@click.option("--mebibytes", type=float, default=2048.0, show_default=True, help="It may take.")
@click.option("--planted", "faulty", is_flag=True, help="Kinds that go wrong on purpose.")
@click.option("--list", "listed", is_flag=True, help="Print the kinds.")
def main(
    cases: int,
    seed: int,
    only: str | None,
    number: int | None,
    keep: Path | None,
    target: Path | None,
    workers: int,
    seconds: float,
    mebibytes: float,
    faulty: bool,
    listed: bool,
) -> None:
    """Give broken and hostile input of every kind to the commands that read it.

    Leaves with 1 when a case ends otherwise than refused in a sentence or accepted.
    """
    if sys.platform != "linux":
        raise click.ClickException("the campaign measures processes as Linux shows them")
    sources = ("planted",) if faulty else SOURCES
    kinds, skipped = _chosen(kinds_of(sources), only)
    if listed:
        click.echo("\n".join([*kinds, *skipped]))
        return
    began, found = time.monotonic(), []
    with tempfile.TemporaryDirectory(prefix="fuzz", ignore_cleanup_errors=True) as place:
        folder = Path(place)
        os.environ.setdefault("ORUSD_CACHE", str(folder / "cache"))
        campaign = Campaign(sources, seed, folder / "planted", folder, seconds, mebibytes)
        _plant(kinds.values(), campaign.planted)
        wanted = (
            schedule(list(kinds.values()), cases)
            if number is None
            else [(name, number) for name in kinds]
        )
        try:
            for outcome in _with_progress(run(campaign, wanted, workers), len(wanted)):
                found.append(outcome)
                if keep and (outcome.verdict in BAD or number is not None):
                    _save(kinds[outcome.kind], outcome, campaign, keep)
        except KeyboardInterrupt:
            click.echo("interrupted: what follows is of the cases so far", err=True)
    took = round(time.monotonic() - began, 1)
    said = text(found) if number is None else json.dumps([*map(asdict, found)], indent=1)
    click.echo(said)
    for name, packages in skipped.items() if number is None else ():
        click.echo(f"skipped {name}: {packages} is not installed")
    click.echo(f"{took} s", err=True)
    if target:
        data = {"seed": seed, "seconds": took, "skipped": skipped, **as_dict(found)}
        target.write_text(json.dumps(data, indent=1) + "\n")
    sys.exit(any(outcome.verdict in BAD for outcome in found))


def _chosen(kinds: dict[str, Kind], only: str | None) -> tuple[dict[str, Kind], dict[str, str]]:
    """The kinds that are asked for and can run, and what the others lack."""
    if only is not None:
        exact = only in kinds
        kinds = {n: k for n, k in kinds.items() if n == only or (not exact and n.startswith(only))}
    if not kinds:
        raise click.UsageError(f"no kind is named {only!r}: --list prints them")
    lacking = {
        name: ", ".join(package for package in kind.needs if find_spec(package) is None)
        for name, kind in kinds.items()
    }
    skipped = {name: packages for name, packages in lacking.items() if packages}
    return {name: kind for name, kind in kinds.items() if name not in skipped}, skipped


def _with_progress(outcomes: Iterator[Outcome], cases: int) -> Iterator[Outcome]:
    said, bad = time.monotonic(), 0
    for done, outcome in enumerate(outcomes, 1):
        bad += outcome.verdict in BAD
        if time.monotonic() - said > _EVERY:
            said = time.monotonic()
            click.echo(f"{done} of {cases} cases, {bad} bad", err=True)
        yield outcome


def schedule(kinds: Sequence[Kind], cases: int) -> list[Case]:
    """So many cases by the kinds' shares, in turn; the same whatever their number.

    Args:
        kinds: Those that can run.
        cases: How many.
    """
    given: list[Case] = []
    counts = dict.fromkeys((kind.name for kind in kinds), 0)

    def turns() -> Iterator[str]:
        # All of them once, then by their shares.
        yield from counts
        while True:
            for turn in range(max(kind.share for kind in kinds)):
                yield from (kind.name for kind in kinds if kind.share > turn)

    for name in turns():
        if len(given) == cases:
            break
        given.append((name, counts[name]))
        counts[name] += 1
    return given


def _plant(kinds: Sequence[Kind], folder: Path) -> None:
    """Write the sound inputs in a process of its own: threads of libraries must not be forked."""
    process = get_context("fork").Process(target=_plant_all, args=(list(kinds), folder))
    process.start()
    process.join()
    if process.exitcode:
        raise click.ClickException("the sound inputs could not be written")


def _plant_all(kinds: Sequence[Kind], folder: Path) -> None:
    for kind in kinds:
        (folder / kind.name).mkdir(parents=True)
        kind.plant(folder / kind.name)


def _save(kind: Kind, outcome: Outcome, campaign: Campaign, keep: Path) -> None:
    """The input of a case, as it was given."""
    place = keep / f"{kind.name}-{outcome.number}"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    prepare(kind, outcome.number, campaign.seed, campaign.planted / kind.name, place)
    (place / "outcome.json").write_text(json.dumps(asdict(outcome), indent=1) + "\n")


if __name__ == "__main__":
    main()
