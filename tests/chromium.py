"""A headless Chromium that opens pages, driven by Playwright."""

import json
import os
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

import pytest

_EXECUTABLE: Final = os.environ.get("ORUSD_CHROMIUM") or shutil.which("chromium")
# WebGL 2 in software costs a process of its own: pages without it go without.
_FLAT: Final = ("--disable-gpu",)
_WEBGL: Final = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")

needs_chromium = pytest.mark.skipif(
    _EXECUTABLE is None or find_spec("playwright") is None,
    reason="Chromium or Playwright is not installed",
)


class Page:
    """An open page.

    Attributes:
        page: Playwright's.
        messages: What its console said, and its errors.
        requests: The addresses of all that it asked for.
    """

    def __init__(self, page: Any) -> None:
        self.page = page
        self.messages: list[str] = []
        self.requests: list[str] = []
        page.on("console", lambda message: self.messages.append(message.text))
        page.on("pageerror", lambda error: self.messages.append(str(error)))
        page.on("request", lambda request: self.requests.append(request.url))

    def evaluate(self, expression: str) -> Any:
        """The value of an expression in the page; a promise is awaited."""
        return self.page.evaluate(expression)

    def wait(self, expression: str, seconds: float = 30.0) -> Any:
        """The value of an expression as soon as it is true of the page."""
        end = time.monotonic() + seconds
        while not (value := self.evaluate(expression)):
            assert time.monotonic() < end, (f"never true: {expression}", self.messages)
            self.page.wait_for_timeout(50)
        return value

    def click(self, x: float, y: float) -> None:
        """Click at a place of the window."""
        self.page.mouse.click(x, y)

    def click_on(self, selector: str) -> None:
        """Click into the middle of what a CSS selector finds first."""
        self.click(*self.middle(selector))

    def middle(self, selector: str) -> tuple[float, float]:
        """Where the middle of an element is in the window; scrolled there where need be."""
        found = self.evaluate(
            f"(() => {{const e = document.querySelector({json.dumps(selector)});"
            " if (!e) return null;"
            " e.scrollIntoView({block: 'nearest', inline: 'nearest'});"
            " const b = e.getBoundingClientRect();"
            " return [b.x + b.width / 2, b.y + b.height / 2]})()"
        )
        assert found is not None, f"the page has no {selector}"
        return float(found[0]), float(found[1])

    def drag(self, start: tuple[float, float], end: tuple[float, float], steps: int = 4) -> None:
        """Press at one place, go to another in so many steps, and let go."""
        self.page.mouse.move(*start)
        self.page.mouse.down()
        self.page.mouse.move(*end, steps=steps)
        self.page.mouse.up()

    def wheel(self, x: float, y: float, delta: float) -> None:
        """Turn the wheel of the mouse; towards the person is more than nought."""
        self.page.mouse.move(x, y)
        self.page.mouse.wheel(0, delta)

    def key(self, keys: str) -> None:
        """Press a key and let it go: a letter, the name of a key, or ``Control+z``."""
        self.page.keyboard.press(keys)

    def write(self, text: str) -> None:
        """Write into the field that has the focus."""
        self.page.keyboard.insert_text(text)

    def resize(self, width: int, height: int) -> None:
        """Make the window so large."""
        self.page.set_viewport_size({"width": width, "height": height})

    def screenshot(self, path: Path, clip: dict[str, float] | None = None) -> None:
        """Write what is seen, or a part of the page, as a PNG."""
        self.page.screenshot(path=path, clip=clip, full_page=clip is not None)

    def darken(self) -> None:
        """Prefer dark colours."""
        self.page.emulate_media(color_scheme="dark")


_open: Final[list[Any]] = []


@contextmanager
def opened(
    page: Path | str, *, webgl: bool = False, size: tuple[int, int] = (800, 600)
) -> Iterator[Page]:
    """Open a page.

    Args:
        page: The HTML file, or an address.
        webgl: Whether it needs WebGL 2, which is drawn in software.
        size: Width and height of the window.
    """
    address = page.resolve().as_uri() if isinstance(page, Path) else page
    with _playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=_EXECUTABLE, args=_WEBGL if webgl else _FLAT
        )
        window = browser.new_page(viewport={"width": size[0], "height": size[1]})
        window.set_default_timeout(120_000)
        found = Page(window)
        window.goto(address)
        try:
            yield found
        finally:
            browser.close()


@contextmanager
def _playwright() -> Iterator[Any]:
    """The driver, of which a thread may have one: it ends with the last page that uses it."""
    from playwright.sync_api import sync_playwright

    driver = _open[-1] if _open else sync_playwright().start()
    _open.append(driver)
    try:
        yield driver
    finally:
        _open.pop()
        if not _open:
            driver.stop()
