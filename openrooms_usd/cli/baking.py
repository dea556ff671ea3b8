"""The command ``bake``."""

from pathlib import Path

import click

from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Command, folder_option
from openrooms_usd.cli.console import echo, print_result
from openrooms_usd.cli.settings import settings_options
from openrooms_usd.description.rendering import RenderSettings


@click.command(cls=Command, example="orusd bake out/scene.usda -o lit --spp 16")
@click.argument("stage", type=click.Path(path_type=Path), metavar="STAGE")
@folder_option
@click.option(
    "--texel",
    type=float,
    default=0.05,
    show_default=True,
    metavar="METRES",
    help="Side of a texel on the surfaces.",
)
@click.option(
    "--max-texels",
    type=int,
    default=1 << 22,
    show_default=True,
    help="Of all atlases together; texels grow until there are no more.",
)
@click.option(
    "--atlas",
    "side",
    type=int,
    default=4096,
    show_default=True,
    metavar="TEXELS",
    help="Side of an atlas at most.",
)
@settings_options(
    "samples",
    "seed",
    "bounces",
    "method",
    "default_light",
    "texture_side",
    "time_code",
    defaults={"samples": 256},
    helps={"samples": "Paths for each texel."},
)
def bake(
    stage: Path, out: Path, texel: float, max_texels: int, side: int, settings: RenderSettings
) -> None:
    """Write the light of a USD stage as lightmaps, for real-time engines.

    OUT receives lightmaps.usda, a layer with a second set of texture coordinates; baked.usda, the
    stage under that layer; lightmaps.json; and for each light an irradiance texture, and their sum.
    """
    from openrooms_usd.rendering.bake.baking import AtlasLayout, bake_stage
    from openrooms_usd.usd.files.diagnostics import quiet

    layout = AtlasLayout(texel, side, max_texels)
    with quiet(), progress_bar("translating") as progress:
        found = bake_stage(stage, out, settings, layout, progress=progress)
    print_result(found)
    side_m, asked_m = found["texel"]["side_m"], found["texel"]["asked_m"]
    grown = "" if side_m == asked_m else f", not {100 * asked_m:g} cm: there would be too many"
    for number, atlas in enumerate(found["atlases"]):
        width, height = atlas["size"]
        echo(f"atlas_{number:<3} {width}x{height}, {atlas['lit_texels']:,} texels with light")
    error = found["estimated_error"]
    measured = "" if error is None else f", estimated error {error:.2g}"
    echo(f"texels of {100 * side_m:.3g} cm{grown}; {len(found['lights'])} lights{measured}")
    if found["left_out"]:
        echo(f"{len(found['left_out'])} surfaces without: lightmaps.json says why")
    echo(f"wrote {out / found['layer']}, and baked.usda, the stage under it")
