"""The HTML around a page, and the files of all pages."""

import base64
import html
import json
import zlib
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any, Final

from openrooms_usd import atomic, claims
from openrooms_usd.view.app import App

# Nothing is requested from other servers, whatever a stage says.
_POLICY: Final = (
    "default-src 'none'; script-src 'unsafe-inline' data: blob:; style-src 'unsafe-inline'; "
    "img-src data: blob:; media-src data: blob:; connect-src data: blob:"
)
FILES: Final = resources.files("openrooms_usd.view") / "page"
STYLE: Final = "page.css"
_HTML: Final = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
{head}
<title>{title}</title>
<script type="importmap"{nonce}>{modules}</script>
</head>
<body>
<main id="page"></main>
<p id="loading" class="told">loading …</p>
{body}
<script type="module"{nonce}>
const loading = document.getElementById("loading");
try {{
  const {{ start }} = await import("orusd/{page}.js");
  await start(document.getElementById("page"));
  document.body.dataset.ready = "yes";
}} catch (error) {{
  loading.textContent = [error.message, error.place, error.remedy].filter(Boolean).join("\\n");
  throw error;
}}
</script>
</body>
</html>
"""


def modules() -> dict[str, bytes]:
    """The files of all pages by their names."""
    found = (entry for entry in FILES.iterdir() if entry.name.endswith((".js", ".css")))
    return {entry.name: entry.read_bytes() for entry in sorted(found, key=lambda one: one.name)}


def wrapped(
    page: str, title: str, places: Mapping[str, str], *, head: str, body: str = "", nonce: str = ""
) -> str:
    """The HTML of a page.

    Args:
        page: Its module, without a suffix.
        title: Its title, plain text.
        places: Where each ``orusd/NAME.js`` is found.
        head: More for the head, HTML.
        body: More for the body, HTML.
        nonce: What allows its scripts, where they need that.
    """
    told = f' nonce="{nonce}"' if nonce else ""
    imports = embedded({"imports": {f"orusd/{name}": place for name, place in places.items()}})
    return _HTML.format(
        page=page, title=html.escape(title), modules=imports, head=head, body=body, nonce=told
    )


def embedded(data: Any) -> str:
    """Data as JSON that may stand inside of a script's tag."""
    text = json.dumps(data, sort_keys=True, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")


def data_url(kind: str, content: bytes) -> str:
    """Content as an address of its own."""
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"


def page(app: App) -> str:
    """One HTML file with all that a page shows; nothing can be done in it but look.

    The same stage gives the same bytes.
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
        OutputError: It cannot be written, or is there and not ours.
    """
    claims.check_output(out)
    made = page(app).encode()
    with claims.output(out):
        atomic.write_bytes(out, made)
