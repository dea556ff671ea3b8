"""Physics: collision shapes, pushes and speed.

shapes: seconds and hulls of every way to collision shapes, against how far they stick out and in.
push: how far both engines push the paper's cabinet, against Coulomb's closed form, by step.
speed: steps a second of furnished rooms at rest, and how far things creep in two seconds; both
engines in one run.
"""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import click

from benchmarks.physics import push as physics_push
from benchmarks.physics.shapes import HARD, ORDINARY, QUICK, shape_rows
from benchmarks.report import publish, table

Section = tuple[list[dict[str, Any]], str]


def shapes(quick: bool, folder: Path) -> Section:
    """What the physics stage takes, one hull, and one box."""
    del folder
    rows = shape_rows(QUICK if quick else ORDINARY + HARD)
    return rows, table(tuple(rows[0]), [list(row.values()) for row in rows])


SECTIONS: Final[dict[str, Callable[[bool, Path], Section]]] = {
    "shapes": shapes,
    "push": physics_push.push,
    "speed": physics_push.speed,
}


@click.command(help=__doc__)
@click.option("--section", "chosen", multiple=True, help="Repeatable; all by default.")
@click.option("--quick", is_flag=True, help="Few objects, few steps.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(chosen: tuple[str, ...], quick: bool, target: Path | None) -> None:
    with tempfile.TemporaryDirectory() as folder:
        found = {name: SECTIONS[name](quick, Path(folder)) for name in chosen or SECTIONS}
    text = "\n\n".join(f"## {name}\n\n{markdown}" for name, (_, markdown) in found.items())
    publish("physics", {name: rows for name, (rows, _) in found.items()}, text, target)


if __name__ == "__main__":
    main()
