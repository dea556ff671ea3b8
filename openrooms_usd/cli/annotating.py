"""The commands ``labels`` and ``annotate``: files and pages of what rooms and renders show."""

from pathlib import Path
from typing import Any, Final, Literal

import click

from openrooms_usd.cli.console import Choice, Group, echo, json_option, print_json
from openrooms_usd.cli.pages import page_options, show

# What ``labels`` needs, and no page has.
_OUT: Final = ("-o", "--out")

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


class _Commands(Group):
    """Goes on understanding ``annotate RENDER... -o FILE``, which is called ``labels`` now."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command."""
        if args[0] in self.commands or not any(word.startswith(_OUT) for word in args):
            return super().resolve_command(ctx, args)

        echo(
            "hint: this is `orusd labels` now; `orusd annotate` opens rooms in the browser",
            err=True,
        )
        return "labels", labels, args


@click.group(cls=_Commands, context_settings={"ignore_unknown_options": True})
def annotate() -> None:
    """Correct a room in the browser."""


@annotate.command(context_settings={"ignore_unknown_options": False})
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
    help="What reads the SCAN: a kind of `orusd import`.",
)
@page_options
def layout(source: Path, out: Path | None, importer: str, **where: Any) -> None:
    """Correct the walls, doors, windows and height of a room over the points of its scan."""
    from openrooms_usd.view.plan.session import Session, room_file

    show(Session(room_file(source, out, importer)).app(), **where)


@annotate.command()
@_ROOM
@_DESCRIPTION
@_COMPOSED
@page_options
def materials(room: Path, description: Path | None, out: Path | None, **where: Any) -> None:
    """Say what the parts of a room are made of: in the edits of STAGE, or in room.yaml."""
    from openrooms_usd.view.corrections import corrections
    from openrooms_usd.view.materials import materials_app

    show(materials_app(corrections(room, description, out)), **where)


@annotate.command()
@_ROOM
@_DESCRIPTION
@_COMPOSED
@page_options
def objects(room: Path, description: Path | None, out: Path | None, **where: Any) -> None:
    """Move, rename, exchange, copy and remove furniture: in the edits of STAGE, or in room.yaml."""
    from openrooms_usd.view.corrections import corrections
    from openrooms_usd.view.objects import objects_app

    show(objects_app(corrections(room, description, out)), **where)


@click.command()
@click.argument(
    "renders", type=click.Path(path_type=Path), nargs=-1, required=True, metavar="RENDER..."
)
@click.option("-o", "--out", type=click.Path(path_type=Path), required=True, help="A JSON file.")
@click.option("--format", "form", type=Choice(["coco", "boxes"]), default="coco", show_default=True)
@click.option(
    "--classes",
    "--taxonomy",
    "taxonomy",
    type=Choice(["category", "openrooms45", "nyu40", "ade20k", "coco"]),
    default="category",
    show_default=True,
    help="Whose classes, for coco.",
)
@click.option("--stage", type=click.Path(path_type=Path), help="What was rendered, for boxes.")
@json_option
def labels(
    renders: tuple[Path, ...],
    out: Path,
    form: Literal["coco", "boxes"],
    taxonomy: str,
    stage: Path | None,
    as_json: bool,
) -> None:
    """Write what is seen in finished RENDERs: COCO masks and boxes, or boxes in 2D and 3D.

    Many renders make one COCO file; boxes are of one. A render needs the channel instance, and
    semantic, semantic_nyu40, semantic_ade20k or semantic_coco for those classes.
    """
    from openrooms_usd.rendering.labelling import write_labels

    summary = write_labels(renders, out, form=form, taxonomy=taxonomy, stage=stage)
    if as_json:
        print_json(summary.as_dict())
    else:
        echo(f"wrote {out}: {summary.objects} objects in {summary.views} views")
