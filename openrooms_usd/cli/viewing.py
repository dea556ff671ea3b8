"""The command ``view``."""

from pathlib import Path
from typing import Any

import click

from openrooms_usd.cli.pages import page_options, show


@click.command()
@click.argument("stage", type=click.Path(path_type=Path))
@click.option("--include-outside", is_flag=True, help="Show pictures outside STAGE's folder too.")
@page_options
def view(stage: Path, include_outside: bool, **where: Any) -> None:
    """Look at STAGE in the browser."""
    from openrooms_usd.view.room import room_app

    show(room_app(stage, include_outside=include_outside), **where)
