"""The HTML around a page, and the files of all pages."""

import base64
import html
import json
from collections.abc import Mapping
from importlib import resources
from typing import Any, Final

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
{body}
<script type="module"{nonce}>
import {{ start }} from "orusd/{page}.js";
await start(document.getElementById("page"));
document.body.dataset.ready = "yes";
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
