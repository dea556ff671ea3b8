"""Crates that end USD's reader end it in another process, and ours are read at once."""

import os
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pxr import Usd, UsdGeom

from openrooms_usd import atomic, claims, isolation
from openrooms_usd.errors import InputError
from openrooms_usd.usd.files import layers
from openrooms_usd.usd.files.crate_reader import check_crate_reads

READER = isolation._reader("openrooms_usd.usd.files.crate_reader")


@pytest.fixture(autouse=True)
def fresh() -> Iterator[None]:
    READER.stop()
    yield
    READER.stop()


def crate(path: Path) -> Path:
    stage = Usd.Stage.CreateNew(str(path))
    mesh = UsdGeom.Mesh.Define(stage, "/World/mesh")
    mesh.CreatePointsAttr([(0, 0, i) for i in range(40)])
    mesh.CreateFaceVertexCountsAttr([3] * 20)
    UsdGeom.Xform.Define(stage, "/World/x").AddTranslateOp().Set((1, 2, 3))
    stage.GetRootLayer().Save()
    return path


def test_a_sound_crate_is_read(tmp_path: Path) -> None:
    path = crate(tmp_path / "a.usdc")
    check_crate_reads(str(path), path.stat().st_size)
    assert READER._process is not None
    assert layers.open_stage(path).GetPrimAtPath("/World/mesh")


def test_modules_in_the_current_folder_are_not_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = crate(tmp_path / "a.usdc")
    (tmp_path / "pathlib.py").write_text("open('taken', 'w').close()")
    monkeypatch.chdir(tmp_path)
    check_crate_reads(str(path), path.stat().st_size)
    assert READER._process is not None
    assert not (tmp_path / "taken").exists()


@pytest.mark.slow
def test_every_byte_of_a_crate_may_be_wrong(tmp_path: Path) -> None:
    """Refused or opened and read to the end, and this process lives."""
    data = crate(tmp_path / "a.usdc").read_bytes()
    refused = opened = 0
    for place in range(0, len(data), 9):
        damaged = tmp_path / f"{place}.usdc"
        damaged.write_bytes(data[:place] + bytes([data[place] ^ 0xFF]) + data[place + 1 :])
        try:
            stage = layers.open_stage(damaged)
            for prim in stage.TraverseAll():
                for attribute in prim.GetAttributes():
                    attribute.Get()
            opened += 1
        except InputError:
            refused += 1
        except (RuntimeError, UnicodeDecodeError):
            opened += 1  # late values are for those who read them
    # Whatever is not refused was opened; a damaged index is never taken for a sound one.
    assert refused + opened == len(range(0, len(data), 9))
    assert refused > 20 and opened > 20


@pytest.mark.parametrize(
    ("ends", "said"),
    [
        (lambda pid: os.kill(pid, signal.SIGKILL), "it crashes the process that reads it"),
        (lambda pid: os.kill(pid, signal.SIGSTOP), "reading it takes too long"),
    ],
)
def test_what_ends_or_holds_the_process(
    ends: Any, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = crate(tmp_path / "a.usdc")
    check_crate_reads(str(path), 1)
    process = READER._process
    assert process is not None
    monkeypatch.setattr(isolation, "_LEAST_SECONDS", 0.2)
    asked = READER.ask

    def ask(name: str, seconds: float) -> str | None:
        monkeypatch.setattr(READER, "_is_there", lambda: True)
        ends(process.pid)
        return asked(name, seconds)

    monkeypatch.setattr(READER, "ask", ask)
    with pytest.raises(InputError, match=said):
        check_crate_reads(str(path), 1)
    monkeypatch.undo()
    # The next one has a process again.
    check_crate_reads(str(path), 1)


class Slow(isolation._Reader):
    """A process that answers at a certain asking, and has worked for so long by then."""

    def __init__(self, answers_at: int, worked_s: float) -> None:
        super().__init__("openrooms_usd.usd.files.crate_reader")
        self.asked, self.answers_at, self.worked_s = 0, answers_at, worked_s

    def _answer(self, seconds: float) -> str | None:
        if seconds > 1.0:  # that it is ready
            return super()._answer(seconds)
        self.asked += 1
        return "read" if self.asked == self.answers_at else None

    def _worked(self) -> float:
        return self.worked_s * self.asked


@pytest.mark.parametrize(
    ("answers_at", "worked_s", "said", "asked"),
    [
        (7, 0.01, "read", 7),  # it waits for others on a busy machine, and is waited for
        (0, 0.01, "reading it takes too long", 10),
        (0, 0.3, "reading it takes too long", 1),  # it works without end
        (0, 0.16, "reading it takes too long", 2),
    ],
)
def test_who_is_waited_for_and_how_long(
    answers_at: int, worked_s: float, said: str, asked: int
) -> None:
    reader = Slow(answers_at, worked_s)
    assert reader.ask("anything", 0.25) == said
    assert reader.asked == asked
    assert (reader._process is not None) == (said == "read")
    reader.stop()


def test_the_work_of_a_process_is_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One that never ends has worked for all of the time that it had, where the system says so."""
    (tmp_path / "endless.py").write_text(
        "from openrooms_usd.isolation import serve\n"
        "def read(name):\n    while True:\n        pass\n"
        "serve(read)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    reader = isolation._Reader("endless")
    asked = []
    answer = reader._answer
    monkeypatch.setattr(reader, "_answer", lambda s: asked.append(reader._worked()) or answer(s))
    assert reader.ask("anything", 0.3) == "reading it takes too long"
    assert reader._process is None
    assert asked == sorted(asked) and (len(asked) < 3 or asked[-1] > asked[1])


def test_where_no_process_can_be_had_nothing_is_tried(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.executable", shutil.which("true") or "/bin/true")
    path = crate(tmp_path / "a.usdc")
    check_crate_reads(str(path), 1)
    assert READER._process is None


def test_what_we_wrote_is_read_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    monkeypatch.setattr(READER, "ask", lambda name, seconds: asked.append(name))
    data = crate(tmp_path / "a.usdc").read_bytes()
    out = tmp_path / "out"
    with claims.claimed(out):
        atomic.write_bytes(out / "layers" / "ours.usdc", data)
        layers.open_stage(out / "layers" / "ours.usdc")
    assert asked == []
    # What a ledger says of earlier runs may be forged.
    os.utime(out / "layers" / "ours.usdc")
    with claims.claimed(out):
        layers.open_stage(out / "layers" / "ours.usdc")
    assert asked == [str(out / "layers" / "ours.usdc")]
    asked.clear()
    shutil.copy(tmp_path / "a.usdc", out / "layers" / "theirs.usdc")
    layers.open_stage(out / "layers" / "theirs.usdc")
    assert asked == [str(out / "layers" / "theirs.usdc")]
