"""The commands ``edits adopt``, ``edits fit`` and ``edits orphans``."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from openrooms_usd import names
from openrooms_usd.cli.console import Group, echo, json_option, print_json
from openrooms_usd.spelling import listed

if TYPE_CHECKING:
    from openrooms_usd.edits.adopting import Adoption

# Rows beyond these are counted; --json lists all.
_ROWS: Final = 20
# How many names of one row.
_NAMES: Final = 4


@click.group(cls=Group)
def edits() -> None:
    """Keep what people changed in a composed room: OUT/layers/edits.usda."""


@edits.command()
@click.argument("scene", type=click.Path(path_type=Path), metavar="OUT/SCENE.USDA")
@click.option(
    "--from",
    "saved",
    type=click.Path(path_type=Path),
    help="What the other program saved, where it is not SCENE itself.",
)
@click.option("--dry-run", is_flag=True, help="Say what would be moved, and write nothing.")
@json_option
def adopt(scene: Path, saved: Path | None, dry_run: bool, as_json: bool) -> None:
    """Move what another program saved over scene.usda into layers/edits.usda.

    scene.usda is then as compose writes it. Of a file that was flattened, what differs is moved.
    """
    from openrooms_usd.edits.adopting import adopt as move
    from openrooms_usd.usd.files.diagnostics import quiet

    with quiet():
        adoption = move(scene, saved, dry_run=dry_run)
    if as_json:
        print_json(adoption.as_dict())
        return
    _print(adoption, dry_run)


def _print(adoption: "Adoption", dry_run: bool) -> None:
    for change in adoption.changes[:_ROWS]:
        said = listed(change.fields, _NAMES)
        echo(f"{'new' if change.new else 'changed':<8} {change.path}: {said}")
    if len(adoption.changes) > _ROWS:
        echo(f"{len(adoption.changes) - _ROWS} more; --json lists all")
    for sentence in adoption.left[:_ROWS]:
        echo(f"note: {sentence}")
    if adoption.compared:
        echo(f"compared {adoption.compared} values of a flattened file")
    count = f"{len(adoption.changes)} prims"
    if adoption.written:
        echo(f"moved what is said about {count} to {adoption.edits}")
    elif dry_run and adoption.changes:
        echo(f"would move what is said about {count} to {adoption.edits}")
    else:
        echo("nothing to adopt")


@edits.command()
@click.argument("out", type=click.Path(path_type=Path), metavar="OUT")
@click.option("--dry-run", is_flag=True, help="Say what would be corrected, and write nothing.")
@json_option
def fit(out: Path, dry_run: bool, as_json: bool) -> None:
    """Correct the units and axes of files that OUT/layers/edits.usda refers to.

    A file in centimetres or with Y up gets the scale and the turn that it lacks, as operations of
    the prim that refers to it.
    """
    from openrooms_usd.edits.fitting import fit as correct
    from openrooms_usd.usd.files.diagnostics import quiet

    with quiet():
        fitting = correct(out, dry_run=dry_run)
    if as_json:
        print_json(fitting.as_dict())
        return
    for misfit in (*fitting.fitted, *fitting.left):
        echo(str(misfit))
    if fitting.left:
        echo("remedy: give files without units metersPerUnit and upAxis; they are left as they are")
    done = "would correct" if dry_run else "corrected"
    count = len(fitting.fitted)
    echo(f"{done} {count} in {fitting.edits}" if count else "nothing to correct")


@edits.command()
@click.argument("out", type=click.Path(path_type=Path), metavar="OUT")
@json_option
def orphans(out: Path, as_json: bool) -> None:
    """List the opinions of OUT/layers/edits.usda that do nothing."""
    from openrooms_usd.edits.orphans import orphans_of
    from openrooms_usd.usd.files.diagnostics import quiet

    with quiet():
        found = orphans_of(out)
    if as_json:
        print_json({"orphans": [{**asdict(row), "remedy": row.remedy} for row in found]})
        return
    for row in found:
        echo(f"{row}\n  remedy: {row.remedy}")
    count = len(found)
    echo(f"{out / names.LAYERS / names.EDITS}.usda: {count or 'no'} orphans")
