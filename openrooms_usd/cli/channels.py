"""The command ``channels``."""

import click

from openrooms_usd.cli.console import echo, json_option, print_json


@click.command()
@click.option("--markdown", is_flag=True, help="Print the page docs/reference/channels.md.")
@json_option
def channels(markdown: bool, as_json: bool) -> None:
    """Print the table of ground-truth channels: what every number in a render means."""
    from openrooms_usd.channels import CHANNELS, markdown_page

    if as_json:
        print_json([channel.as_dict() for channel in CHANNELS.values()])
    elif markdown:
        echo(markdown_page(), nl=False)
    else:
        _print_table()


def _print_table() -> None:
    from rich import box
    from rich.console import Console
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
    Console().print(table)
