"""A page's server: who may ask, what for, and what is told later."""

import json
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from openrooms_usd.cli.viewing import view
from openrooms_usd.description.model import Model, Number
from openrooms_usd.errors import InputError, OutputError
from openrooms_usd.view.app import App, Command
from openrooms_usd.view.room import room_app, room_state
from openrooms_usd.view.server import MOST_BYTES, TOKEN_HEADER, Server, serving
from tests.small import Stage


class Step(Model):
    by: Number
    """How far."""


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Server]:
    place = {"x": 0.0}

    def move(step: Step) -> dict[str, Any]:
        if step.by < 0:
            raise InputError("it cannot go back", place="the chair", remedy="go on")
        place["x"] += step.by
        return dict(place)

    app = App(
        page="source",
        title="a <chair>",
        state=lambda: dict(place),
        resources={"room.glb": lambda: b"glTF\0\xff"},
        commands={"move": Command(Step, move)},
        watched=(tmp_path / "edits.usda",),
    )
    with serving(app) as server:
        yield server


def asked(
    server: Server, path: str, body: object = None, token: str | None = None
) -> tuple[int, bytes]:
    data = body if isinstance(body, bytes) or body is None else json.dumps(body).encode()
    request = urllib.request.Request(f"http://127.0.0.1:{server.server_port}{path}", data)
    request.add_header(TOKEN_HEADER, server.token if token is None else token)
    try:
        with urllib.request.urlopen(request, timeout=20) as answer:
            return answer.status, answer.read()
    except urllib.error.HTTPError as error:
        with error:
            return error.code, error.read()


def test_what_is_offered_is_told(served: Server) -> None:
    assert asked(served, "/state") == (200, b'{"x": 0.0}')
    assert asked(served, "/resource/room.glb") == (200, b"glTF\0\xff")
    assert asked(served, "/command/move", {"by": 2}) == (200, b'{"x": 2.0}')
    assert asked(served, "/state") == (200, b'{"x": 2.0}')
    status, text = asked(served, "/")
    assert status == 200 and b"<title>a &lt;chair&gt;</title>" in text
    assert b'"orusd/source.js":"/page/source.js"' in text


@pytest.mark.parametrize("path", ["/", "/state", "/resource/room.glb", "/events"])
@pytest.mark.parametrize("token", ["", "x", "é"])
def test_nothing_is_told_without_the_token(served: Server, path: str, token: str) -> None:
    status, text = asked(served, path, token=token)
    assert status == 403 and "whole address" in json.loads(text)["error"]["message"]


def test_nothing_is_done_without_the_token(served: Server) -> None:
    assert asked(served, "/command/move", {"by": 1}, token="x")[0] == 403
    assert asked(served, "/state") == (200, b'{"x": 0.0}')


@pytest.mark.parametrize(
    "path",
    (
        "/page/../app.py /page/%2e%2e/app.py /page//etc/passwd /resource/../state"
        " /resource/room.yaml /etc/passwd /page/ /command/move /page/..%5capp.py"
    ).split(),
)
def test_no_file_is_reached_by_its_path(served: Server, path: str) -> None:
    assert asked(served, path)[0] == 404


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (b"{", "JSON"),
        ({"by": "2"}, "by"),
        ({"by": 1, "z": 2}, "z"),
        ({}, "by"),
        ([], ""),
        (b'{"by": NaN}', "by"),
        (b"\xff\xfe", ""),
    ],
)
def test_what_a_command_does_not_take_is_refused(served: Server, body: object, said: str) -> None:
    status, text = asked(served, "/command/move", body)
    assert status == 400 and said in json.loads(text)["error"]["message"]
    assert asked(served, "/state") == (200, b'{"x": 0.0}')


def test_what_cannot_be_done_is_said_with_place_and_remedy(served: Server) -> None:
    status, text = asked(served, "/command/move", {"by": -1})
    told = json.loads(text)["error"]
    assert (status, told["place"], told["remedy"]) == (422, "the chair", "go on")


def test_nobody_fills_the_memory(served: Server) -> None:
    request = urllib.request.Request(
        f"http://127.0.0.1:{served.server_port}/command/move",
        b"{}",
        {TOKEN_HEADER: served.token, "Content-Length": str(MOST_BYTES + 1)},
    )
    with pytest.raises(urllib.error.HTTPError) as refused:
        urllib.request.urlopen(request, timeout=20)
    assert refused.value.code == 413
    refused.value.close()


def test_commands_run_one_at_a_time(served: Server) -> None:
    threads = [
        threading.Thread(target=asked, args=(served, "/command/move", {"by": 1})) for _ in range(20)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert asked(served, "/state") == (200, b'{"x": 20.0}')


def test_what_another_program_writes_is_told(served: Server, tmp_path: Path) -> None:
    address = f"http://127.0.0.1:{served.server_port}/events?token={served.token}"
    with urllib.request.urlopen(address, timeout=20) as events:
        assert events.readline() == b": open\n"
        (tmp_path / "new.usda").write_text("#usda 1.0\n")
        (tmp_path / "new.usda").rename(tmp_path / "edits.usda")
        events.readline()
        assert events.readline() == b'data: {"event": "changed", "file": "edits.usda"}\n'


def test_a_port_that_is_taken_is_said(served: Server) -> None:
    with pytest.raises(OutputError, match="--port"), serving(served.app, port=served.server_port):
        pass


def test_it_listens_on_this_machine_alone(served: Server) -> None:
    assert served.server_address[0] == "127.0.0.1"
    assert served.address.startswith("http://127.0.0.1:")


def test_a_room_is_written_as_a_page(composed_demo: Path, tmp_path: Path) -> None:
    target = tmp_path / "room.html"
    done = CliRunner().invoke(view, [str(composed_demo), "--export", str(target)])
    assert done.exit_code == 0 and str(target) in done.output
    text = target.read_text()
    assert 'data-resource="room.glb"' in text and "traced.png" not in text
    # Nothing of the machine that made it.
    assert str(composed_demo.parent) not in text


def test_any_stage_has_a_page(tmp_path: Path) -> None:
    made = Stage(up="Y", metres=0.01, path=tmp_path / "box.usda")
    made.box("/Box", 100.0)
    made.camera((0, 0, 400), (0, 0, 0), up=(0, 1, 0))
    made.stage.Save()
    state = room_state(tmp_path / "box.usda")
    assert [prim["path"] for prim in state["prims"]] == ["/Box", "/Camera"]
    (camera,) = state["cameras"]
    assert [row[3] for row in camera["world_from_camera"][:3]] == pytest.approx([0, -4, 0])
    assert room_app(tmp_path / "box.usda").resources["room.glb"]()[:4] == b"glTF"


def test_what_is_not_there_is_told(tmp_path: Path) -> None:
    for name in ("room.usda", "scan.ply"):
        with pytest.raises(InputError, match="no such file"):
            CliRunner().invoke(view, [str(tmp_path / name)], catch_exceptions=False)
