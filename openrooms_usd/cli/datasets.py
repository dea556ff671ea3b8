"""The commands of ``dataset``: make one, look at it, and write renders as others store them."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

import click

from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Group
from openrooms_usd.cli.console import (
    Choice,
    answer,
    asked,
    command_line,
    echo,
    echo_notes,
    most,
    print_result,
)
from openrooms_usd.cli.settings import pairs_of

if TYPE_CHECKING:
    from openrooms_usd.dataset.scratch import Root
    from openrooms_usd.rendering.datasets import DatasetSummary

# A person mends these first; the rest is in --verbose.
_MOST_SHOWN: Final = 20

_FILE: Final = click.argument("file", type=click.Path(path_type=Path), metavar="DATASET.yaml")


def _root(text: str) -> "Root":
    """A folder, or a URL."""
    from openrooms_usd.dataset.scratch import root_of

    return root_of(text)


_FOLDER: Final = click.argument("folder", type=_root, metavar="DIR")


class _Commands(Group):
    """Points from the path of a render to ``dataset write``."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command."""
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError as error:
            said = f"{error.message} `orusd dataset write` is for finished renders."
            raise click.UsageError(said, ctx) from None


@click.group(cls=_Commands)
def dataset() -> None:
    """Make datasets: many rooms by one file, or finished renders as others store them."""


@dataset.command(example="orusd dataset plan dataset.yaml -o plan.jsonl")
@_FILE
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    help="Write the plan there; to standard output by default.",
)
def plan(file: Path, out: Path | None) -> None:
    """Print what a dataset.yaml stands for: a line of JSON for each view of each room."""
    from openrooms_usd import claims
    from openrooms_usd.dataset.plan import lines, plan_jobs
    from openrooms_usd.dataset.store import write_lines
    from openrooms_usd.description import load_dataset

    if out is not None:
        claims.check_output(out)
    rows = lines(plan_jobs(load_dataset(file)))
    if out is not None:
        with claims.output(out):
            count = write_lines(out, rows)
        print_result({"file": str(out), "views": count})
        echo(f"wrote {out}: {count} views")
    elif asked().json:
        print_result({"views": [json.loads(row) for row in rows]})
    else:
        for row in rows:
            answer(row)


@dataset.command(example="orusd dataset run dataset.yaml -o data --workers 2")
@_FILE
@click.option(
    "-o",
    "--out",
    type=_root,
    required=True,
    metavar="DIR|URL",
    help="The dataset's folder, or a URL such as s3://bucket/name.",
)
@click.option(
    "--workers",
    type=click.IntRange(1, 1024),
    default=1,
    show_default=True,
    help="How many rooms are worked on at once.",
)
@click.option(
    "--executor",
    default="local",
    show_default=True,
    metavar="NAME",
    help="Who works: local, ray, or another that is installed.",
)
@click.option(
    "--address",
    metavar="HOST:PORT",
    help="The cluster of an executor. Short for --option address=…",
)
@click.option(
    "--option",
    "pairs",
    multiple=True,
    callback=pairs_of,
    metavar="NAME=VALUE",
    help="An option of the executor. Repeatable.",
)
def run(
    file: Path,
    out: "Root",
    workers: int,
    executor: str,
    address: str | None,
    pairs: tuple[tuple[str, str], ...],
) -> None:
    """Make a dataset, or finish one: what exists is kept.

    Leaves with code 1 when views could not be made; they are tried again by the next run.
    """
    from openrooms_usd.dataset.run import run_dataset

    options = ({} if address is None else {"address": address}) | dict(pairs)
    with progress_bar("planning") as progress:
        done = run_dataset(
            file, out, workers=workers, executor=executor, options=options, progress=progress
        )
    print_result(done.as_dict())
    echo_notes(done.notes)
    for unit, reason in list(done.failed.items())[: most(_MOST_SHOWN)]:
        answer(f"failed: {unit}: {reason}")
    echo(f"wrote {out}: {done.made} views, {done.kept} were there, {len(done.failed)} failed")
    if done.failed:
        echo(f"next:  {command_line('orusd', 'dataset', 'status', out)}")
    sys.exit(1 if done.failed else 0)


@dataset.command(example="orusd dataset status data")
@_FOLDER
def status(folder: "Root") -> None:
    """Say how far a dataset is: what is finished, what has failed and why."""
    from openrooms_usd.dataset.status import status_of

    with progress_bar("reading"):
        found = status_of(folder)
    print_result(found.as_dict())
    failed = len(found.failures)
    answer(
        f"{found.finished} of {found.units} views are finished, {failed} failed, {found.left} left"
    )
    for fault, count in found.faults.items():
        answer(f"{count} views: {fault}")
    for room, reason in list(found.left_out.items())[: most(_MOST_SHOWN)]:
        answer(f"left out: {room}: {reason}")
    for row in found.rejected[: most(_MOST_SHOWN)]:
        answer(f"replaced: {row['camera']} of {row['unit']}: {', '.join(row['faults'])}")
    for failure in found.failures[: most(_MOST_SHOWN)]:
        answer(f"failed: {failure.unit} ({failure.attempts} times): {failure.reason}")
    if failed > most(_MOST_SHOWN):
        answer(f"and {failed - _MOST_SHOWN} more: --verbose lists them")


@dataset.command(example="orusd dataset verify data")
@_FOLDER
def verify(folder: "Root") -> None:
    """Compare every file of a dataset with its checksum.

    Leaves with code 1 when a file is missing or changed.
    """
    from openrooms_usd.dataset.status import verify as compare

    with progress_bar("reading") as progress:
        found = compare(folder, progress)
    print_result(found.as_dict())
    for damage in found.damages:
        answer(f"{damage.file}: {damage.what}")
    echo(f"{found.files} files of {found.views} views, {len(found.damages)} damaged")
    if found.unfinished:
        echo(f"{found.unfinished} views are not finished")
    sys.exit(1 if found.damages else 0)


@dataset.command(example="orusd dataset stats data")
@_FOLDER
def stats(folder: "Root") -> None:
    """Count what a dataset holds: rooms, objects, pixels, materials, lights, seconds, errors."""
    from openrooms_usd.dataset.stats import stats_of

    with progress_bar("reading"):
        found = stats_of(folder).as_dict()
    print_result(found)
    for title, rows in found.items():
        if not isinstance(rows, dict):
            answer(f"{title}: {_number(rows)}")
            continue
        answer(f"{title}:")
        for name, value in list(rows.items())[: most(_MOST_SHOWN)]:
            answer(f"  {name:<24} {_number(value):>14}")
        if len(rows) > most(_MOST_SHOWN):
            answer(f"  and {len(rows) - _MOST_SHOWN} more: --verbose lists them")


@dataset.command(example="orusd dataset report data -o report.html")
@_FOLDER
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    metavar="PAGE.html",
    help="The page; by default report.html beside the data, or here.",
)
@click.option(
    "--pictures",
    type=click.IntRange(1, 1000),
    default=72,
    show_default=True,
    help="How many views it shows at most.",
)
@click.option(
    "--price",
    type=click.FloatRange(0.0),
    metavar="MONEY",
    help="What an hour of a core costs: the page says what 1,000 views do.",
)
def report(folder: "Root", out: Path | None, pictures: int, price: float | None) -> None:
    """Write a page for browsers: views, what they show, errors, cost, failures, licences.

    It is one file that loads nothing else.
    """
    from openrooms_usd.dataset.report.page import write_report

    page = out or (folder if isinstance(folder, Path) else Path()) / "report.html"
    with progress_bar("reading"):
        done = write_report(folder, page, pictures=pictures, price=price)
    print_result(done.as_dict())
    echo(f"wrote {done.path}: {done.views} views, {done.pictures} shown, {done.bytes / 1e6:.2f} MB")


def _number(value: float) -> str:
    return f"{value:,.4g}" if isinstance(value, float) else f"{value:,}"


@dataset.command(
    example="orusd dataset write renders -o data --format nerf",
    former={"--as": "--format", "--layout": "--dataset-layout"},
)
@click.argument(
    "renders", type=click.Path(path_type=Path), nargs=-1, required=True, metavar="RENDER..."
)
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), required=True, help="The dataset's folder."
)
@click.option(
    "--format",
    "kind",
    default="openrooms",
    show_default=True,
    metavar="KIND",
    help="Whose: openrooms, nerf, webdataset, hypersim, coco, parquet, or another that "
    "is installed.",
)
@click.option("--scene", default="scene0000_00", show_default=True, help="The scene's name in it.")
@click.option(
    "--split",
    "splits",
    multiple=True,
    default=("main_xml",),
    show_default=True,
    help="What a render is, once for each: main_xml, mainDiffMat_xml, "
    "mainDiffLight_xml, or these with xml1.",
)
@click.option(
    "--subset",
    type=Choice(["train", "val", "test"]),
    default="train",
    show_default=True,
    help="Which part of the dataset the scene belongs to.",
)
@click.option(
    "--dataset-layout",
    "layout",
    type=Choice(["split", "merged"]),
    default="split",
    show_default=True,
    help="A tree for each channel, or one folder.",
)
@click.option(
    "--imenv-order",
    "order",
    type=Choice(["legacy", "rgb"]),
    default="legacy",
    show_default=True,
    help="Channels of environment maps: as the released loaders take them, or red first.",
)
@click.option(
    "--crowded",
    type=Choice(["leave-out", "drop", "keep"]),
    default="leave-out",
    show_default=True,
    help="Views with more than 3 windows or 7 lamps, which released "
    "loaders cannot hold: leave them out, drop the least lights, or keep.",
)
@click.option("--first", type=int, default=1, show_default=True, help="The first view's number.")
@click.option(
    "--stage",
    "stages",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="STAGE",
    help="The composed stage of each RENDER, in their order: its meshes, materials and "
    "main.xml go beside the pictures.",
)
def write(
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
    stages: tuple[Path, ...],
) -> None:
    """Write finished RENDERs as the files of a published dataset.

    Several renders are the variants of one scene: the same views with other materials or lights.
    """
    from openrooms_usd.rendering.datasets import DatasetOptions, write_dataset

    options = DatasetOptions(scene, splits, subset, layout, order, first, crowded, stages)
    with progress_bar("reading") as progress:
        summary = write_dataset(renders, out, kind=kind, options=options, progress=progress)
    print_result(summary.as_dict())
    print_dataset(summary)


def print_dataset(summary: "DatasetSummary") -> None:
    """Say what a dataset has received."""
    for name, reason in sorted(summary.missing.items()):
        echo(f"no {name}: {reason}")
    echo_notes(summary.notes)
    views = sum(map(len, summary.frames.values()))
    echo(f"wrote {summary.root}: {summary.files} files of {views} views")
