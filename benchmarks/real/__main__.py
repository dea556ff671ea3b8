"""What real captures become: outlines, openings, objects, exports; before and after a change.

Each folder of data holds `captures.json`, `data` and `truth`; without one there is nothing to run.
"""

import shlex
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import click
import numpy as np

from benchmarks.real.bodies import BodyScore
from benchmarks.real.captures import SOURCES, Capture, Source, captures_of
from benchmarks.real.plans import OpeningScore
from benchmarks.real.rows import AXIS, Row, cells, score
from benchmarks.real.running import outcome_of
from benchmarks.real.things import ThingScore
from benchmarks.report import publish, table
from benchmarks.scan.scores import NOTHING
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


# All runs together, against what is to be reached.

# What is to be reached on captures that nobody tuned on: at least, or at most.
AT_LEAST: Final = {
    "iou": 0.95,
    "corners_precision": 0.85,
    "corners_recall": 0.85,
    "labelled_precision": 0.85,
    "labelled_recall": 0.80,
    "plain_precision": 0.70,
    "plain_recall": 0.60,
    "category": 0.95,
    "exports_equal": 1.0,
}
AT_MOST: Final = {
    "invented": 0,
    "outside": 0,
    "wrong_axis": 0,
    "wrong_unit": 0,
    "tilted": 0,
    "changed_in_silence": 0,
    "calibration": 0.1,
}
# What is told beside them.
BESIDE: Final = ("sizes", "pairs", "floating", "states", "exports_alike", "refused", "seconds")


def totals(captures: Iterable[Capture], rows: Sequence[Row]) -> dict[str, Any]:
    """The figures over all runs; what nothing was run for is None.

    Layout counts the best run of each capture: the first, or the one that was told the vertical
    where the first was refused or lies on its side. Openings count that run, and those without
    labels.
    """
    by_capture: dict[str, list[Row]] = {}
    for row in rows:
        by_capture.setdefault(row.capture, []).append(row)
    best = {
        capture.name: _best(found, capture.truth.up_axis != "z")
        for capture in captures
        if (found := by_capture.get(capture.name))
    }
    truths = {capture.name: capture.truth for capture in captures}
    scans = {name: row for name, row in best.items() if row.kind == "scan"}
    plans = [row.plan for name, row in scans.items() if row.plan and not truths[name].loose]
    labelled, plain = _openings(rows, scans)
    things = sum((row.things for row in scans.values() if row.things), ThingScore())
    bodies = sum((row.bodies for row in rows if row.bodies), BodyScore())
    exports = [row.export for row in rows if row.export]
    corners = sum((plan.corners for plan in plans), NOTHING)
    return {
        "iou": float(np.mean([plan.iou for plan in plans])) if plans else None,
        "rooms": len(plans),
        **_both("corners", corners if plans else None),
        **_both("labelled", labelled.typed if labelled.typed.true else None),
        **_both("plain", plain.typed if plain.typed.true else None),
        "calibration": (labelled + plain).calibration.gap,
        "confidence": (labelled + plain).calibration.steps(),
        "category": things.category / things.present if things.present else None,
        "sizes": things.size / things.sized if things.sized else None,
        "invented": things.invented,
        "things": asdict(things),
        **{name: value for name, value in asdict(bodies).items() if name != "things"},
        "exports": len(exports),
        "exports_equal": sum(e.equal for e in exports) / len(exports) if exports else None,
        "states": f"{sum(e.states for e in exports)}/{sum(e.doors for e in exports)}",
        "exports_alike": _alike(by_capture.values()),
        "wrong_axis": sum(
            _axis_unnoticed(by_capture[name][0]) for name in scans if truths[name].up_axis != "z"
        ),
        "wrong_unit": sum(
            not by_capture[name][0].unit_named for name in scans if truths[name].unit != 1.0
        ),
        "tilted": sum(row.tilted and not row.run.derived for row in rows),
        "changed": sum(row.run.derived for row in rows),
        "changed_in_silence": sum(row.run.derived and not row.honest for row in rows),
        "refused": sum(row.refusal is not None and not row.run.derived for row in rows),
        "seconds": sum(row.seconds for row in rows),
    }


def _both(name: str, counts: Any) -> dict[str, Any]:
    if counts is None:
        return {f"{name}_precision": None, f"{name}_recall": None}
    precision = counts.hits / counts.found if counts.found else 0.0
    return {
        f"{name}_precision": precision,
        f"{name}_recall": counts.recall,
        f"{name}_counts": f"{counts.hits}/{counts.found}/{counts.true}",
    }


def _best(rows: Sequence[Row], other_axis: bool) -> Row:
    told = next((row for row in rows if row.run.name == "told"), None)
    first = rows[0]
    return told if told and other_axis and (first.refusal is not None or first.tilted) else first


def _openings(rows: Sequence[Row], scans: Mapping[str, Row]) -> tuple[OpeningScore, OpeningScore]:
    """Openings with labels and without, each capture once in each."""
    total = {True: OpeningScore(), False: OpeningScore()}
    for row in rows:
        if row.run.derived or row.plan is None or row.plan.openings is None:
            continue
        if row.run.name in ("plain", "told") and scans[row.capture] is not row:
            continue
        total[row.run.labels] += row.plan.openings
    return total[True], total[False]


def _axis_unnoticed(first: Row) -> bool:
    """Whether a first run neither finds the vertical nor is refused with its name."""
    if first.refusal is not None:
        return not first.names_up
    return first.degrees is None or first.degrees >= AXIS[0]


def _alike(captures: Iterable[Sequence[Row]]) -> str:
    """How many captures with two exports became the same room twice."""
    pairs = [
        [row.export.made for row in rows if row.export]
        for rows in captures
        if sum(row.export is not None for row in rows) > 1
    ]
    alike = sum(all(made == some[0] and made["objects"] for made in some) for some in pairs)
    return f"{alike}/{len(pairs)}"


def verdicts(found: Mapping[str, Any]) -> list[tuple[str, Any, str, bool | None]]:
    """Each target: its name, what was reached, what is to be, and whether it is."""
    lines: list[tuple[str, Any, str, bool | None]] = []
    for name, least in AT_LEAST.items():
        value = found.get(name)
        lines.append((name, value, f">= {least:g}", None if value is None else value >= least))
    for name, most in AT_MOST.items():
        value = found.get(name)
        lines.append((name, value, f"<= {most:g}", None if value is None else abs(value) <= most))
    lines += [(name, found.get(name), "", None) for name in BESIDE]
    return lines


if __name__ == "__main__":
    main()
