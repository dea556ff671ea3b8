"""The command ``dataset``."""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from openrooms_usd.cli.console import echo, json_option, print_json, progress_bar

if TYPE_CHECKING:
    from openrooms_usd.render.datasets import DatasetSummary


@click.command()
@click.argument("renders", type=click.Path(path_type=Path), nargs=-1, required=True,
                metavar="RENDER...")  # fmt: skip
@click.option("-o", "--out", type=click.Path(path_type=Path), required=True,
              help="The dataset's folder.")  # fmt: skip
@click.option("--as", "kind", default="openrooms", show_default=True, metavar="KIND",
              help="Whose dataset: openrooms, nerf, or another that is installed.")  # fmt: skip
@click.option("--scene", default="scene0000_00", show_default=True, help="The scene's name in it.")
@click.option("--split", "splits", multiple=True, default=("main_xml",), show_default=True,
              help="What a render is, once for each: main_xml, mainDiffMat_xml, "
              "mainDiffLight_xml, or these with xml1.")  # fmt: skip
@click.option(
    "--subset", type=click.Choice(["train", "val", "test"]), default="train", show_default=True
)
@click.option("--layout", type=click.Choice(["split", "merged"]), default="split",
              show_default=True, help="A tree for each channel, or one folder.")  # fmt: skip
@click.option("--imenv-order", "order", type=click.Choice(["legacy", "rgb"]), default="legacy",
              show_default=True, help="Channels of environment maps: as the released loaders take "
              "them, or red first.")  # fmt: skip
@click.option("--crowded", type=click.Choice(["leave-out", "drop", "keep"]), default="leave-out",
              show_default=True, help="Views with more than 3 windows or 7 lamps, which released "
              "loaders cannot hold: leave them out, drop the least lights, or keep.")  # fmt: skip
@click.option("--first", type=int, default=1, show_default=True, help="The first view's number.")
@json_option
def dataset(
    renders: tuple[Path, ...],
    out: Path,
    kind: str,
    scene: str,
    splits: tuple[str, ...],
    subset: Literal["train", "val", "test"],
    layout: Literal["split", "merged"],
    order: Literal["legacy", "rgb"],
    crowded: Literal["leave-out", "drop", "keep"],
    first: int,
    as_json: bool,
) -> None:
    """Write finished RENDERs as the files of a published dataset.

    Several renders are the variants of one scene: the same views with other materials or lights.
    """
    from openrooms_usd.render.datasets import DatasetOptions, write_dataset

    options = DatasetOptions(scene, splits, subset, layout, order, first, crowded)
    with progress_bar(hidden=as_json, first="reading") as progress:
        summary = write_dataset(renders, out, kind=kind, options=options, progress=progress)
    if as_json:
        print_json(summary.as_dict())
    else:
        print_dataset(summary)


def print_dataset(summary: "DatasetSummary") -> None:
    """Say what a dataset has received."""
    for name, reason in sorted(summary.missing.items()):
        echo(f"no {name}: {reason}")
    for note in summary.notes:
        echo(f"note: {note}")
    views = sum(map(len, summary.frames.values()))
    echo(f"wrote {summary.root}: {summary.files} files of {views} views")
