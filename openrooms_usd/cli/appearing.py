"""The command ``appearance``."""

from pathlib import Path
from typing import Any

import click

from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Command, section
from openrooms_usd.cli.console import asked, echo, print_result


@click.command(
    cls=Command, example="orusd appearance out/scene.usda --photographs frames.json -o looks.usda"
)
@click.argument("stage", type=click.Path(path_type=Path), metavar="STAGE")
@click.option(
    "--photographs",
    type=click.Path(path_type=Path),
    required=True,
    metavar="PATH",
    help="Posed photographs: a list of frames, transforms.json, a COLMAP model or an RGB-D folder.",
)
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    required=True,
    metavar="LAYER.usda",
    help="The layer to write; a folder of its name receives its pictures and report.json.",
)
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of all draws.")
@section(
    "Photographs",
    click.option("--form", metavar="NAME", help="The form of the photographs, if several fit."),
    click.option("--scale", type=float, help="Metres for one unit of the cameras' world."),
    click.option("--up", metavar="AXIS", help="Vertical of their world: z, -y, 0,1,0.2, cameras."),
    click.option(
        "--hold-out",
        type=click.IntRange(2),
        metavar="N",
        help="Leave every N-th photograph for measuring.",
    ),
    click.option(
        "--register/--no-register",
        default=True,
        show_default=True,
        help="Check poses against the geometry, and correct them.",
    ),
)
def appearance(
    stage: Path,
    photographs: Path,
    out: Path,
    seed: int,
    form: str | None,
    scale: float | None,
    up: str | None,
    hold_out: int | None,
    register: bool,
) -> None:
    """Find base colours, gloss, lamps and surroundings of a USD stage from photographs of it.

    The geometry must be that of the photographs: exact meshes or a scan. LAYER.usda receives
    opinions alone. Put it above the stage as its strongest sublayer.
    """
    from openrooms_usd.appearance.driver import PhotographOptions, write_appearance
    from openrooms_usd.usd.files.diagnostics import quiet

    options = PhotographOptions(form, scale, up, hold_out or 0, register)
    with quiet(), progress_bar("translating") as progress:
        found = write_appearance(stage, photographs, out, options, seed=seed, progress=progress)
    print_result(found)
    if not asked().json:
        _print(found, out)


def _print(found: dict[str, Any], layer: Path) -> None:
    if found["registration"]:
        echo(found["registration"]["sentence"])
    for lamp in found["lamps"]:
        echo(f"{lamp['path']}: {_numbers(lamp['radiance'])} nits")
    parts, frames = found["parts"], found["photographs"]
    sure = sum(max(part["base_color_sd"]) < 0.05 for part in parts)
    echo(f"{len(parts)} parts from {len(frames)} photographs, {sure} of them within 0.05")
    for note in found["notes"]:
        echo(f"note: {note}")
    echo(f"wrote {layer}, and {layer.with_suffix('') / 'report.json'}")


def _numbers(values: list[float]) -> str:
    return ", ".join(f"{value:.3g}" for value in values)
