"""A headless Chromium that opens pages, driven over its own protocol through a pipe."""

import base64
import json
import os
import select
import shlex
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import pytest

_EXECUTABLE: Final = os.environ.get("ORUSD_CHROMIUM") or shutil.which("chromium")
_OPTIONS: Final = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars",
    "--no-first-run", "--disable-background-networking", "--disable-extensions",
    "--remote-debugging-pipe",
)  # fmt: skip
_PATIENCE_S: Final = 120.0

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
        """The value of an expression in the page."""
        done = self._ask("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in done, done
        return done["result"].get("value")

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


@contextmanager
def opened(path: Path, scratch: Path) -> Iterator[Page]:
    """Open a page.

    Args:
        path: The HTML file.
        scratch: A folder that the browser may fill.
    """
    pipe = _Pipe(scratch)
    try:
        target = pipe.ask("Target.createTarget", url="about:blank")["targetId"]
        told = pipe.ask("Target.attachToTarget", targetId=target, flatten=True)
        page = Page(pipe, told["sessionId"])
        page._load(path.resolve().as_uri())
        yield page
    finally:
        pipe.close()


class _Pipe:
    """Messages to and from a browser: JSON, each with a zero byte at its end."""

    def __init__(self, scratch: Path) -> None:
        assert _EXECUTABLE is not None
        theirs, ours = os.pipe()
        back, back_theirs = os.pipe()
        words = [_EXECUTABLE, *_OPTIONS, f"--user-data-dir={scratch}", "about:blank"]
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
