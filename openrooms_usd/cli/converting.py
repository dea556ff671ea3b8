"""The command ``convert``."""

from collections.abc import Iterable
from pathlib import Path
from typing import Final

import click

from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Command
from openrooms_usd.cli.console import echo, gathered, named, print_result
from openrooms_usd.cli.reports import check_report, report_option, write_report

_FLAGS: Final = {"true": True, "false": False}


@click.command(
    cls=Command, example="orusd convert out/scene.usda -o room.glb", former={"--to": "--format"}
)
@click.argument("stage", type=click.Path(path_type=Path), metavar="STAGE")
@click.argument("place", type=click.Path(path_type=Path), metavar="[OUT]", required=False)
@click.option("-o", "--out", type=click.Path(path_type=Path), help="A file or a folder.")
@click.option(
    "--format", "to", metavar="KIND", help="The exporter; by default what OUT's ending says."
)
@click.option(
    "--option",
    "options",
    multiple=True,
    metavar="NAME=VALUE",
    help="An option of the exporter. Repeatable.",
)
@click.option("--profile", metavar="NAME", help="Of a USDZ file: default, exchange or arkit.")
@click.option(
    "--time-code",
    type=float,
    metavar="T",
    help="The moment to write of a stage that moves; by default the first sample of everything.",
)
@click.option("--include-outside", is_flag=True, help="Copy pictures outside STAGE's folder too.")
@report_option
def convert(
    stage: Path,
    place: Path | None,
    out: Path | None,
    to: str | None,
    options: tuple[str, ...],
    profile: str | None,
    include_outside: bool,
    time_code: float | None,
    report_file: Path | None,
) -> None:
    """Write a USD stage in a foreign form.

    OUT is a file or a folder, given by -o or as the second argument.
    KIND is mitsuba, gltf, usdz, urdf, mjcf, usdphysics, openrooms-xml, or what another installed
    exporter is called; without it .glb is gltf, .usdz usdz, .xml and folders mitsuba. --profile is
    short for --option profile=NAME. What could not be translated whole is listed with the reason;
    nothing is lost in silence.
    """
    from openrooms_usd.exporters import convert_stage, exporter_of
    from openrooms_usd.usd.files.diagnostics import quiet

    given = [path for path in (out, place) if path]
    if len(given) != 1:
        raise click.UsageError("give one file or folder to write: -o OUT")
    (out,) = given
    check_report(report_file, stage, out)
    to = to or exporter_of(out)
    asked = _parse_options(options) | ({"profile": profile} if profile else {})
    with quiet(), progress_bar("opening") as progress:
        report = convert_stage(
            stage,
            out,
            to=to,
            options=asked,
            include_outside=include_outside,
            time_code=time_code,
            progress=progress,
        )
    write_report(report_file, report)
    print_result({"stage": str(stage), "out": str(out), "to": to, **report.as_dict()})
    for (outcome, reason), prims in gathered(
        ((outcome, reason), prim) for prim, outcome, reason in report.losses()
    ):
        echo(f"{outcome:<12} {named(prims)}: {reason}")
    counts = (f"{report.count(kind)} {kind}" for kind in ("translated", "approximated", "skipped"))
    echo(f"wrote {out}: {', '.join(counts)}")


def _parse_options(options: Iterable[str]) -> dict[str, str | bool]:
    """The options by name; true and false are flags."""
    given: dict[str, str | bool] = {}
    for option in options:
        name, equals, value = option.partition("=")
        if not (name and equals and value):
            raise click.UsageError(f"--option {option}: say NAME=VALUE, as in friction=dynamic")
        given[name] = _FLAGS.get(value, value)
    return given
