"""The commands ``relight`` and ``probe``."""

import math
from pathlib import Path

import click

from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Command, folder_option
from openrooms_usd.cli.console import echo, print_result
from openrooms_usd.cli.settings import settings_options
from openrooms_usd.description.rendering import RenderSettings

Position = tuple[float, float, float]

_WORDS = {"off": 0.0, "on": 1.0}


def _pairs(ctx: click.Context, param: click.Parameter, values: tuple[str, ...]) -> dict[str, float]:
    """Numbers by name, from ``lamp_2=0.5``; the last of a name counts."""
    found: dict[str, float] = {}
    for text in values:
        name, equals, value = text.partition("=")
        try:
            number = _WORDS.get(value.strip().lower())
            found[name.strip()] = float(value) if number is None else number
        except ValueError:
            equals = ""
        if not equals or not name.strip() or math.isnan(found[name.strip()]):
            raise click.BadParameter(f"{text!r} is not like lamp_2=0.5 or lamp_2=off", ctx, param)
    return found


def _positions(
    ctx: click.Context, param: click.Parameter, values: tuple[str, ...]
) -> tuple[Position, ...]:
    """Positions from ``x,y,z``."""
    found: list[Position] = []
    for text in values:
        try:
            x, y, z = (float(part) for part in text.split(","))
        except ValueError:
            raise click.BadParameter(f"{text!r} is not like 1.0,2.5,1.2", ctx, param) from None
        found.append((x, y, z))
    return tuple(found)


@click.command(
    cls=Command, example="orusd relight renders/overview -o evening --light window_0=off"
)
@click.argument("view", type=click.Path(path_type=Path), metavar="VIEW")
@folder_option
@click.option(
    "--light",
    "scales",
    multiple=True,
    callback=_pairs,
    metavar="NAME=FACTOR",
    help="What a light is multiplied by: a number, off or on. Repeatable.",
)
@click.option(
    "--temperature",
    "kelvin",
    multiple=True,
    callback=_pairs,
    metavar="NAME=KELVIN",
    help="A lamp's new colour temperature. Repeatable.",
)
def relight(view: Path, out: Path, scales: dict[str, float], kelvin: dict[str, float]) -> None:
    """Turn the lights of a rendered VIEW, without rendering again.

    VIEW is the folder of a view that was rendered with --channels radiance_i. OUT receives
    radiance.exr, radiance.png and manifest.json.
    """
    from openrooms_usd.rendering.relight import Relighting
    from openrooms_usd.rendering.relight import relight as turn

    manifest = turn(view, out, Relighting(scales, kelvin))
    print_result(manifest)
    for light in manifest["lights"]:
        factor = " ".join(f"{value:.3g}" for value in light["factor"])
        echo(f"{light['name']:<16} x {factor}")
    echo(f"wrote {out / 'radiance.exr'} and radiance.png")


@click.command(cls=Command, example="orusd probe out/scene.usda -o probes --at 1.0,2.0,1.5")
@click.argument("stage", type=click.Path(path_type=Path), metavar="STAGE")
@folder_option
@click.option(
    "--at",
    multiple=True,
    callback=_positions,
    metavar="X,Y,Z",
    help="A position, world, metres. Repeatable.",
)
@click.option("--openings", is_flag=True, help="Also in the centre of every opening.")
@settings_options(
    "resolution",
    "samples",
    "seed",
    "bounces",
    "default_light",
    "texture_side",
    "time_code",
    defaults={"resolution": (256, 128)},
    helps={"resolution": "Of the panoramas.", "samples": "Paths for each pixel; 64 by default."},
)
def probe(
    stage: Path, out: Path, at: tuple[Position, ...], openings: bool, settings: RenderSettings
) -> None:
    """Make light probes in a USD stage, for real-time engines.

    OUT receives probes.json (spherical harmonics of radiance and irradiance) and for every probe a
    latitude-longitude EXR.
    """
    from openrooms_usd.rendering.probes import probe_stage
    from openrooms_usd.usd.files.diagnostics import quiet

    with quiet(), progress_bar("translating") as progress:
        found = probe_stage(stage, out, settings, at=at, at_openings=openings, progress=progress)
    print_result(found)
    for entry in found["probes"]:
        error = entry["estimated_robust_error"]
        measured = "" if error is None else f"  estimated error {error:.2g}"
        echo(f"{entry['name']:<16}{measured}")
    echo(f"wrote {out / 'probes.json'} and {len(found['probes'])} panoramas")
