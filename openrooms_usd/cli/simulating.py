"""The command ``simulate``."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Command
from openrooms_usd.cli.console import Choice, asked, echo, most, print_result, warn

if TYPE_CHECKING:
    from openrooms_usd.engines import Friction
    from openrooms_usd.simulation.settling import Settled

# Shown: those that have moved by more than this, and never more lines than that.
_SHOWN_FROM_MM, _SHOWN_FROM_DEG = 1.0, 0.2
_SHOWN = 12
# What was placed and moves farther was placed badly.
_WARNED_FROM_MM = 10.0


@click.command(
    cls=Command,
    example="orusd simulate out/scene.usda --duration 0.5",
    former={"--seconds": "--duration"},
)
@click.argument("stage", type=click.Path(path_type=Path), metavar="STAGE")
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    metavar="LAYER",
    help="The layer to write; of a composed room by default layers/settled.usda.",
)
@click.option("--engine", default="mujoco", show_default=True, help="mujoco or pybullet.")
@click.option(
    "--duration", "seconds", type=float, default=2.0, show_default=True, help="Simulated seconds."
)
@click.option(
    "--timestep", type=float, default=0.002, show_default=True, help="Seconds of one step."
)
@click.option(
    "--friction",
    type=Choice(["static", "dynamic"]),
    default="static",
    show_default=True,
    help="Which coefficient of each surface counts.",
)
@click.option("--look", metavar="NAME", help="Of every object that has it, for its friction.")
def simulate(
    stage: Path,
    out: Path | None,
    engine: str,
    seconds: float,
    timestep: float,
    friction: "Friction",
    look: str | None,
) -> None:
    """Let a room settle, and write where everything came to rest as a layer.

    The layer lies above the steps and below the edits. Every run starts from the room as it is
    described; delete the layer and compose again to go back to that.
    """
    from openrooms_usd.simulation.settling import settle
    from openrooms_usd.usd.files.diagnostics import quiet

    with quiet(), progress_bar("reading") as progress:
        settled = settle(
            stage,
            engine=engine,
            seconds=seconds,
            out=out,
            timestep=timestep,
            friction=friction,
            look=look,
            progress=progress,
        )
    print_result({"stage": str(stage), **settled.as_dict()})
    if not asked().json:
        _print(settled)


def _print(settled: "Settled") -> None:
    farthest = [
        row
        for row in settled.moved
        if row.millimetres >= _SHOWN_FROM_MM or row.degrees >= _SHOWN_FROM_DEG
    ]
    for row in farthest[: most(_SHOWN)]:
        echo(f"{row.body:<24} {row.millimetres:8.1f} mm {row.degrees:7.2f} deg")
    if len(farthest) > most(_SHOWN):
        echo(f"and {len(farthest) - _SHOWN} others")
    for path in settled.held:
        echo(f"{path} stays where a stronger layer has it", err=True)
    loose = [row.body for row in settled.moved if row.millimetres > _WARNED_FROM_MM]
    if loose:
        shown = ", ".join(loose[: most(_SHOWN)]) + (", ..." if len(loose) > most(_SHOWN) else "")
        warn(f"these moved by more than {_WARNED_FROM_MM / 10.0:g} cm: {shown}")
    farthest_mm = max((row.millimetres for row in settled.moved), default=0.0)
    turn = max((row.degrees for row in settled.moved), default=0.0)
    many = f"{len(settled.moved)} movable object{'s' * (len(settled.moved) != 1)}"
    echo(
        f"{many}; the largest motion in {settled.seconds:g} s was "
        f"{farthest_mm:.1f} mm, the largest turn {turn:.1f} degrees ({settled.engine})"
    )
    echo(f"wrote {settled.out}")
