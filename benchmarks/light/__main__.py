"""Light: how soon it is right.

pictures: radiance by every method, raw and denoised: seconds, noise and bias, in rooms plain,
furnished and hard.
grids: hemispheres on a grid: the estimator of the OpenRooms paper, light sampling and hemisphere
sampling combined by the power heuristic, beside the other methods.
channels: every channel of light: the estimated error, the true one and the bias; of channels that
there are for each light, the mean over them.
view: all files of a view by the command line.
fits: the spherical Gaussians of hemispheres: seconds of a full grid, and the root of the squared
error over that of the light, its mean, median, and mean over the worst tenth.
hard: rooms that are hard to light.
honesty: how often the true error of a picture is more than twice the one that the render states,
over all rooms, channels and lights; of those that the reference can tell.

At the end: what shall be reached, and what is; of the method that is no reference, where there is
one.

Seconds are those of all cores together; of one view those that its room takes before are part, of
20 views a twentieth of these. Rays alone: the closest hits of the same rays, cast in the same run.
Relative MSE is the mean over pixels of (x - ref)^2 / (ref^2 + 0.01 M^2) for each colour, M the mean
of the reference in that colour, and the mean of the three. The robust error is the same with every
pixel's part capped at 1. Bias is that of the mean luminance, and of the worst tenth of the pixels,
each with its standard error.
"""

import tempfile
import time
from pathlib import Path
from typing import Final

import click

from benchmarks.light.grids import fits, grids
from benchmarks.light.honesty import channels, hard, honesty
from benchmarks.light.pictures import Measure, Section, Setting, pictures
from benchmarks.light.sessions import References, listed
from benchmarks.light.view import view
from benchmarks.report import publish

SECTIONS: Final[dict[str, Measure]] = {
    "pictures": pictures,
    "grids": grids,
    "channels": channels,
    "view": view,
    "fits": fits,
    "hard": hard,
    "honesty": honesty,
}


@click.command(help=__doc__)
@click.option("--section", "chosen", multiple=True, help="Repeatable; all by default.")
@click.option("--quick", is_flag=True, help="Small pictures, few samples, few rooms.")
@click.option("--room", "rooms", multiple=True, help="Repeatable; all of a section by default.")
@click.option(
    "--references",
    type=click.Path(path_type=Path),
    help="A folder where references are kept; without it they are made every time.",
)
@click.option(
    "--results",
    type=click.Path(path_type=Path),
    help="A folder where sections are kept as they are finished, and not measured again.",
)
@click.option("--minutes", type=float, help="After so many no further section is begun.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(
    chosen: tuple[str, ...],
    quick: bool,
    rooms: tuple[str, ...],
    references: Path | None,
    results: Path | None,
    minutes: float | None,
    target: Path | None,
) -> None:
    sections: dict[str, Section] = {}
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        kept = References(references or Path(folder) / "references")
        setting = Setting(quick, Path(folder), kept, rooms)
        for name in chosen or SECTIONS:
            file = (results or Path(folder) / "results") / f"{name}.json"
            passed = time.monotonic() - began
            found = Section.kept(file)
            if found is None and minutes is not None and passed > 60.0 * minutes:
                click.echo(f"{name}: not measured, time is up", err=True)
                continue
            sections[name] = found or SECTIONS[name](setting)
            sections[name].keep(file)
            click.echo(f"{name}: {time.monotonic() - began - passed:.0f} s", err=True)
    text = "\n\n".join(f"## {name}\n\n{section.markdown}" for name, section in sections.items())
    targets = [target for section in sections.values() for target in section.targets]
    if targets:
        text += f"\n\n## targets\n\n{listed(targets)}"
    publish("light", {name: section.data for name, section in sections.items()}, text, target)


if __name__ == "__main__":
    main()
