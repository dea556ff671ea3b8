"""The command ``annotate``."""

from pathlib import Path
from typing import Any

import click

from openrooms_usd.cli.console import echo, json_option, print_json


@click.command()
@click.argument("render", type=click.Path(path_type=Path), metavar="RENDER")
@click.option("-o", "--out", type=click.Path(path_type=Path), required=True, help="A JSON file.")
@click.option("--format", "form", type=click.Choice(["coco", "boxes"]), default="coco",
              show_default=True)  # fmt: skip
@click.option("--taxonomy", type=click.Choice(["category", "openrooms45", "nyu40"]),
              default="category", show_default=True, help="Whose classes, for coco.")  # fmt: skip
@click.option("--stage", type=click.Path(path_type=Path), help="What was rendered, for boxes.")
@json_option
def annotate(
    render: Path, out: Path, form: str, taxonomy: str, stage: Path | None, as_json: bool
) -> None:
    """Write what is seen in a finished RENDER: COCO masks and boxes, or boxes in 2D and 3D.

    The render needs the channel instance, and semantic or semantic_nyu40 for those classes.
    """
    from openrooms_usd.render.coco import coco
    from openrooms_usd.render.manifest import write_json

    if form == "coco":
        found = coco(render, taxonomy)
        views, count = len(found["images"]), len(found["annotations"])
    else:
        found = _boxes(render, stage)
        views, count = len(found["views"]), sum(len(v["objects"]) for v in found["views"].values())
    write_json(out, found)
    if as_json:
        print_json({"file": str(out), "views": views, "objects": count})
    else:
        echo(f"wrote {out}: {count} objects in {views} views")


def _boxes(render: Path, stage: Path | None) -> dict[str, Any]:
    from openrooms_usd.render.boxes import boxes
    from openrooms_usd.usd.diagnostics import quiet
    from openrooms_usd.usd.layers import open_stage

    if stage is None:
        raise click.UsageError("boxes in 3D are the stage's: say --stage scene.usda")
    with quiet():
        return boxes(render, open_stage(stage))
