"""The commands of ``orusd library``: what furniture there is, as a list and as a picture."""

import time
from pathlib import Path

import click

from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Group
from openrooms_usd.cli.console import answer, echo, print_result
from openrooms_usd.cli.settings import renderer_options


@click.group(cls=Group)
def library() -> None:
    """The parametric furniture: a list, or a picture of it."""


@library.command("list", example="orusd library list")
def list_() -> None:
    """Print every category with its styles, usual size and support."""
    from openrooms_usd.furniture import CATEGORIES

    rows = {
        name: {
            "description": spec.description,
            "styles": list(spec.styles),
            "size": list(spec.size),
            "min_size": list(spec.min_size),
            "max_size": list(spec.max_size),
            "support": spec.support,
            "mount_height": spec.mount_height,
            "lumen": spec.lumen,
        }
        for name, spec in sorted(CATEGORIES.items())
    }
    print_result(rows)
    for name, spec in sorted(CATEGORIES.items()):
        width, depth, height = spec.size
        size = f"{width:g} x {depth:g} x {height:g} m"
        answer(f"{name:<16} {size:<22} {spec.support:<8} {', '.join(spec.styles)}")


@library.command(
    example="orusd library sheet -o chairs.png --category chair", former={"--width": "--max-width"}
)
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    required=True,
    metavar="FILE.png",
    help="The picture to write.",
)
@click.option(
    "--category",
    "categories",
    multiple=True,
    metavar="NAME",
    help="What to draw; all by default. Repeatable.",
)
@click.option("--all", "every_style", is_flag=True, help="Every style, not one a category.")
@click.option(
    "--seed",
    type=click.IntRange(0),
    default=0,
    show_default=True,
    help="Fixes every random number.",
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
@click.option(
    "--max-width",
    "width",
    type=click.IntRange(64, 65536),
    metavar="PIXELS",
    help="Reduce a sheet that is wider.",
)
@renderer_options
@click.option("--denoise", is_flag=True, help="Denoise the pictures (needs the extra 'denoise').")
def sheet(
    out: Path,
    categories: tuple[str, ...],
    every_style: bool,
    seed: int,
    size: int,
    spp: int,
    width: int | None,
    renderer: str,
    options: dict[str, str],
    denoise: bool,
) -> None:
    """Draw the catalogue: every object in a studio, with its name, style and size."""
    from openrooms_usd.showroom import draw_sheet, exhibits
    from openrooms_usd.usd.files.diagnostics import quiet

    started = time.perf_counter()
    shown = exhibits(categories, every_style=every_style)
    with quiet(), progress_bar("composing") as progress:
        draw_sheet(
            out,
            shown,
            seed=seed,
            size=size,
            samples=spp,
            renderer=renderer,
            options=options,
            denoise=denoise,
            widest=width,
            progress=progress,
        )
    print_result({"file": str(out), "shown": [[item.category, item.style] for item in shown]})
    echo(f"wrote {out}: {len(shown)} objects ({time.perf_counter() - started:.1f} s)")
