"""The commands of ``edit``: pages that correct a room, and the layer of what people changed."""

import os
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from openrooms_usd import names
from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Group
from openrooms_usd.cli.console import answer, echo, most, print_result
from openrooms_usd.cli.pages import page_options, show
from openrooms_usd.spelling import listed

if TYPE_CHECKING:
    from openrooms_usd.edits.adopting import Adoption

# Rows beyond these are counted; --verbose lists all.
_ROWS: Final = 20
# How many names of one row.
_NAMES: Final = 4


_ROOM: Final = click.argument("room", type=click.Path(path_type=Path), metavar="STAGE|room.yaml")
_DESCRIPTION: Final = click.option(
    "--description",
    type=click.Path(path_type=Path),
    metavar="ROOM.yaml",
    help="What STAGE is composed from: the page can then compose it again.",
)
_COMPOSED: Final = click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    help="Where a room.yaml is composed to.  [default: composed, beside it]",
)


def _folder_of(context: click.Context, parameter: click.Parameter, given: Path) -> Path:
    """The composed room's folder, of which scene.usda may be named as well."""
    return given.parent if given.name == names.SCENE else given


_OUT: Final = click.argument(
    "out", type=click.Path(path_type=Path), metavar="OUT", callback=_folder_of
)


@click.group(cls=Group, former={"adopt": "import-changes", "fit": "fix-units"})
def edit() -> None:
    """Correct a room in the browser, or keep what other programs changed in it.

    What is changed of a composed room is in OUT/layers/edits.usda, which compose never overwrites.
    """


@edit.command(example="orusd edit layout lounge.ply -o lounge")
@click.argument("source", type=click.Path(path_type=Path), metavar="SCAN|room.yaml")
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    help="Where a SCAN is imported to; a room.yaml needs none.",
)
@click.option(
    "--importer",
    default="scan",
    show_default=True,
    metavar="KIND",
    help="What reads SCAN: a kind of `orusd import`.",
)
@page_options
def layout(source: Path, out: Path | None, importer: str, **where: Any) -> None:
    """Correct the walls, doors, windows and height of a room over the points of its scan."""
    from openrooms_usd.view.plan.session import Session, room_file

    with progress_bar("reading"):
        page = Session(room_file(source, out, importer)).app()
    show(page, **where)


@edit.command(example="orusd edit materials out/scene.usda")
@_ROOM
@_DESCRIPTION
@_COMPOSED
@page_options
def materials(room: Path, description: Path | None, out: Path | None, **where: Any) -> None:
    """Say what the parts of a room are made of: in the edits of STAGE, or in room.yaml."""
    from openrooms_usd.view.corrections import corrections
    from openrooms_usd.view.materials import materials_app

    with progress_bar("reading"):
        page = materials_app(corrections(room, description, out))
    show(page, **where)


@edit.command(example="orusd edit objects out/scene.usda")
@_ROOM
@_DESCRIPTION
@_COMPOSED
@page_options
def objects(room: Path, description: Path | None, out: Path | None, **where: Any) -> None:
    """Move, rename, exchange, copy and remove furniture: in the edits of STAGE, or in room.yaml."""
    from openrooms_usd.view.corrections import corrections
    from openrooms_usd.view.objects import objects_app

    with progress_bar("reading"):
        page = objects_app(corrections(room, description, out))
    show(page, **where)


@edit.command("import-changes", example="orusd edit import-changes out --dry-run")
@click.argument("scene", type=click.Path(path_type=Path), metavar="OUT")
@click.option(
    "--from",
    "saved",
    type=click.Path(path_type=Path),
    help="What the other program saved, where it is not SCENE itself.",
)
@click.option("--dry-run", is_flag=True, help="Say what would be moved, and write nothing.")
def import_changes(scene: Path, saved: Path | None, dry_run: bool) -> None:
    """Move what another program saved over scene.usda into layers/edits.usda.

    scene.usda is then as compose writes it. Of a file that was flattened, what differs is moved.
    """
    from openrooms_usd.edits.adopting import adopt as move
    from openrooms_usd.usd.files.diagnostics import quiet

    with quiet(), progress_bar("comparing"):
        inside = scene / names.SCENE
        file = inside if os.path.lexists(inside) else scene
        adoption = move(file, saved, dry_run=dry_run)
    print_result(adoption.as_dict())
    _print(adoption, dry_run)


def _print(adoption: "Adoption", dry_run: bool) -> None:
    for change in adoption.changes[: most(_ROWS)]:
        said = listed(change.fields, most(_NAMES))
        echo(f"{'new' if change.new else 'changed':<8} {change.path}: {said}")
    if len(adoption.changes) > most(_ROWS):
        echo(f"{len(adoption.changes) - _ROWS} more; --verbose lists all")
    for sentence in adoption.left[: most(_ROWS)]:
        echo(f"note: {sentence}")
    if adoption.compared:
        echo(f"compared {adoption.compared} values of a flattened file")
    count = f"{len(adoption.changes)} prims"
    if adoption.written:
        echo(f"moved what is said about {count} to {adoption.edits}")
    elif dry_run and adoption.changes:
        echo(f"would move what is said about {count} to {adoption.edits}")
    else:
        echo("no changes to import")


@edit.command("fix-units", example="orusd edit fix-units out --dry-run")
@_OUT
@click.option("--dry-run", is_flag=True, help="Say what would be corrected, and write nothing.")
def fix_units(out: Path, dry_run: bool) -> None:
    """Correct the units and axes of files that OUT/layers/edits.usda refers to.

    A file in centimetres or with Y up gets the scale and the turn that it lacks, as operations of
    the prim that refers to it.
    """
    from openrooms_usd.edits.fitting import fit as correct
    from openrooms_usd.usd.files.diagnostics import quiet

    with quiet(), progress_bar("reading"):
        fitting = correct(out, dry_run=dry_run)
    print_result(fitting.as_dict())
    for misfit in (*fitting.fitted, *fitting.left):
        echo(str(misfit))
    if fitting.left:
        echo("remedy: give files without units metersPerUnit and upAxis; they are left as they are")
    done = "would correct" if dry_run else "corrected"
    count = len(fitting.fitted)
    echo(f"{done} {count} in {fitting.edits}" if count else "nothing to correct")


@edit.command(example="orusd edit orphans out")
@_OUT
def orphans(out: Path) -> None:
    """List the opinions of OUT/layers/edits.usda that do nothing."""
    from openrooms_usd.edits.orphans import orphans_of
    from openrooms_usd.usd.files.diagnostics import quiet

    with quiet():
        found = orphans_of(out)
    print_result({"orphans": [{**asdict(row), "remedy": row.remedy} for row in found]})
    for row in found:
        answer(f"{row}\n  remedy: {row.remedy}")
    count = len(found)
    echo(f"{out / names.LAYERS / names.EDITS}.usda: {count or 'no'} orphans")
