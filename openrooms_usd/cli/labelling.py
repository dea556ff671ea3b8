"""The command ``labels``: files of what renders show."""

from pathlib import Path
from typing import Literal

import click

from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Command
from openrooms_usd.cli.console import Choice, echo, print_result


@click.command(
    cls=Command,
    example="orusd labels renders -o coco.json --taxonomy coco",
    former={"--classes": "--taxonomy"},
)
@click.argument(
    "renders", type=click.Path(path_type=Path), nargs=-1, required=True, metavar="RENDER..."
)
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    required=True,
    metavar="FILE.json",
    help="The file to write.",
)
@click.option(
    "--format",
    "form",
    type=Choice(["coco", "boxes"]),
    default="coco",
    show_default=True,
    help="What to write; boxes are of one RENDER.",
)
@click.option(
    "--taxonomy",
    "taxonomy",
    type=Choice(["category", "openrooms45", "nyu40", "ade20k", "coco"]),
    default="category",
    show_default=True,
    help="Whose classes, for coco.",
)
@click.option("--stage", type=click.Path(path_type=Path), help="What was rendered, for boxes.")
def labels(
    renders: tuple[Path, ...],
    out: Path,
    form: Literal["coco", "boxes"],
    taxonomy: str,
    stage: Path | None,
) -> None:
    """Write what is seen in finished RENDERs: COCO masks and boxes, or boxes in 2D and 3D.

    Many renders make one COCO file; boxes are of one. A render needs the channel instance, and
    semantic, semantic_nyu40, semantic_ade20k or semantic_coco for those classes.
    """
    from openrooms_usd.rendering.labelling import write_labels

    with progress_bar("reading") as progress:
        summary = write_labels(
            renders, out, form=form, taxonomy=taxonomy, stage=stage, progress=progress
        )
    print_result(summary.as_dict())
    echo(f"wrote {out}: {summary.objects} objects in {summary.views} views")
