"""Runs the campaign: ``python -m benchmarks.fuzz --cases 20000``."""

import json
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import click

from benchmarks.fuzz import (
    captures,
    clouds,
    materials,
    models,
    planted,
    renders,
    scans,
    stages,
    targets,
)
from benchmarks.fuzz.case import BAD, Outcome, prepare
from benchmarks.fuzz.kinds import Kind
from benchmarks.fuzz.pool import Case, Pool
from benchmarks.fuzz.tally import Tally
from benchmarks.fuzz.worker import Limits

_SOURCES = (captures, scans, clouds, models, materials, stages, renders, targets)
KINDS = tuple(kind for source in _SOURCES for kind in source.KINDS)
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
    table = planted.KINDS if faulty else KINDS
    kinds = {kind.name: kind for kind in table if only is None or _is_meant(kind.name, only, table)}
    if not kinds:
        raise click.UsageError(f"no kind is named {only!r}: --list prints them")
    if listed:
        click.echo("\n".join(kinds))
        return
    skipped = {name: _lacking(kind) for name, kind in kinds.items() if _lacking(kind)}
    kinds = {name: kind for name, kind in kinds.items() if name not in skipped}
    began = time.monotonic()
    tally = Tally()
    with tempfile.TemporaryDirectory(prefix="fuzz", ignore_cleanup_errors=True) as place:
        folder = Path(place)
        os.environ.setdefault("ORUSD_CACHE", str(folder / "cache"))
        _plant(kinds.values(), folder / "planted")
        wanted = (
            schedule(list(kinds.values()), cases)
            if number is None
            else [(name, number) for name in kinds]
        )
        pool = Pool(kinds, seed, folder / "planted", folder, Limits(seconds, mebibytes), workers)
        try:
            for outcome in _with_progress(pool.run(wanted), len(wanted)):
                tally.add(outcome)
                if number is not None:
                    click.echo(json.dumps(outcome.as_dict(), indent=1))
                if keep and (outcome.verdict in BAD or number is not None):
                    _save(kinds[outcome.kind], outcome, seed, folder / "planted", keep)
        except KeyboardInterrupt:
            click.echo("interrupted: what follows is of the cases so far", err=True)
    took = time.monotonic() - began
    if number is None:
        _print(tally, skipped, took)
    if target:
        target.write_text(json.dumps(_as_dict(tally, skipped, took, seed), indent=1) + "\n")
    sys.exit(1 if tally.bad else 0)


def _with_progress(outcomes: Iterator[Outcome], cases: int) -> Iterator[Outcome]:
    said, bad = time.monotonic(), 0
    for done, outcome in enumerate(outcomes, 1):
        bad += outcome.verdict in BAD
        if time.monotonic() - said > _EVERY:
            said = time.monotonic()
            click.echo(f"{done} of {cases} cases, {bad} bad", err=True)
        yield outcome


def _is_meant(name: str, only: str, table: Sequence[Kind]) -> bool:
    exact = any(kind.name == only for kind in table)
    return name == only if exact else name.startswith(only)


def _lacking(kind: Kind) -> str:
    """The packages that a kind needs and that are not there."""
    return ", ".join(name for name in kind.needs if find_spec(name) is None)


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


def _plant(kinds: Any, folder: Path) -> None:
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


def _save(kind: Kind, outcome: Outcome, seed: int, planted_at: Path, keep: Path) -> None:
    """The input of a case, as it was given."""
    place = keep / f"{kind.name}-{outcome.number}"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    prepare(kind, outcome.number, seed, planted_at / kind.name, place)
    (place / "outcome.json").write_text(json.dumps(outcome.as_dict(), indent=1) + "\n")


def _print(tally: Tally, skipped: dict[str, str], took: float) -> None:
    titles, rows = tally.table()
    cells = [[str(cell) for cell in row] for row in [list(titles), *rows]]
    widths = [max(len(row[i]) for row in cells) for i in range(len(titles))]
    for row in cells:
        first, *others = (
            cell.ljust(width) if i == 0 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        click.echo("  ".join([first, *others]))
    for name, packages in skipped.items():
        click.echo(f"skipped {name}: {packages} is not installed")
    if tally.unsound:
        cases = ", ".join(f"--only {o.kind} --case {o.number}" for o in tally.unsound)
        click.echo(f"refused although nothing was spoilt: {cases}")
    click.echo(f"{took:.0f} s")
    for row in tally.grouped():
        kinds = ", ".join(row["kinds"][:4])
        click.echo(
            f"\n{row['cases']} x {row['verdict']}: {row['what']} at {row['where']} ({kinds})"
        )
        click.echo(f"  {row['examples'][0]}")
        click.echo(f"  {row['said'][:200]!r}")


def _as_dict(tally: Tally, skipped: dict[str, str], took: float, seed: int) -> dict[str, Any]:
    titles, rows = tally.table()
    return {
        "seed": seed,
        "seconds": round(took, 1),
        "rows": [dict(zip(titles, row, strict=True)) for row in rows],
        "mean_ms": {
            name: round(1000 * row.seconds / max(row.cases, 1), 1)
            for name, row in sorted(tally.rows.items())
        },
        "skipped": skipped,
        "unsound": [outcome.as_dict() for outcome in tally.unsound],
        "defects": tally.grouped(),
    }


if __name__ == "__main__":
    main()
