"""Two commands at once into one folder: the second is refused, and the first is not disturbed."""

import os
import shutil
import signal
import time
from pathlib import Path
from typing import Any

import pytest

from openrooms_usd.claims import locked

OUTPUT = 3


def wait_for(path: Path) -> None:
    limit = time.monotonic() + 60
    while not path.exists() and time.monotonic() < limit:
        time.sleep(0.002)
    assert path.exists()


@pytest.fixture
def slow_room(lab: Any, tmp_path: Path) -> Path:
    room = tmp_path / "slow.yaml"
    room.write_text(lab.OTHER_ROOM.replace("resolution: 16}", "resolution: 256}"))
    return room


@pytest.mark.slow
def test_two_rooms_at_once(orusd: Any, lab: Any, slow_room: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    first = lab.start("compose", slow_room, "-o", out)
    wait_for(out / "layers" / "layout")
    first.send_signal(signal.SIGSTOP)
    second = lab.finish(lab.start("compose", lab.room, "-o", out))
    first.send_signal(signal.SIGCONT)
    second.refused(OUTPUT, f"process {first.pid}", "is writing into this folder", "remedy: wait")
    assert lab.finish(first).code == 0
    assert orusd("validate", out / "scene.usda").code == 0
    alone = tmp_path / "alone"
    assert lab.finish(lab.start("compose", slow_room, "-o", alone)).code == 0
    assert lab.tree(out) == lab.tree(alone)


@pytest.mark.one_in(36)
@pytest.mark.parametrize(
    "command", ["compose", "import", "render", "dataset", "edit import-changes", "simulate"]
)
def test_who_writes_waits_for_nobody(command: str, orusd: Any, lab: Any, tmp_path: Path) -> None:
    """Each command that writes a folder names who has it, and leaves it as it is."""
    out = tmp_path / "out"
    shutil.copytree(
        lab.composed if command in ("edit import-changes", "simulate") else lab.rendered, out
    )
    table = tmp_path / "boxes.csv"
    table.write_text("label,x,y,z,width,depth,height\nchair,1,1,0,0.5,0.5,0.9\n")
    words = {
        "compose": ["compose", lab.room, "-o", out],
        "import": ["import", "boxes", table, "-o", out],
        "render": ["render", lab.scene, "-o", out, *lab.QUICK],
        "dataset": ["dataset", "write", lab.rendered, "-o", out],
        "edit import-changes": ["edit", "import-changes", out / "scene.usda"],
        "simulate": ["simulate", out / "scene.usda"],
    }
    before = lab.tree(out)
    with locked(out):
        held = lab.tree(out)
        said = lab.finish(lab.start(*words[command]))
        assert lab.tree(out) == held
    assert lab.tree(out) == before
    said.refused(OUTPUT, f"process {os.getpid()}", "is writing into this folder")


@pytest.mark.parametrize("layer", ["edits", "lights", "layout"])
def test_simulate_replaces_no_layer_of_the_room(
    layer: str, orusd: Any, lab: Any, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    shutil.copytree(lab.composed, out)
    before = lab.tree(out)
    said = orusd("simulate", out / "scene.usda", "-o", out / "layers" / f"{layer}.usda")
    said.refused(2, "part of the scene", "-o settled.usda")
    assert lab.tree(out) == before
