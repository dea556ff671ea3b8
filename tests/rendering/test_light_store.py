"""The light of a room as a file: what names it, who may write it, and what is not believed."""

import hashlib
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import UsdLux

from openrooms_usd import atomic, claims, ledger
from openrooms_usd.rendering.light_store import FOLDER, content_key, load, places, save
from openrooms_usd.rendering.scene.arrays import PixelLabels, Scene
from openrooms_usd.rendering.scene.translate import translate
from tests.small import Stage

KEY = "5f" * 32
ARRAYS = {
    "light": np.arange(24, dtype=np.float32).reshape(2, 4, 3),
    "cells": np.array([[1, -2, 3]], np.int32),
    "none": np.zeros((0, 3)),
    "one": np.array(7, np.int64),
}
MAKERS = ("openrooms_usd.rendering.light_store",)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    build = Stage(path=tmp_path / "room" / "scene.usda")
    build.box("/Room", 2.0, inside=True, material=build.material("/Paint"))
    lamp = UsdLux.RectLight.Define(build.stage, "/Lamp")
    lamp.CreateIntensityAttr(3.0)
    build.stage.Save()
    return tmp_path / "room" / "scene.usda"


@pytest.fixture
def scene(file: Path) -> Scene:
    from openrooms_usd.usd.files.layers import open_stage

    return translate(open_stage(file))


def equal(a: dict[str, np.ndarray] | None, b: dict[str, np.ndarray]) -> bool:
    return a is not None and {name: (x.dtype, x.shape, x.tobytes()) for name, x in a.items()} == {
        name: (x.dtype, x.shape, x.tobytes()) for name, x in b.items()
    }


def test_what_is_kept_is_had_again_and_has_equal_bytes_whoever_writes(tmp_path: Path) -> None:
    one, other = tmp_path / "one", tmp_path / "other"
    assert load(KEY, [one]) is None
    path = save(KEY, ARRAYS, [one])
    assert path and equal(load(KEY, [other, one]), ARRAYS)
    assert load("00" * 32, [one]) is None
    turned = {name: np.array(ARRAYS[name], order="F") for name in reversed(ARRAYS)}
    again = save(KEY, turned, [other])
    assert again and again.read_bytes() == path.read_bytes()


def test_what_lies_beside_a_room_is_of_that_room(scene: Scene, file: Path) -> None:
    beside, cache = places(scene)
    assert beside == file.parent / FOLDER
    assert cache == Path(os.environ["ORUSD_CACHE"]) / "light"
    assert places(replace(scene, folder=None)) == (cache,)
    assert translate(Stage().stage).folder is None


def test_no_cache_where_it_is_switched_off(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ORUSD_CACHE", "off")
    assert places(scene) == ()
    assert save(KEY, ARRAYS, places(scene)) is None


def _moved(scene: Scene) -> Scene:
    patch = scene.patches[0]
    corners = patch.triangles.corners.copy()
    corners[0, 0, 0] += 1e-9
    moved = replace(patch, triangles=replace(patch.triangles, corners=corners))
    return replace(scene, patches=(moved, *scene.patches[1:]))


def _painted(scene: Scene) -> Scene:
    patch = scene.patches[0]
    painted = replace(patch, surface=replace(patch.surface, base_color=(0.18, 0.18, 0.19)))
    return replace(scene, patches=(painted, *scene.patches[1:]))


def _dimmed(scene: Scene) -> Scene:
    return replace(scene, patches=(*scene.patches[:-1], replace(scene.patches[-1], radiance=2.9)))


@pytest.mark.parametrize("change", [_moved, _painted, _dimmed])
def test_other_content_has_another_key(scene: Scene, change: Callable[[Scene], Scene]) -> None:
    assert content_key(change(scene), MAKERS, 7) != content_key(scene, MAKERS, 7)


def test_other_settings_and_other_code_have_another_key(scene: Scene) -> None:
    keys = {
        content_key(scene, MAKERS, 7, {"cell": 0.05}),
        content_key(scene, MAKERS, 8, {"cell": 0.05}),
        content_key(scene, MAKERS, 7, {"cell": 0.06}),
        content_key(scene, MAKERS, [7, {"cell": 0.05}]),
        content_key(scene, ("openrooms_usd.names",), 7, {"cell": 0.05}),
    }
    assert len(keys) == 5


def test_labels_and_places_do_not_count(scene: Scene, tmp_path: Path) -> None:
    named = replace(
        scene, pieces=tuple(replace(p, semantic=9) for p in scene.pieces), folder=tmp_path
    )
    assert all(isinstance(piece, PixelLabels) for piece in named.pieces)
    assert content_key(named, MAKERS, 7) == content_key(scene, MAKERS, 7)


def _flip(data: bytes) -> bytes:
    return data[:-3] + bytes([data[-3] ^ 1]) + data[-2:]


def _signed(body: bytes) -> bytes:
    """A file of a stranger, whose checksum holds."""
    return b"orusd light cache 1\n" + hashlib.sha256(body).hexdigest().encode() + b"\n" + body


def _header(rows: str, data: bytes = b"", key: str = KEY) -> bytes:
    return _signed(f'{{"key":"{key}","arrays":{rows}}}\n'.encode() + data)


HOSTILE = {
    "empty": b"",
    "cut": None,
    "bits": None,
    "not text": b"\xff" * 500,
    "nested": _signed(b"[" * 60_000 + b"\n"),
    "no line": _signed(b"{" * 70_000),
    "no rows": _signed(b"{}\n"),
    "of another key": _header("[]", key="00" * 32),
    "objects": _header('[["light","|O",[1]]]', b"\0" * 8),
    "not finite": _header('[["light","<f4",[1]]]', np.float32(np.nan).tobytes()),
    "too large": _header('[["light","<f4",[1099511627775,1099511627775]]]'),
    "negative": _header('[["light","<f4",[-1,-4]]]', b"\0" * 16),
    "no shape": _header('[["light","<f4",7]]'),
    "true": _header('[["light","<f4",[true]]]', b"\0" * 4),
    "too long": _header('[["light","<f4",[1]]]', b"\0" * 5),
    "many axes": _header(f'[["light","<f4",{[1] * 40}]]', b"\0" * 4),
}


@pytest.mark.parametrize("kind", HOSTILE)
def test_what_is_damaged_or_foreign_is_not_believed(
    kind: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = save(KEY, ARRAYS, [tmp_path])
    assert path
    whole = path.read_bytes()
    data = {"cut": whole[:-9], "bits": _flip(whole)}.get(kind, HOSTILE[kind])
    assert data is not None
    path.write_bytes(data)
    assert load(KEY, [tmp_path]) is None
    assert "is damaged: the light of the room is computed again" in caplog.text
    # It gives way to what is computed then.
    save(KEY, ARRAYS, [tmp_path])
    assert equal(load(KEY, [tmp_path]), ARRAYS)


@pytest.mark.parametrize("array", [np.array([np.inf]), np.array(["x"]), np.array([object()])])
def test_what_is_no_plain_number_is_not_kept(array: np.ndarray, tmp_path: Path) -> None:
    with pytest.raises((ValueError, TypeError)):
        save(KEY, {"light": array}, [tmp_path])
    assert not list(tmp_path.iterdir())


def test_a_pipe_or_a_link_in_its_place(tmp_path: Path) -> None:
    folder = tmp_path / FOLDER
    folder.mkdir()
    os.mkfifo(folder / f"{KEY}.light")
    assert load(KEY, [folder]) is None
    assert save(KEY, ARRAYS, [folder]) is None
    away = tmp_path / "away"
    away.mkdir()
    (tmp_path / "linked").symlink_to(away)
    assert save(KEY, ARRAYS, [tmp_path / "linked", tmp_path / "next"]) == (
        tmp_path / "next" / f"{KEY}.light"
    )
    assert not list(away.iterdir())


def test_where_a_folder_cannot_be_written_the_next_is_taken(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("a file")
    kept = save(KEY, ARRAYS, [tmp_path / "taken" / FOLDER, tmp_path / "cache"])
    assert kept == tmp_path / "cache" / f"{KEY}.light"
    assert equal(load(KEY, [tmp_path / "taken" / FOLDER, tmp_path / "cache"]), ARRAYS)


def test_the_files_that_were_used_last_stay_and_what_is_not_ours(tmp_path: Path) -> None:
    folder = tmp_path / FOLDER
    folder.mkdir()
    (folder / "notes.light").write_text("of somebody")
    os.utime(folder / "notes.light", (1, 1))
    keys = [f"{i:02x}" * 32 for i in range(6)]
    for age, key in enumerate(keys):
        path = save(key, ARRAYS, [folder])
        assert path
        os.utime(path, (1000 + age, 1000 + age))
        # The first is used again and again.
        assert load(keys[0], [folder]) is not None
    kept = {path.stem for path in folder.iterdir()}
    assert kept == {"notes", keys[0], *keys[-3:]}


def test_a_ledger_does_not_take_it_for_its_own(tmp_path: Path) -> None:
    """Any process may write it: that a command did so proves nothing, and changes no ledger."""
    with claims.claimed(tmp_path):
        save(KEY, ARRAYS, [tmp_path / FOLDER])
        atomic.write_text(tmp_path / "layers" / "room.usda", "#usda 1.0\n")
    assert FOLDER not in (tmp_path / ledger.FILE).read_text()
    with claims.claimed(tmp_path) as kept:
        assert [path.name for path in kept.below(tmp_path)] == ["room.usda"]
    assert equal(load(KEY, [tmp_path / FOLDER]), ARRAYS)


_WRITER = """
import sys
from pathlib import Path
import numpy as np
from openrooms_usd.rendering.light_store import content_key, load, save
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd.files.layers import open_stage
scene = translate(open_stage(Path(sys.argv[1])))
key = content_key(scene, ("openrooms_usd.rendering.light_store",))
folder, arrays = Path(sys.argv[2]), {"light": np.arange(9_000, dtype=np.float32)}
for _ in range(15):
    save(key, arrays, [folder])
    found = load(key, [folder])
    assert found is not None and (found["light"] == arrays["light"]).all()
print(key)
"""


@pytest.mark.slow
def test_processes_that_write_at_the_same_time_agree(file: Path, tmp_path: Path) -> None:
    words = [sys.executable, "-c", _WRITER, str(file), str(tmp_path / "light")]
    started = [subprocess.Popen(words, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    keys = {process.communicate()[0].strip() for process in started}
    assert [process.returncode for process in started] == [0, 0]
    assert [path.stem for path in (tmp_path / "light").iterdir()] == [*keys]
