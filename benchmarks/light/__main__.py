"""Light: how soon it is right.

radiance: relative MSE against seconds of Mitsuba's `path` with its lights sampled evenly, `path`
with sampling weights by the flux that each light brings, and ours, in rooms plain, furnished and
hard. The last column is the error of ours over that of the better `path`, at equal time.
channels: every channel of light: seconds, the error estimated by the renderer, and the true one,
against a reference of another seed; of channels that there are for each light, the mean over them.
environment: hemispheres on a grid. Ours is the estimator of the OpenRooms paper, light sampling and
hemisphere sampling combined by the power heuristic; beside it stands hemisphere sampling alone.
growth: seconds for a million paths, with the number of lights, pixels and triangles.
hard: rooms that are hard to light: estimated error, whether all is finite, pixels replaced.

Seconds are those of all cores together. Relative MSE is the mean over pixels of (x - ref)^2 /
(ref^2 + 0.01 M^2) for each colour, M the mean of the reference in that colour, and the mean of the
three. The robust error is the same with every pixel's part capped at 1.
"""

import tempfile
from pathlib import Path
from typing import Final

import click

from benchmarks.light.channels import channels
from benchmarks.light.environment import environment
from benchmarks.light.growth import growth
from benchmarks.light.hard_rooms import hard
from benchmarks.light.radiance import radiance
from benchmarks.light.section import Measure, Setting
from benchmarks.report import publish

SECTIONS: Final[dict[str, Measure]] = {
    "radiance": radiance,
    "channels": channels,
    "environment": environment,
    "growth": growth,
    "hard": hard,
}


@click.command(help=__doc__)
@click.option("--section", "chosen", multiple=True, help="Repeatable; all by default.")
@click.option("--quick", is_flag=True, help="Small pictures, few samples, few rooms.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(chosen: tuple[str, ...], quick: bool, target: Path | None) -> None:
    with tempfile.TemporaryDirectory() as folder:
        setting = Setting(quick, Path(folder))
        sections = {name: SECTIONS[name](setting) for name in chosen or SECTIONS}
    text = "\n\n".join(f"## {name}\n\n{section.markdown}" for name, section in sections.items())
    publish("light", {name: section.data for name, section in sections.items()}, text, target)


if __name__ == "__main__":
    main()
