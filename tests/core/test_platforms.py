"""What other systems do differently, played on this one: Windows and macOS cannot be had here."""

import ctypes
import io
import ntpath
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path, PureWindowsPath
from types import SimpleNamespace
from typing import Any

import filelock
import pytest

from openrooms_usd import claims, ledger, portable, processes, removal, unfinished, untrusted
from openrooms_usd.capture import Packed
from openrooms_usd.cli.console import take_all_letters
from openrooms_usd.dataset import scratch
from openrooms_usd.dataset.executor import WorkerDemand
from openrooms_usd.dataset.local import LocalExecutor
from openrooms_usd.errors import InputError, OutputError
from openrooms_usd.importing import captures
from openrooms_usd.rendering import folder as render_folder
from openrooms_usd.rendering.plan import view_names
from openrooms_usd.rendering.scene.light_records import _unique
from openrooms_usd.scratch import scratch_folder


@pytest.fixture
def windows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Code that asks for the system takes it for Windows."""
    monkeypatch.setattr(sys, "platform", "win32")


def ended() -> int:
    """The number of a process that ran, and is gone."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


@pytest.mark.parametrize(
    ("handle", "error", "waits", "runs"),
    [(0, 87, 0, False), (0, 5, 0, True), (64, 0, 0x102, True), (64, 0, 0, False)],
    ids=["unknown", "of another user", "runs", "ended, and not yet forgotten"],
)
def test_windows_is_asked_for_a_process(
    handle: int, error: int, waits: int, runs: bool, windows: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    closed: list[Any] = []
    kernel = SimpleNamespace(
        OpenProcess=lambda access, inherits, pid: handle,
        WaitForSingleObject=lambda handle, milliseconds: waits,
        CloseHandle=lambda handle: closed.append(handle.value),
    )
    monkeypatch.setattr(ctypes, "WinDLL", lambda name, use_last_error: kernel, raising=False)
    monkeypatch.setattr(ctypes, "get_last_error", lambda: error, raising=False)
    monkeypatch.setattr(os, "kill", lambda pid, number: pytest.fail("Ctrl-C was sent"))
    assert processes.is_running(1234) is runs
    assert closed == ([handle] if handle else [])


def test_processes_here_are_asked_for_without_harm() -> None:
    assert processes.is_running(os.getpid())
    assert not processes.is_running(ended())
    assert not processes.is_running(2**70)


def test_a_folder_that_made_room_comes_back_on_windows(
    tmp_path: Path, windows: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    old = unfinished.parking_name(tmp_path / "layers").name.replace(str(os.getpid()), "77")
    (tmp_path / old).mkdir()
    monkeypatch.setattr(processes, "_is_running_on_windows", lambda pid: pid != 77)
    unfinished.sweep(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["layers"]


def test_scratch_of_the_dead_goes_without_users_numbers(
    tmp_path: Path, windows: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(os, "getuid")
    left = tmp_path / "orusd.scratch.left"
    left.mkdir()
    (left / ".orusd.lock").touch()
    scratch._sweep(tmp_path)
    assert not left.exists()


def test_windows_waits_for_few_workers_at_once(windows: None) -> None:
    with LocalExecutor().hired(WorkerDemand(200)) as crew:
        assert crew.workers == 60


def test_windows_renames_once_a_virus_scanner_lets_go(
    tmp_path: Path, windows: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    new, pauses, replace = tmp_path / "new", list[float](), Path.replace
    new.touch()

    def refuse(source: Path, target: Path) -> Path:
        if len(pauses) < 2:
            raise PermissionError
        return replace(source, target)

    monkeypatch.setattr(time, "sleep", pauses.append)
    monkeypatch.setattr(Path, "replace", refuse)
    removal.rename(new, tmp_path / "there")
    assert (tmp_path / "there").exists() and len(pauses) == 2


def test_scratch_that_a_library_holds_open_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any, **__: Any) -> None:
        raise PermissionError

    with scratch_folder() as folder, monkeypatch.context() as patch:
        (folder / "mapped.usdc").touch()
        patch.setattr(os, "unlink", refuse)
        patch.setattr(os, "remove", refuse)
        with scratch_folder() as other:
            (other / "mapped.usdc").touch()
    assert not folder.exists() and other.exists()
    shutil.rmtree(other)


def test_a_lock_that_windows_lets_nobody_read_is_held(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(path: Path, *_: Any) -> str:
        raise InputError("cannot read it") from PermissionError(13, "Permission denied")

    monkeypatch.setattr(untrusted, "read_text", refuse)
    with (
        filelock.FileLock(tmp_path / claims.FILE),
        pytest.raises(OutputError, match="another process is writing"),
        claims.locked(tmp_path),
    ):
        pass


def test_a_folder_that_windows_does_not_open_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: Any) -> int:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(InputError, match="this is a folder, not a file"):
        untrusted.read_bytes(tmp_path, "text")


@pytest.mark.parametrize("name", ["C:/other/a.usda", "C:a.usda", "..\\..\\a.usda"])
def test_no_line_of_a_ledger_leads_out_of_its_folder(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ledger, "Path", PureWindowsPath)
    assert ledger._is_inner("layers/layout.usda")
    assert not ledger._is_inner(name)


def test_paths_are_told_with_slashes_and_across_drives(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(portable, "Path", PureWindowsPath)
    monkeypatch.setattr(os.path, "relpath", ntpath.relpath)
    monkeypatch.setattr(os.path, "commonpath", ntpath.commonpath)
    room: Any = PureWindowsPath("C:/rooms/a")
    for path, said in [
        ("C:/rooms/a/layers/x.usda", "./layers/x.usda"),
        ("C:/rooms/b.usda", "../b.usda"),
        ("D:/b.usda", "D:/b.usda"),
    ]:
        file: Any = PureWindowsPath(path)
        assert portable.anchored_text(file, room) == said
    assert str(portable.common_folder(["C:/rooms/a", "C:/rooms/b"])) == r"C:\rooms"
    with pytest.raises(InputError, match="different drives"):
        portable.common_folder(["C:/rooms/a", "D:/b"])


def test_paths_have_one_order_on_every_system() -> None:
    names = ["b/x.png", "B.png", "a.png", "A/c.png"]
    kinds: tuple[Any, ...] = (Path, PureWindowsPath)
    orders = [[p.as_posix() for p in portable.in_order(map(kind, names))] for kind in kinds]
    assert orders[0] == orders[1] == ["A/c.png", "B.png", "a.png", "b/x.png"]


def test_commands_are_quoted_for_the_shell_they_are_pasted_into(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    words = ["orusd", "compose", "C:\\My rooms\\room.yaml"]
    assert portable.shell_line(words) == r"orusd compose 'C:\My rooms\room.yaml'"
    monkeypatch.setattr(sys, "platform", "win32")
    assert portable.shell_line(words) == r'orusd compose "C:\My rooms\room.yaml"'


def test_names_of_files_differ_in_any_case_and_are_no_devices() -> None:
    assert view_names(["/A/Left", "/A/left", "/A/aux", "/A/right"]) == {
        "/A/Left": "A.Left",
        "/A/left": "A.left",
        "/A/aux": "A.aux",
        "/A/right": "right",
    }
    assert _unique(["Lamp", "lamp", "lamp_2", "nul", "lamp"]) == [
        "Lamp",
        "lamp_3",
        "lamp_2",
        "nul_2",
        "lamp_4",
    ]


@pytest.mark.parametrize("name", ["Room.YAML", "../scan.ply", "/scan.ply", "a/../../scan.ply"])
def test_no_file_of_a_capture_lies_elsewhere_or_is_the_description(
    name: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match="cannot be copied"):
        captures._check_names(Packed(name, {name: b""}), tmp_path)


@pytest.mark.parametrize("name", ["stdout", "stderr"])
def test_pipes_of_windows_take_all_letters(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PYTHONIOENCODING", raising=False)
    data = io.BytesIO()
    monkeypatch.setattr(sys, name, io.TextIOWrapper(data, "cp1252"))
    take_all_letters()
    print("Łódź \udc80", file=getattr(sys, name), end="", flush=True)
    assert data.getvalue() == "Łódź \\udc80".encode()


def test_a_drive_that_is_not_there_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(path: Path) -> os.stat_result:
        raise FileNotFoundError(2, "The system cannot find the path specified")

    monkeypatch.setattr(Path, "lstat", missing)
    with pytest.raises(OutputError, match="cannot find the path"):
        render_folder.check_writable(Path("/Z/out"))
