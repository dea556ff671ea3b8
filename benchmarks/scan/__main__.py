"""What scans become: layout, openings, alignment, placement.

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
from benchmarks.scan.pose_sections import Alignment, Placement
from benchmarks.scan.sections import Layout, Openings, Section

# Each looks at one scan after the other.
SECTIONS: Final[dict[str, Callable[[], Section]]] = {
    "layout": Layout,
    "openings": Openings,
    "alignment": Alignment,
    "placement": Placement,
}


@click.command()
@click.option("--section", "chosen", multiple=True, type=click.Choice([*SECTIONS]))
@click.option("--split", type=click.Choice(["development", "test"]), default="development")
@click.option("--type", "types", multiple=True, help="Only rooms of these types.")
@click.option("--rooms", type=click.Path(path_type=Path), help="Where rooms are kept.")
@click.option("--quick", is_flag=True, help="One small room, few points.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where numbers go.")
def main(
    chosen: tuple[str, ...],
    split: str,
    types: tuple[str, ...],
    rooms: Path | None,
    quick: bool,
    target: Path | None,
) -> None:
    """Print the tables of scan reconstruction."""
    sections = {name: SECTIONS[name]() for name in chosen or SECTIONS}
    with ExitStack() as stack:
        folder = rooms or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        wanted = [room for room in rooms_of(split, quick) if not types or room[0] in types]
        for case in cases(wanted, folder, quick):
            click.echo(f"{case.name}: {len(case.scan.cloud):,} points", err=True)
            for section in sections.values():
                section.look(case)
    found = {name: section.rows() for name, section in sections.items()}
    text = "\n\n".join(f"## {name}\n\n{_table(rows)}" for name, rows in found.items())
    publish("scan", {"split": split, **found}, text, target)


def _table(rows: Sequence[dict[str, Any]]) -> str:
    titles = list(dict.fromkeys(key for row in rows for key in row))
    return table(
        [title.replace("_", " ") for title in titles],
        [[row.get(title) for title in titles] for row in rows],
    )


if __name__ == "__main__":
    main()
