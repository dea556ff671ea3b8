"""Serves a page to browsers: on this machine unless told otherwise, never without a token.

Nothing is a path: a browser gets the project's own modules, and what the page offers by name. Other
pages that are open in the same browser know no token, so they can neither read nor do anything.
"""

import json
import os
import queue
import secrets
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, Final
from urllib.parse import parse_qs, urlsplit

from pydantic import ValidationError

from openrooms_usd.errors import OrusdError, OutputError
from openrooms_usd.view.app import STAGES, App
from openrooms_usd.view.shell import STYLE, modules, wrapped

# Between two looks, seconds.
_PAUSE_S: Final = 0.4
Stamp = tuple[int, int, int] | None
LOOPBACK: Final = "127.0.0.1"
TOKEN_HEADER: Final = "X-Orusd-Token"
# What a browser may send at once, and events that wait for one that does not listen.
MOST_BYTES: Final = 16 << 20
_MOST_EVENTS: Final = 256
# Between two signs of life, seconds: so a page that was closed is noticed.
_PULSE_S: Final = 10.0
_KINDS: Final = {".js": "text/javascript", ".css": "text/css"}


class Server(ThreadingHTTPServer):
    """A page that is being served.

    Attributes:
        app: The page.
        address: Where it is, with its token.
    """

    daemon_threads = True
    # On Windows two programs could share a port.
    allow_reuse_address = os.name == "posix"

    def __init__(self, app: App, host: str, port: int) -> None:
        try:
            super().__init__((host, port), _Handler)
        except OSError as error:
            raise OutputError(
                f"cannot serve a page there: {error.strerror or error}",
                place=f"{host}:{port}",
                remedy="use another --port, or 0 for any that is free",
            ) from error
        self.app = app
        self.token = secrets.token_urlsafe(24)
        self.address = f"http://{host}:{self.server_port}/?token={self.token}"
        self.modules = modules()
        self._listeners: list[queue.Queue[str]] = []

    def tell(self, event: str, **data: Any) -> None:
        """Tell all open pages of something."""
        text = json.dumps({"event": event, **data}, allow_nan=False)
        for listener in list(self._listeners):
            # One that does not listen any more loses what is new.
            with suppress(queue.Full):
                listener.put_nowait(text)

    @contextmanager
    def listening(self) -> Iterator["queue.Queue[str]"]:
        """Messages from now on."""
        listener: queue.Queue[str] = queue.Queue(_MOST_EVENTS)
        self._listeners.append(listener)
        try:
            yield listener
        finally:
            self._listeners.remove(listener)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that disconnects is not an error."""


@contextmanager
def serving(app: App, *, host: str = LOOPBACK, port: int = 0) -> Iterator[Server]:
    """Serve a page while the block runs.

    Args:
        app: The page.
        host: The address to listen on.
        port: The port; 0 for any that is free.

    Raises:
        OutputError: The port is in use, or the host is not an address of this machine.
    """
    with Server(app, host, port) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.1,), daemon=True)
        thread.start()
        try:
            with watching(app.watched, lambda path: server.tell("changed", file=path.name)):
                yield server
        finally:
            server.shutdown()
            thread.join()


class _Handler(BaseHTTPRequestHandler):
    """Answers one browser."""

    server: Server
    protocol_version = "HTTP/1.1"
    server_version = "orusd"
    sys_version = ""

    def do_GET(self) -> None:
        path, name = self._request_target()
        app = self.server.app
        if path == "page" and name in self.server.modules:
            self._send(_KINDS[name[name.rindex(".") :]], self.server.modules[name])
        elif not self._is_trusted():
            self._refuse(HTTPStatus.FORBIDDEN, "open the whole address that orusd printed")
        elif (path, name) == ("", ""):
            self._index()
        elif (path, name) == ("state", ""):
            self._answer(app.state)
        elif path == "resource" and (name in app.resources or name in app.live):
            self._resource(name)
        elif (path, name) == ("events", ""):
            self._events()
        else:
            self._refuse(HTTPStatus.NOT_FOUND, "there is no such resource")

    def do_POST(self) -> None:
        path, name = self._request_target()
        length = self.headers.get("Content-Length", "")
        self.close_connection = True
        if not self._is_trusted():
            self._refuse(HTTPStatus.FORBIDDEN, "open the whole address that orusd printed")
        elif path != "command" or name not in self.server.app.commands:
            self._refuse(HTTPStatus.NOT_FOUND, "there is no such command")
        elif not length.isdecimal() or int(length) > MOST_BYTES:
            self._refuse(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"send up to {MOST_BYTES} bytes")
        else:
            command = self.server.app.commands[name]
            try:
                given = command.model.model_validate_json(self.rfile.read(int(length)))
            except ValidationError as error:
                mistakes = "; ".join(
                    f"{'.'.join(map(str, one['loc']))}: {one['msg']}" for one in error.errors()
                )
                self._refuse(HTTPStatus.BAD_REQUEST, mistakes)
                return
            self._answer(lambda: command.run(given))

    def _request_target(self) -> tuple[str, str]:
        first, _, rest = urlsplit(self.path).path.removeprefix("/").partition("/")
        return first, rest

    def _is_trusted(self) -> bool:
        query = parse_qs(urlsplit(self.path).query).get("token", [""])[0]
        given = self.headers.get(TOKEN_HEADER) or query
        return secrets.compare_digest(given.encode(), self.server.token.encode())

    def _index(self) -> None:
        app, nonce = self.server.app, secrets.token_urlsafe(16)
        places = {name: f"/page/{name}" for name in self.server.modules if name.endswith(".js")}
        head = f'<link rel="stylesheet" href="/page/{STYLE}"><link rel="icon" href="data:,">'
        text = wrapped(app.page, app.title, places, head=head, nonce=nonce)
        policy = (
            f"default-src 'self'; script-src 'self' 'nonce-{nonce}'; "
            "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
            "media-src 'self' blob:; frame-ancestors 'none'"
        )
        self._send("text/html", text.encode(), {"Content-Security-Policy": policy})

    def _answer(self, make: Any) -> None:
        """What commands and the state say."""
        try:
            with STAGES:
                told: Mapping[str, Any] = make()
        except OrusdError as error:
            self._send_json(HTTPStatus.UNPROCESSABLE_ENTITY, {"error": error.as_dict()})
            return
        self._send_json(HTTPStatus.OK, told)

    def _resource(self, name: str) -> None:
        try:
            with STAGES:
                app = self.server.app
                content = (app.live.get(name) or app.resources[name])()
        except OrusdError as error:
            self._send_json(HTTPStatus.UNPROCESSABLE_ENTITY, {"error": error.as_dict()})
            return
        self._send("application/octet-stream", content)

    def _events(self) -> None:
        self.close_connection = True
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", "text/event-stream")
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        with self.server.listening() as listener, suppress(OSError):
            self.wfile.write(b": open\n\n")
            while True:
                try:
                    text = f"data: {listener.get(timeout=_PULSE_S)}\n\n"
                except queue.Empty:
                    text = ": still here\n\n"
                self.wfile.write(text.encode())

    def _refuse(self, status: HTTPStatus, message: str) -> None:
        self._send_json(status, {"error": {"message": message, "place": None, "remedy": None}})

    def _send_json(self, status: HTTPStatus, data: Mapping[str, Any]) -> None:
        self._send("application/json", json.dumps(data, allow_nan=False).encode(), status=status)

    def _send(
        self,
        kind: str,
        content: bytes,
        headers: Mapping[str, str] | None = None,
        *,
        status: HTTPStatus = HTTPStatus.OK,
    ) -> None:
        self.send_response(status)
        said = {
            "Content-Type": kind if kind.endswith(("stream", "json")) else f"{kind}; charset=utf-8",
            "Content-Length": str(len(content)),
            "Cache-Control": "no-store",
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
            "Cross-Origin-Resource-Policy": "same-origin",
            **(headers or {}),
        }
        for name, value in said.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing: a token would stand in what is said."""


@contextmanager
def watching(files: Sequence[Path], changed: Callable[[Path], None]) -> Iterator[None]:
    """While the block runs, call ``changed`` with each file that was written or replaced.

    Args:
        files: The files; they need not exist yet.
        changed: Called in a thread of its own.
    """
    ended = threading.Event()
    seen = {path: _stamp(path) for path in files}

    def look() -> None:
        while not ended.wait(_PAUSE_S):
            for path, before in seen.items():
                now = _stamp(path)
                if now != before:
                    seen[path] = now
                    changed(path)

    thread = threading.Thread(target=look, daemon=True)
    if files:
        thread.start()
    try:
        yield
    finally:
        ended.set()
        if files:
            thread.join()


def _stamp(path: Path) -> Stamp:
    try:
        told = path.stat()
    except OSError:
        return None
    return told.st_mtime_ns, told.st_size, told.st_ino
