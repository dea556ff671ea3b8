"""Pages in a browser: opened, and asked what they show."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from openrooms_usd.view.app import App
from openrooms_usd.view.server import serving
from tests.chromium import Page, opened

Shown = Callable[[App], Page]


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Shown]:
    """Serves a page and opens it in a browser, until the tests of a file have ended."""
    with ExitStack() as stack:

        def show(app: App) -> Page:
            server = stack.enter_context(serving(app))
            scratch = tmp_path_factory.mktemp("chromium")
            page = stack.enter_context(opened(server.address, scratch, webgl=True, size=(900, 600)))
            page.wait("document.body.dataset.ready == 'yes'")
            return page

        yield show


def drawn(page: Page, folder: Path) -> Path:
    """A picture of the page as it is, when all that was asked for is drawn."""
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    page.screenshot(folder / "page.png")
    return folder / "page.png"
