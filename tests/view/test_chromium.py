"""The browser that tests drive: real mouse and keys, pages behind an address, WebGL 2."""

import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from tests.chromium import needs_chromium, opened

pytestmark = [pytest.mark.slow, needs_chromium]

PAGE = """<!doctype html><body style="margin:0"><canvas id=a width=200 height=100></canvas>
<input id=b style="display:block;margin-top:2000px"><script>
const told = [], note = (e) => told.push([e.type, e.clientX ?? e.key, e.buttons, e.shiftKey]);
for (const kind of ["mousedown", "mousemove", "mouseup", "wheel", "keydown"])
  document.addEventListener(kind, note);
setTimeout(() => { window.later = 7 }, 200);
const gl = document.getElementById("a").getContext("webgl2");
gl.clearColor(1, 0, 0, 1); gl.clear(gl.COLOR_BUFFER_BIT);
const pixel = new Uint8Array(4);
gl.readPixels(3, 3, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
</script>"""


class _Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_: object) -> None:
        pass


def test_a_page_behind_an_address_gets_mouse_keys_and_webgl(tmp_path: Path) -> None:
    (tmp_path / "page.html").write_text(PAGE)
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(_Quiet, directory=str(tmp_path)))
    threading.Thread(target=server.serve_forever).start()
    try:
        address = f"http://127.0.0.1:{server.server_port}/page.html"
        with opened(address, tmp_path / "scratch", webgl=True, size=(400, 300)) as page:
            assert page.evaluate("[innerWidth, ...pixel]") == [400, 255, 0, 0, 255]
            page.drag((20, 30), (60, 30), held=["Shift"], steps=2)
            page.key("a")
            page.key("Escape")
            assert page.evaluate("told.filter(t => t[0] != 'mousemove' || t[2])") == [
                ["mousedown", 20, 1, True], ["mousemove", 40, 1, True],
                ["mousemove", 60, 1, True], ["mouseup", 60, 0, True],
                ["keydown", "a", None, False], ["keydown", "Escape", None, False],
            ]  # fmt: skip
            assert page.wait("window.later") == 7
            page.wheel(50, 50, 30)
            assert page.wait("told.some(t => t[0] == 'wheel')")
            page.click_on("#b")
            page.write("walls")
            page.key("s")
            assert page.evaluate("document.getElementById('b').value") == "wallss"
            assert page.evaluate("Promise.resolve(5)") == 5
    finally:
        server.shutdown()
        server.server_close()
