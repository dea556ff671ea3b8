"""The command ``compare``."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Command, folder_option
from openrooms_usd.cli.console import asked, echo, print_result, warn
from openrooms_usd.cli.settings import settings_options
from openrooms_usd.description.rendering import RenderSettings

if TYPE_CHECKING:
    from openrooms_usd.comparison.driver import ComparedFrame, Comparison


@click.command(
    cls=Command,
    example="orusd compare captured/out/scene.usda -o comparison --count 4",
    former={"--room": "--description"},
)
@click.argument("stage", type=click.Path(path_type=Path), metavar="STAGE")
@folder_option
@click.option(
    "--description",
    type=click.Path(path_type=Path),
    metavar="ROOM.yaml",
    help="What the stage was composed from; by default beside its folder.",
)
@click.option(
    "--photographs",
    "pictures",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Where the pictures lie; by default where the capture does.",
)
@click.option(
    "--frame",
    "frames",
    multiple=True,
    metavar="ID",
    help="A photograph to compare with. Repeatable.",
)
@click.option(
    "--count",
    type=int,
    default=8,
    show_default=True,
    help="Photographs to compare with, evenly spread.",
)
@click.option(
    "--width", type=int, default=480, show_default=True, help="Width of pictures, pixels."
)
@settings_options(
    "samples",
    "seed",
    "bounces",
    "method",
    "default_light",
    "texture_side",
    "time_code",
    defaults={"samples": 32, "method": "reference"},
    helps={"samples": "Samples a pixel.", "method": "How light is computed, as by render."},
)
def compare(
    stage: Path,
    out: Path,
    description: Path | None,
    pictures: Path | None,
    frames: tuple[str, ...],
    count: int,
    width: int,
    settings: RenderSettings,
) -> None:
    """Render a room from the cameras of its photographs, and put all side by side.

    OUT receives comparison.json, contact_sheet.png and, in frames/, for each photograph: the
    photograph, the render, the render's edges over the photograph, and the difference of depth
    from the scan.
    """
    from openrooms_usd.comparison.driver import compare_stage
    from openrooms_usd.usd.files.diagnostics import quiet

    with quiet(), progress_bar("translating") as progress:
        found = compare_stage(
            stage,
            out,
            settings,
            description=description,
            pictures=pictures,
            frames=frames,
            count=count,
            width=width,
            progress=progress,
        )
    print_result(found.as_dict())
    if not asked().json:
        _print(found)


def _print(found: "Comparison") -> None:
    for frame in found.frames:
        echo(f"{frame.id:<16} {_likeness(frame)}  {_edges(frame)}  {_depth(frame)}")
    if found.missing:
        count, first = len(found.missing), found.missing[0]
        said = f"{count} photographs were not found, such as {first}: name their folder by"
        warn(f"{said} --photographs DIR")
    echo(f"wrote {found.out / 'contact_sheet.png'} and comparison.json")


def _likeness(frame: "ComparedFrame") -> str:
    alike = frame.likeness
    return "" if alike is None else f"{alike.psnr:.1f} dB, SSIM {alike.ssim:.2f}"


def _edges(frame: "ComparedFrame") -> str:
    if frame.edges is None:
        return "no photograph"
    return f"edges met {frame.edges.share:.0%} (by chance {frame.edges.chance:.0%})"


def _depth(frame: "ComparedFrame") -> str:
    if frame.depth is None:
        return "nothing scanned"
    error = frame.depth
    return f"depth off by {100 * error.median:.1f} cm, {error.right:.0%} within 10 cm"
