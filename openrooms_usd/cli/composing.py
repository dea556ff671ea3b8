"""The commands ``compose`` and ``demo``."""

import time
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from openrooms_usd import names
from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Command, folder_option, note_former
from openrooms_usd.cli.console import (
    Choice,
    command_line,
    echo,
    echo_notes,
    most,
    print_result,
    told_aside,
)

if TYPE_CHECKING:
    from openrooms_usd.composing import ComposeSummary


_SECTIONS: Final = tuple(map(names.section_of, names.STEPS))


class _StepChoice(Choice):
    """The steps by the sections that they read, also by their former names."""

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Take a former name for the present one, with a note."""
        section = names.section_of(value)
        if ctx and section != value:
            note_former(ctx, value, section)
        return super().convert(section, param, ctx)


@click.command(cls=Command, example="orusd compose my_room/room.yaml -o out")
@click.argument("description", type=click.Path(path_type=Path), metavar="ROOM.yaml")
@folder_option
@click.option("--only", type=_StepChoice(_SECTIONS), help="Run this step alone.")
@click.option("--flatten", is_flag=True, help="Also write scene.usdc, one layer.")
@click.option("--usdz", is_flag=True, help="Also write scene.usdz, one file.")
@click.option(
    "--include-outside", is_flag=True, help="Let files outside OUT go into scene.usdc, scene.usdz."
)
@click.option("--workers", type=click.IntRange(1, 256), help="Threads; all cores by default.")
def compose(
    description: Path,
    out: Path,
    only: str | None,
    flatten: bool,
    usdz: bool,
    include_outside: bool,
    workers: int | None,
) -> None:
    """Run the steps of a room and stack their layers into OUT/scene.usda.

    Steps whose inputs have not changed are skipped. OUT/layers/edits.usda is yours: it is the
    strongest layer and is never written again.
    """
    from openrooms_usd.composing import compose_room
    from openrooms_usd.usd.files.diagnostics import quiet

    started = time.perf_counter()
    with quiet(), progress_bar("reading") as progress:
        summary = compose_room(
            description,
            out,
            only=only,
            flatten=flatten,
            usdz=usdz,
            include_outside=include_outside,
            workers=workers,
            progress=progress,
        )
    print_result(summary.as_dict())
    for row in summary.stages:
        echo(f"{names.section_of(row.stage):<10} {row.state:<10} {row.seconds:6.2f} s")
        echo_notes(row.notes, indent=" " * 11)
    echo_notes(summary.notes)
    for orphan in summary.orphans[: most(_SHOWN)]:
        echo(f"edits: {orphan}")
    if len(summary.orphans) > most(_SHOWN):
        echo(f"edits: {len(summary.orphans) - _SHOWN} more; orusd edit orphans {out}")
    seconds = time.perf_counter() - started
    echo(f"{_outcome(summary)}: {summary.scene} ({seconds:.2f} s)")
    for path in summary.files:
        echo(f"wrote {path}")


# Orphans beyond these are counted.
_SHOWN: Final = 5

# A pixel of the example: its pictures are clean once they are denoised.
_DEMO_SAMPLES: Final = 16


def _outcome(summary: "ComposeSummary") -> str:
    if not summary.unchanged:
        return "composed"
    if summary.files:
        return "the layers are up to date"
    return "nothing to do, everything is up to date"


@click.command(cls=Command, example="orusd demo")
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    default=Path("out/demo"),
    show_default=True,
    help="Output folder.",
)
@click.option(
    "--spp",
    type=click.IntRange(1, 65536),
    default=_DEMO_SAMPLES,
    show_default=True,
    help="Samples a pixel.",
)
@click.pass_context
def demo(ctx: click.Context, out: Path, spp: int) -> None:
    """Compose and render the bundled example, and say what to do next.

    Where the denoiser is installed, the pictures stand beside denoised ones.
    """
    from openrooms_usd.cli.rendering import render
    from openrooms_usd.demo import copy_example
    from openrooms_usd.rendering.denoise import is_usable

    room, clean = copy_example(out / "source"), is_usable()
    with told_aside():
        ctx.invoke(compose, description=room, out=out, usdz=True)
        ctx.invoke(
            render, stage=out / names.SCENE, out=out / "render", samples=spp, denoise=clean or None
        )
    paths = {"description": room, "scene": out / names.SCENE, "render": out / "render"}
    print_result({name: str(path) for name, path in paths.items()})
    told = {"out": out, "typed": command_line(out), "picture": "denoised" if clean else "radiance"}
    echo(_DEMO_TOLD.format(**told))
    if not clean:
        echo("for clean pictures: pip install openrooms-usd[denoise], and run it again")


_DEMO_TOLD: Final = """
made, in {out}:
  render/contact_sheet.png   two views at a glance: light, geometry, materials, labels
  render/sitting/            the pictures of one, {picture}.png first; the numbers are in EXR files
  scene.usda                 the room, for any USD program; scene.usdz is the same in one file
  source/room.yaml           what it was made from

next:
  change it      edit {out}/source/room.yaml, then
                 orusd compose {typed}/source/room.yaml -o {typed}
  another room   orusd generate --type bedroom --seed 1 -o out/bedroom
                 orusd compose out/bedroom/room.yaml -o out/bedroom
  from a scan    orusd import scan SCAN.ply -o out/scanned
  more light     orusd render {typed}/scene.usda -o {typed}/render --spp 256 --denoise"""
