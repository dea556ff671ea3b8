"""The commands of ``orusd materials``: the families of materials, as a list and as pictures."""

import time
from pathlib import Path
from typing import get_args

import click

from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Group
from openrooms_usd.cli.console import Choice, answer, echo, print_result
from openrooms_usd.cli.settings import renderer_options
from openrooms_usd.description.substances import Substance

_SUBSTANCES = Choice(get_args(Substance))


@click.group(cls=Group)
def materials() -> None:
    """The procedural materials: a list, or pictures of them."""


@materials.command("list", example="orusd materials list")
def list_() -> None:
    """Print every family by substance, with its usual size and where it is used."""
    from openrooms_usd.library.textures import FAMILIES

    print_result(
        {
            kind: {
                name: {
                    "size": family.size,
                    "uses": sorted(family.uses),
                    "grain": family.grain,
                    "metallic": family.metallic,
                }
                for name, family in families.items()
            }
            for kind, families in FAMILIES.items()
        }
    )
    for kind, families in FAMILIES.items():
        answer(f"{kind} ({len(families)})")
        for name, family in families.items():
            answer(f"  {name:<26} {family.size:>5g} m  {', '.join(sorted(family.uses))}")


@materials.command(example="orusd materials sheet -o woods --substance wood")
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    required=True,
    metavar="DIR",
    help="Folder for the pictures, one a substance.",
)
@click.option(
    "--substance",
    "substances",
    multiple=True,
    type=_SUBSTANCES,
    help="What to draw; all by default. Repeatable.",
)
@click.option(
    "--number",
    type=click.IntRange(0),
    default=0,
    show_default=True,
    help="Which material of each family.",
)
@click.option(
    "--size",
    type=click.IntRange(16, 2048),
    default=160,
    show_default=True,
    help="Pixels along each side of a picture.",
)
@click.option(
    "--spp", type=click.IntRange(1, 65536), default=64, show_default=True, help="Samples a pixel."
)
@click.option("--denoise", is_flag=True, help="Denoise the pictures (extra denoise).")
@renderer_options
def sheet(
    out: Path,
    substances: tuple[Substance, ...],
    number: int,
    size: int,
    spp: int,
    denoise: bool,
    renderer: str,
    options: dict[str, str],
) -> None:
    """Draw every family on a lit ball and on a floor."""
    from openrooms_usd.showroom import draw_material_sheets
    from openrooms_usd.usd.files.diagnostics import quiet

    started = time.perf_counter()
    with quiet(), progress_bar("composing") as progress:
        files = draw_material_sheets(
            out,
            substances,
            number=number,
            size=size,
            samples=spp,
            renderer=renderer,
            options=options,
            denoise=denoise,
            progress=progress,
        )
    print_result({"files": [str(file) for file in files]})
    echo(f"wrote {len(files)} pictures to {out} ({time.perf_counter() - started:.1f} s)")
