"""What real captures become: outlines, openings, objects, exports; before and after a change.

Each folder of data holds `captures.json`, `data` and `truth`; without one there is nothing to run.
"""

import shlex
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import click

from benchmarks.real.captures import Capture, captures_of
from benchmarks.real.rows import Row, cells, score
from benchmarks.real.running import outcome_of
from benchmarks.real.sources import SOURCES, Source
from benchmarks.real.totals import totals, verdicts
from benchmarks.report import publish, table
from benchmarks.scenes import ORUSD

DATA: Final = Path(__file__).parents[3] / "shared" / "data" / "real_dev"


@click.command()
@click.option("--data", "folders", multiple=True, type=click.Path(path_type=Path))
@click.option("--only", multiple=True, metavar="CAPTURE", help="This capture alone; repeated.")
@click.option("--tool", help="Another version of the orusd command.")
@click.option("--work", type=click.Path(path_type=Path), help="Where rooms are kept.")
@click.option("--reuse", is_flag=True, help="Score what is in --work.")
@click.option("--timeout", type=float, default=400.0, show_default=True, help="Seconds of a run.")
@click.option("--derived/--no-derived", default=True, help="Also on their side, and in mm.")
@click.option("--fetch-list", is_flag=True, help="Print where public captures come from.")
@click.option("--save", "--json", "target", type=click.Path(path_type=Path))
def main(
    folders: tuple[Path, ...],
    only: tuple[str, ...],
    tool: str | None,
    work: Path | None,
    reuse: bool,
    timeout: float,
    derived: bool,
    fetch_list: bool,
    target: Path | None,
) -> None:
    """Print what became of each capture, and what is reached of the targets."""
    if fetch_list:
        click.echo(table(Source._fields, [list(source) for source in SOURCES]))
        return
    captures: list[Capture] = []
    for folder in folders or (DATA,):
        if not (folder / "captures.json").exists():
            click.echo(f"skipped: there is no captures.json in {folder}", err=True)
            continue
        captures += captures_of(folder, only, derived)
    if not captures:
        click.echo("no capture to run: --data names a folder, --fetch-list where some come from")
        return
    command = shlex.split(tool) if tool else list(ORUSD)
    with ExitStack() as stack:
        base = (work or Path(stack.enter_context(tempfile.TemporaryDirectory()))).resolve()
        rows = [
            row for capture in captures for row in _rows(capture, base, command, timeout, reuse)
        ]
    found = totals(captures, rows)
    data = {"totals": found, "rows": [_saved(row) for row in rows]}
    publish("real", data, "\n\n".join([_lines(rows), _targets(found), _confidence(found)]), target)


def _rows(
    capture: Capture, base: Path, command: Sequence[str], timeout: float, reuse: bool
) -> list[Row]:
    rows = []
    for run in capture.runs:
        place = base / capture.name / run.name.replace(" ", "_")
        row = score(capture, run, outcome_of(run, place, command, timeout, reuse))
        click.echo(", ".join(f"{k} {v}" for k, v in cells(row).items() if v is not None), err=True)
        rows.append(row)
    return rows


def _saved(row: Row) -> dict[str, Any]:
    """A row as JSON; sets of identifiers are sorted."""
    kept = asdict(row)
    if row.export is not None:
        kept["export"]["made"] = {group: sorted(keys) for group, keys in row.export.made.items()}
        kept["export"]["equal"] = row.export.equal
    return kept


def _lines(rows: Sequence[Row]) -> str:
    lines = [cells(row) for row in rows]
    titles = list(dict.fromkeys(name for line in lines for name in line))
    return table(titles, [[line.get(title) for title in titles] for line in lines])


def _targets(found: dict[str, Any]) -> str:
    words = {None: "-", True: "yes", False: "no"}
    return table(
        ["", "reached", "target", "met"],
        [
            [name.replace("_", " "), value, aim, words[met]]
            for name, value, aim, met in verdicts(found)
        ],
    )


def _confidence(found: dict[str, Any]) -> str:
    titles = ["confidence of openings", "how many", "claimed", "true"]
    return table(titles, found["confidence"])


if __name__ == "__main__":
    main()
