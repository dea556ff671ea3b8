"""What commands that open a page in the browser share."""

from pathlib import Path
from typing import Final

import click

from openrooms_usd.cli.command import section
from openrooms_usd.cli.console import answer, echo, print_result
from openrooms_usd.view.app import App

page_options: Final = section(
    "Page",
    click.option(
        "--export",
        type=click.Path(path_type=Path),
        metavar="PAGE.html",
        help="Write the page as one file to look at, without a server, and end.",
    ),
    click.option(
        "--host", default="127.0.0.1", show_default=True, help="The address to listen on."
    ),
    click.option(
        "--port", type=click.IntRange(0, 65535), default=0, help="By default any that is free."
    ),
    click.option("--no-open", is_flag=True, help="Do not open the browser."),
)
"""The options of a page: where it is served, and whether it is one file instead."""


def show(app: App, *, export: Path | None, host: str, port: int, no_open: bool) -> None:
    """Write a page as one file, or serve it until Ctrl-C.

    Raises:
        OutputError: The file cannot be written, or the port is taken.
    """
    from openrooms_usd.view import shell
    from openrooms_usd.view.server import serving

    if export is not None:
        shell.write(app, export)
        print_result({"file": str(export)})
        echo(f"wrote {export}")
        return
    import threading
    import webbrowser

    with serving(app, host=host, port=port) as server:
        print_result({"title": app.title, "address": server.address})
        answer(f"{app.title}: {server.address}")
        echo("Ctrl-C ends it")
        if not no_open:
            webbrowser.open(server.address)
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            echo("ended")
