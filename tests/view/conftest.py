"""Pages in a browser: opened, and asked what they show."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.arrays import Array
from openrooms_usd.view.app import App
from openrooms_usd.view.server import serving
from tests.chromium import Page, opened

Shown = Callable[[App], Page]

# The page's room, and the width and height of its pictures.
ROOM = "document.getElementById('view').room"
PICTURE = (160, 120)


@pytest.fixture(scope="module")
def shown() -> Iterator[Shown]:
    """Serves a page and opens it in a browser, until the tests of a file have ended."""
    with ExitStack() as stack:

        def show(app: App) -> Page:
            server = stack.enter_context(serving(app))
            page = stack.enter_context(opened(server.address, webgl=True, size=(900, 600)))
            page.wait("document.body.dataset.ready == 'yes'")
            return page

        yield show


def drawn(page: Page, folder: Path) -> Path:
    """A picture of the page as it is, when all that was asked for is drawn."""
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    page.screenshot(folder / "page.png")
    return folder / "page.png"


def lit_picture(page: Page, output: int = 1) -> Array:
    """(H, W, 3) light in nits, or base colour, as the page shows it."""
    width, height = PICTURE
    values = page.evaluate(f"Array.from({ROOM}.radiance({width}, {height}, {output}))")
    return np.array(values).reshape(height, width, 4)[..., :3]


def turn(page: Page, light: str, on: bool) -> None:
    """Switch a light."""
    if page.evaluate(f"document.getElementById('on-{light}').checked") != on:
        page.click_on(f"#on-{light}")


def slide(page: Page, name: str, value: float) -> None:
    """Drag a slider to a value."""
    page.evaluate(f"import('orusd/panel.js').then(panel => panel.slide('{name}', {value}))")
