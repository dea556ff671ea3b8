"""A page as one file that works without a server: everything that it can ask for lies inside."""

import base64
import zlib
from pathlib import Path
from typing import Final

from openrooms_usd import atomic
from openrooms_usd.view.app import App
from openrooms_usd.view.shell import STYLE, data_url, embedded, modules, wrapped

# Nothing is asked of anybody else, whatever a stage says.
_POLICY: Final = (
    "default-src 'none'; script-src 'unsafe-inline' data: blob:; style-src 'unsafe-inline'; "
    "img-src data: blob:; media-src data: blob:; connect-src data: blob:"
)


def page(app: App) -> str:
    """One HTML file with all that a page shows; nothing can be done in it but look.

    The same stage gives the same bytes.

    Args:
        app: The page.
    """
    files = modules()
    style = files.pop(STYLE).decode()
    places = {
        name: data_url("text/javascript", content)
        for name, content in files.items()
        if name.endswith(".js")
    }
    head = (
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n<style>{style}</style>'
    )
    inside = [f'<script type="application/json" id="state">{embedded(app.state())}</script>']
    inside += [
        f'<script type="text/plain" data-resource="{name}">'
        f"{base64.b64encode(zlib.compress(make())).decode('ascii')}</script>"
        for name, make in sorted(app.resources.items())
    ]
    return wrapped(app.page, app.title, places, head=head, body="\n".join(inside))


def write(app: App, out: Path) -> None:
    """Write a page as one file.

    Raises:
        OutputError: It cannot be written.
    """
    atomic.write_bytes(out, page(app).encode())
