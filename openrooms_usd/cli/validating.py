"""The command ``validate``."""

import sys
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Command
from openrooms_usd.cli.console import (
    answer,
    asked,
    echo,
    gathered,
    most,
    named,
    print_result,
    print_table,
    warn,
)
from openrooms_usd.errors import printable

if TYPE_CHECKING:
    from openrooms_usd.validation.licences import Licence
    from openrooms_usd.validation.model import Finding

# More rows than this of one rule say no more.
_ROWS = 20


@click.command(cls=Command, example="orusd validate out/scene.usda --strict")
@click.argument("stage", type=click.Path(path_type=Path))
@click.option("--strict", is_flag=True, help="Count warnings as errors.")
def validate(stage: Path, strict: bool) -> None:
    """Check any USD stage against USD's rules and ours; exit with 1 when it has errors.

    Our own rules are warnings for stages that other tools wrote. The licences of all assets and
    textures are listed too; a licence that is not stated is unknown.
    """
    from openrooms_usd.rules import check
    from openrooms_usd.usd.files.diagnostics import quiet
    from openrooms_usd.usd.files.layers import open_stage
    from openrooms_usd.validation.licences import licences

    with quiet(), progress_bar("opening") as progress:
        opened = open_stage(stage)
        findings, terms = check(opened, strict=strict, progress=progress), licences(opened)
    failed = any(finding.severity == "error" for finding in findings)
    print_result(
        {
            "stage": str(stage),
            "valid": not failed,
            "findings": [asdict(finding) for finding in findings],
            "licences": [asdict(licence) for licence in terms],
        }
    )
    _print_findings(stage, findings)
    if not asked().json:
        _print_licences(terms)
    if failed:
        sys.exit(1)


def _print_findings(stage: Path, findings: "list[Finding]") -> None:
    from rich.table import Table
    from rich.text import Text

    if not findings:
        echo(f"{stage}: clean")
        return
    errors = sum(finding.severity == "error" for finding in findings)
    warnings = len(findings) - errors
    answer(
        f"{stage}: {errors} error{'s' * (errors != 1)}, {warnings} warning{'s' * (warnings != 1)}"
    )
    table = Table("", "rule", "where", "what")
    for column in table.columns:
        column.overflow = "fold"
    shown: Counter[str] = Counter()
    said = gathered(((f.severity, f.code, f.message), f.place) for f in findings)
    for (severity, code, message), places in said:
        shown[code] += 1
        if shown[code] <= most(_ROWS):
            # Which of USD's plugins it comes from, before the colon, tells a person nothing.
            cells = (severity, code.rpartition(":")[2], named(places), message)
            table.add_row(*map(Text, map(printable, cells)))
    print_table(table)
    for code, count in shown.items():
        if count > most(_ROWS):
            answer(f"{code}: {count - _ROWS} more; --json lists all")
    for code, remedy in sorted({(f.code, f.remedy) for f in findings if f.remedy}):
        answer(f"{code}: {remedy}")


def _print_licences(terms: "list[Licence]") -> None:
    from rich.table import Table
    from rich.text import Text

    if not terms:
        return
    table = Table("licence", "of", "name", "prims")
    for column in table.columns:
        column.overflow = "fold"
    shown: Counter[tuple[str, str]] = Counter()
    for term in terms:
        group = (term.licence, term.kind)
        shown[group] += 1
        if shown[group] <= most(_ROWS):
            cells = (term.licence, term.kind, term.name, str(term.prims))
            table.add_row(*map(Text, map(printable, cells)))
    if not asked().quiet:
        print_table(table)
    for (licence, kind), count in shown.items():
        if count > most(_ROWS):
            echo(f"{licence}: {count - _ROWS} more {kind}s; --json lists all")
    unknown = sum(term.is_unknown for term in terms)
    if unknown:
        warn(
            f"{unknown} assets and textures do not say under which licence they may be "
            "used: state it in their assetInfo, or in a file NAME.license beside them"
        )
