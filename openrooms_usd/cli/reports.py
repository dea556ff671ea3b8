"""The option ``--report``: what became of every prim of a stage, as a file."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from openrooms_usd import atomic, claims
from openrooms_usd.errors import OutputError

if TYPE_CHECKING:
    from openrooms_usd.exporters import Report

report_option: Final = click.option(
    "--report",
    "report_file",
    type=click.Path(path_type=Path),
    metavar="FILE.json",
    help="Write what became of every prim there.",
)


def check_report(file: Path | None, stage: Path, out: Path) -> None:
    """Refuse a report before anything slow begins.

    Args:
        file: Where it shall be; None: there will be none.
        stage: The USD file that is read.
        out: The file or folder that is written.

    Raises:
        OutputError: It cannot be written there, or it would take the place of something else.
    """
    from openrooms_usd.rendering.folder import check_writable

    if file is None:
        return
    place = file.resolve()
    if place == stage.resolve():
        raise _refused(file, "the report would take the place of the stage")
    if out.resolve() in (place, *place.parents):
        raise _refused(file, "the report would be part of the output")
    claims.check_output(file)
    check_writable(file.parent)


def write_report(file: Path | None, report: "Report") -> None:
    """Write a report as JSON; the file appears whole or not at all.

    Raises:
        OutputError: It cannot be written.
    """
    if file is None:
        return
    with claims.output(file):
        atomic.write_text(file, json.dumps(report.whole(), indent=2) + "\n")


def _refused(file: Path, why: str) -> OutputError:
    return OutputError(why, place=file, remedy="give --report a file of its own beside it")
