"""What scans become: layout, openings, alignment, placement; growth of time; hard cases.

Scans are simulated from generated rooms, so that the truth is known. Without ``--split test``
only rooms of the development seeds are run.
"""

import tempfile
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Final

import click

from benchmarks.report import publish, table
from benchmarks.scan.cases import cases, rooms_of
from benchmarks.scan.contact_cases import contact_cases
from benchmarks.scan.growth import growth
from benchmarks.scan.hard import hard_cases
from benchmarks.scan.pose_sections import Alignment, Placement
from benchmarks.scan.sections import Layout, Openings, Row, Section, has_open3d

NO_OPEN3D: Final = "Open3D is not installed: its rows are left out."

# Sections that look at one scan after the other, and those that make scans of their own.
PER_SCAN: Final[dict[str, Callable[[], Section]]] = {
    "layout": Layout,
    "openings": Openings,
    "alignment": Alignment,
    "placement": Placement,
}
APART: Final[dict[str, Callable[[bool], list[Row]]]] = {
    "growth": growth,
    "hard cases": hard_cases,
    "hard contacts": contact_cases,
}


@click.command()
@click.option("--section", "sections", multiple=True, type=click.Choice([*PER_SCAN, *APART]))
@click.option("--split", type=click.Choice(["development", "test"]), default="development")
@click.option("--type", "types", multiple=True, help="Only rooms of these types.")
@click.option("--rooms", type=click.Path(path_type=Path), help="Where rooms are kept.")
@click.option("--quick", is_flag=True, help="One small room, few points.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where numbers go.")
def main(
    sections: tuple[str, ...],
    split: str,
    types: tuple[str, ...],
    rooms: Path | None,
    quick: bool,
    target: Path | None,
) -> None:
    """Print the tables of scan reconstruction."""
    wanted = sections or (*PER_SCAN, *APART)
    with ExitStack() as stack:
        folder = rooms or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        chosen = [room for room in rooms_of(split, quick) if not types or room[0] in types]
        found = per_scan([name for name in wanted if name in PER_SCAN], chosen, folder, quick)
    found |= {name: work(quick) for name, work in APART.items() if name in wanted}
    text = "\n\n".join(f"## {name}\n\n{_table(rows)}" for name, rows in found.items())
    notes = "" if has_open3d() else f"\n\n{NO_OPEN3D}"
    publish("scan", {"split": split, **found}, text + notes, target)


def per_scan(
    names: Sequence[str], rooms: Sequence[tuple[str, int]], folder: Path, quick: bool
) -> dict[str, list[Row]]:
    """The rows of sections that look at every scan."""
    sections = {name: PER_SCAN[name]() for name in names}
    if sections:
        for case in cases(rooms, folder, quick):
            click.echo(f"{case.name}: {len(case.scan.cloud):,} points", err=True)
            for section in sections.values():
                section.look(case)
    found = {name: section.rows() for name, section in sections.items()}
    if isinstance(layout := sections.get("layout"), Layout):
        found["layout, scan by scan"] = layout.each()
    return found


def _table(rows: Sequence[dict[str, Any]]) -> str:
    titles = list(dict.fromkeys(key for row in rows for key in row))
    return table(
        [title.replace("_", " ") for title in titles],
        [[row.get(title) for title in titles] for row in rows],
    )


if __name__ == "__main__":
    main()
