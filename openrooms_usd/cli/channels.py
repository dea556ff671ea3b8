"""The command ``channels``."""

import click

from openrooms_usd.cli.command import Command
from openrooms_usd.cli.console import answer, print_result, print_table


@click.command(cls=Command, example="orusd channels")
@click.option("--markdown", is_flag=True, help="Print the page docs/reference/channels.md.")
def channels(markdown: bool) -> None:
    """Print the table of ground-truth channels: what every number in a render means."""
    from openrooms_usd.channels import CHANNELS, markdown_page

    print_result([channel.as_dict() for channel in CHANNELS.values()])
    if markdown:
        answer(markdown_page(), nl=False)
    else:
        _print_table()


def _print_table() -> None:
    from rich import box
    from rich.table import Table

    from openrooms_usd.channels import CHANNELS

    table = Table(box=box.SIMPLE)
    table.add_column("channel", no_wrap=True)
    for title in ("parts", "unit, frame", "meaning"):
        table.add_column(title)
    for row in CHANNELS.values():
        parts = f"{' '.join(row.components)} {row.storage}"
        unit = ", ".join(filter(None, (row.unit, row.frame)))
        table.add_row(row.name, parts, unit, row.meaning)
    print_table(table)
