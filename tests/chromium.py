"""A headless Chromium that opens pages, driven over its own protocol through a pipe."""

import base64
import json
import os
import select
import shlex
import shutil
import subprocess
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import pytest

_EXECUTABLE: Final = os.environ.get("ORUSD_CHROMIUM") or shutil.which("chromium")
_OPTIONS: Final = (
    "--headless", "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars",
    "--no-first-run", "--disable-background-networking", "--disable-extensions",
    "--remote-debugging-pipe",
)  # fmt: skip
# WebGL 2 in software costs a process of its own: pages without it go without.
_FLAT: Final = ("--disable-gpu",)
_WEBGL: Final = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
_PATIENCE_S: Final = 120.0
_POLL_S: Final = 0.05
# Keys that are no letters: their virtual key codes.
_KEYS: Final = {"Escape": 27, "Enter": 13, "Delete": 46, "Backspace": 8, "Tab": 9, " ": 32,
                "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40,
                "Shift": 16, "Control": 17}  # fmt: skip
_MODIFIERS: Final = {"Alt": 1, "Control": 2, "Meta": 4, "Shift": 8}
_HELD: Final = {"none": 0, "left": 1, "right": 2, "middle": 4}

needs_chromium = pytest.mark.skipif(_EXECUTABLE is None, reason="Chromium is not installed")


@dataclass
class Page:
    """An open page, and what was told of it.

    Attributes:
        messages: What went wrong, as its console says.
        requests: The addresses of all that it asked for.
    """

    _pipe: "_Pipe"
    _session: str
    messages: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def evaluate(self, expression: str) -> Any:
        """The value of an expression in the page; what a promise is settled to."""
        done = self._ask("Runtime.evaluate", expression=expression, returnByValue=True,
                         awaitPromise=True)  # fmt: skip
        assert "exceptionDetails" not in done, done
        return done["result"].get("value")

    def wait(self, expression: str, seconds: float = 30.0) -> Any:
        """The value of an expression as soon as it is true of the page."""
        end = time.monotonic() + seconds
        while not (value := self.evaluate(expression)):
            assert time.monotonic() < end, (f"never true: {expression}", self.messages)
            time.sleep(_POLL_S)
        return value

    def move(self, x: float, y: float, button: str = "none", held: Sequence[str] = ()) -> None:
        """Move the mouse, with a button down where one is named."""
        self._mouse("mouseMoved", x, y, button, held)

    def press(self, x: float, y: float, button: str = "left", held: Sequence[str] = ()) -> None:
        """Press a button of the mouse at a place of the window."""
        self.move(x, y, held=held)
        self._mouse("mousePressed", x, y, button, held, clickCount=1)

    def release(self, x: float, y: float, button: str = "left", held: Sequence[str] = ()) -> None:
        """Let a button of the mouse go."""
        self._mouse("mouseReleased", x, y, button, held, clickCount=1)

    def click(self, x: float, y: float, button: str = "left", held: Sequence[str] = ()) -> None:
        """Click at a place of the window, with keys held that are named ("Shift", ...)."""
        self.press(x, y, button, held)
        self.release(x, y, button, held)

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

    def drag(self, start: tuple[float, float], end: tuple[float, float], button: str = "left",
             held: Sequence[str] = (), steps: int = 4) -> None:  # fmt: skip
        """Press at one place, go to another in so many steps, and let go."""
        self.press(*start, button, held)
        for step in range(1, steps + 1):
            share = step / steps
            x, y = (a + (b - a) * share for a, b in zip(start, end, strict=True))
            self.move(x, y, button, held)
        self.release(*end, button, held)

    def wheel(self, x: float, y: float, delta: float) -> None:
        """Turn the wheel of the mouse; towards the person is more than nought."""
        self._mouse("mouseWheel", x, y, "none", (), deltaX=0, deltaY=delta)

    def key(self, key: str, held: Sequence[str] = ()) -> None:
        """Press a key and let it go: a letter, or the name of a key."""
        self.key_down(key, held)
        self.key_up(key, held)

    def key_down(self, key: str, held: Sequence[str] = ()) -> None:
        """Press a key."""
        text = {"text": "\r" if key == "Enter" else key} if len(key) == 1 or key == "Enter" else {}
        self._key("keyDown" if text and not set(held) - {"Shift"} else "rawKeyDown", key, held,
                  **(text if not set(held) - {"Shift"} else {}))  # fmt: skip

    def key_up(self, key: str, held: Sequence[str] = ()) -> None:
        """Let a key go."""
        self._key("keyUp", key, held)

    def write(self, text: str) -> None:
        """Write into the field that has the focus."""
        self._ask("Input.insertText", text=text)

    def _mouse(
        self, kind: str, x: float, y: float, button: str, held: Sequence[str], **more: Any
    ) -> None:
        down = _HELD[button] if kind != "mouseReleased" else 0
        self._ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, buttons=down,
                  modifiers=_modifiers(held), **more)  # fmt: skip

    def _key(self, kind: str, key: str, held: Sequence[str], **more: Any) -> None:
        code = _KEYS.get(key, ord(key[0].upper()))
        self._ask("Input.dispatchKeyEvent", type=kind, key=key, windowsVirtualKeyCode=code,
                  code=f"Key{key.upper()}" if len(key) == 1 and key.isalpha() else key,
                  modifiers=_modifiers(held), **more)  # fmt: skip

    def resize(self, width: int, height: int) -> None:
        """Make the window so large."""
        self._ask("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=False)  # fmt: skip

    def screenshot(self, path: Path, clip: dict[str, float] | None = None) -> None:
        """Write what is seen, or a part of the page, as a PNG."""
        part = {"clip": {**clip, "scale": 1}, "captureBeyondViewport": True} if clip else {}
        done = self._ask("Page.captureScreenshot", format="png", **part)
        path.write_bytes(base64.b64decode(done["data"]))

    def darken(self) -> None:
        """Prefer dark colours."""
        features = [{"name": "prefers-color-scheme", "value": "dark"}]
        self._ask("Emulation.setEmulatedMedia", features=features)

    def _load(self, address: str) -> None:
        for domain in ("Page", "Network", "Runtime", "Log"):
            self._ask(f"{domain}.enable")
        self._ask("Page.navigate", url=address)
        while self._note(self._pipe.read()) != "Page.loadEventFired":
            pass

    def _ask(self, method: str, **params: Any) -> Any:
        number = self._pipe.write(method, params, self._session)
        while (told := self._pipe.read()).get("id") != number:
            self._note(told)
        assert "error" not in told, told
        return told["result"]

    def _note(self, told: dict[str, Any]) -> str:
        method, params = told.get("method", ""), told.get("params", {})
        if method == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"])
        if method == "Log.entryAdded":
            self.messages.append(params["entry"]["text"])
        if method in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled"):
            self.messages.append(json.dumps(params))
        return str(method)


def _modifiers(held: Sequence[str]) -> int:
    return sum(_MODIFIERS[key] for key in held)


@contextmanager
def opened(
    page: Path | str, scratch: Path, *, webgl: bool = False, size: tuple[int, int] | None = None
) -> Iterator[Page]:
    """Open a page.

    Args:
        page: The HTML file, or an address.
        scratch: A folder that the browser may fill.
        webgl: Whether it needs WebGL 2, which is drawn in software.
        size: Width and height of the window; the browser's own without.
    """
    address = page.resolve().as_uri() if isinstance(page, Path) else page
    pipe = _Pipe(scratch, _WEBGL if webgl else _FLAT)
    try:
        target = pipe.ask("Target.createTarget", url="about:blank")["targetId"]
        told = pipe.ask("Target.attachToTarget", targetId=target, flatten=True)
        window = Page(pipe, told["sessionId"])
        if size:
            window.resize(*size)
        window._load(address)
        yield window
    finally:
        pipe.close()


class _Pipe:
    """Messages to and from a browser: JSON, each with a zero byte at its end."""

    def __init__(self, scratch: Path, options: Sequence[str]) -> None:
        assert _EXECUTABLE is not None
        theirs, ours = os.pipe()
        back, back_theirs = os.pipe()
        words = [_EXECUTABLE, *_OPTIONS, *options, f"--user-data-dir={scratch}", "about:blank"]
        # The browser reads from 3 and writes to 4.
        script = f"exec {shlex.join(words)} 3<&{theirs} 4>&{back_theirs}"
        self._process = subprocess.Popen(
            ["bash", "-c", script], pass_fds=(theirs, back_theirs),
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(theirs)
        os.close(back_theirs)
        self._out, self._in = os.fdopen(ours, "wb"), os.fdopen(back, "rb")
        self._left = b""
        self._number = 0

    def write(self, method: str, params: dict[str, Any], session: str | None = None) -> int:
        self._number += 1
        told: dict[str, Any] = {"id": self._number, "method": method, "params": params}
        if session:
            told["sessionId"] = session
        self._out.write(json.dumps(told).encode() + b"\0")
        self._out.flush()
        return self._number

    def read(self) -> dict[str, Any]:
        while b"\0" not in self._left:
            said, _, _ = select.select([self._in], [], [], _PATIENCE_S)
            assert said, f"the browser has said nothing for {_PATIENCE_S} s"
            piece = os.read(self._in.fileno(), 1 << 16)
            assert piece, "the browser has ended"
            self._left += piece
        message, _, self._left = self._left.partition(b"\0")
        found: dict[str, Any] = json.loads(message)
        return found

    def ask(self, method: str, **params: Any) -> Any:
        number = self.write(method, params)
        while (told := self.read()).get("id") != number:
            pass
        return told["result"]

    def close(self) -> None:
        self._out.close()
        self._in.close()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
