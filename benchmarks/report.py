"""What the benchmarks share: a table for people, JSON for programs, and the machine."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from openrooms_usd.rendering.manifest import machine_entry, write_json

RESULTS = Path(__file__).parent / "results"


def table(titles: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A Markdown table; numbers get three significant digits, and what is missing a dash."""
    lines = [titles, ["---"] * len(titles), *([cell(value) for value in row] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def cell(value: object) -> str:
    """One cell of a table."""
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"
    return f"{value:,}" if isinstance(value, int) else str(value)


def publish(name: str, data: dict[str, Any], markdown: str, target: Path | None) -> None:
    """Print the table and write the numbers, with the machine that they were taken on."""
    machine = machine_entry("")
    del machine["backend"]
    path = target or RESULTS / f"{name}.json"
    write_json(path, {"benchmark": name, "machine": machine, **data})
    click.echo(f"{machine['cpu']}, {machine['cores']} cores\n\n{markdown}\n")
    click.echo(f"wrote {path}", err=True)
