"""Ctrl-C in real processes: what was finished is whole, and nothing is half there."""

import json
import shutil
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

INTERRUPTED = 130


def interrupt(process: "subprocess.Popen[str]", when: Callable[[], bool], lab: Any) -> None:
    """Press Ctrl-C as soon as something holds; the process then leaves as it should."""
    limit = time.monotonic() + 60
    while not when() and process.poll() is None and time.monotonic() < limit:
        time.sleep(0.002)
    assert process.poll() is None, process.communicate()
    process.send_signal(signal.SIGINT)
    said = lab.finish(process)
    assert said.code == INTERRUPTED, said
    assert "Traceback" not in said.err
    told = [line for line in said.err.splitlines() if line and not line.startswith("note: ")]
    assert told == ["Interrupted. What was finished is kept."]
    assert said.out == ""


@pytest.fixture
def slow_room(lab: Any, tmp_path: Path) -> Path:
    """A room whose textures take their time."""
    room = tmp_path / "slow.yaml"
    room.write_text(lab.OTHER_ROOM.replace("resolution: 16}", "resolution: 512}"))
    return room


@pytest.mark.one_in(8)
@pytest.mark.parametrize("reached", ["edits", "layout", "alignment", "materials"])
def test_a_new_composition(reached: str, slow_room: Path, lab: Any, tmp_path: Path) -> None:
    out = tmp_path / "out"
    layers = out / "layers"
    process = lab.start("compose", slow_room, "-o", out)
    interrupt(process, lambda: any(layers.glob(f".{reached}.*")), lab)
    assert not out.exists()


@pytest.mark.slow
def test_an_earlier_composition_stays(slow_room: Path, lab: Any, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(lab.composed, out)
    before = lab.tree(out)
    textures = out / "layers" / "materials" / "textures"
    there = set(textures.iterdir())
    process = lab.start("compose", slow_room, "-o", out, "--usdz", "--flatten")
    interrupt(process, lambda: bool(set(textures.glob("*.png")) - there), lab)
    assert lab.tree(out) == before
    assert lab.finish(lab.start("compose", lab.room, "-o", out)).out.count("unchanged") == 6


@pytest.mark.slow
def test_a_render_after_its_first_view(lab: Any, tmp_path: Path) -> None:
    from openrooms_usd.channels import WRITTEN
    from openrooms_usd.rendering import exr

    out = tmp_path / "out"
    process = lab.start("render", lab.scene, "-o", out, "--variant", "scalar", "--max-seconds", "1")
    interrupt(process, lambda: (out / "timing.json").exists(), lab)
    views = json.loads((out / "manifest.json").read_text())["views"]
    assert list(views) == ["left"]
    there = {path.name for path in out.iterdir()}
    assert there - {".orusd.render.sha256"} == set(
        "left manifest.json timing.json contact_sheet.png".split()
    )
    assert exr.read_channels(out / "left" / "channels.exr").keys() == set(WRITTEN)
    pictures = {f"{name}.png" for name in WRITTEN}
    files = {path.name for path in (out / "left").iterdir()}
    assert files == pictures | {"channels.exr", "radiance.exr"}


@pytest.mark.slow
def test_an_earlier_render_stays_until_a_view_is_finished(lab: Any, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(lab.rendered, out)
    before = lab.tree(out)
    process = lab.start(
        "render", lab.scene, "-o", out, "--variant", "scalar", "--max-seconds", "60"
    )
    maps = Path(f"/proc/{process.pid}/maps")
    while "scalar_rgb" not in maps.read_text() and process.poll() is None:
        time.sleep(0.01)
    # While Mitsuba is imported Ctrl-C ends in errors of its own.
    loaded = time.monotonic()
    interrupt(process, lambda: time.monotonic() > loaded + 2.0, lab)
    assert lab.tree(out) == before


def test_a_conversion(lab: Any, tmp_path: Path) -> None:
    out = tmp_path / "out"
    process = lab.start("convert", lab.scene, out)
    interrupt(process, lambda: any(out.glob(".new.*")), lab)
    assert not out.exists()
