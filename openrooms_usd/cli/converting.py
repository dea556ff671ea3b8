"""The command ``convert``."""

from pathlib import Path

import click

from openrooms_usd.cli.console import json_option, print_json


@click.command()
@click.argument("stage", type=click.Path(path_type=Path))
@click.argument("out", type=click.Path(path_type=Path))
@click.option("--to", default="mitsuba", show_default=True, metavar="KIND", help="The exporter.")
@json_option
def convert(stage: Path, out: Path, to: str, as_json: bool) -> None:
    """Write a USD stage in a foreign form to OUT, a file or a folder.

    What could not be translated whole is listed with the reason; nothing is lost in silence.
    """
    from openrooms_usd.convert import convert_stage
    from openrooms_usd.usd.diagnostics import quiet

    with quiet():
        report = convert_stage(stage, out, to=to)
    if as_json:
        print_json({"stage": str(stage), "out": str(out), "to": to, **report.as_dict()})
        return
    for prim, outcome, reason in report.losses():
        click.echo(f"{outcome:<12} {prim}: {reason}")
    counts = (f"{report.count(kind)} {kind}" for kind in ("translated", "approximated", "skipped"))
    click.echo(f"wrote {out}: {', '.join(counts)}")
