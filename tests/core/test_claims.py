"""One writer a folder, what it leaves when it is killed, and what may be removed again."""

import os
import re
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from openrooms_usd import atomic, claims, ledger, unfinished
from openrooms_usd.errors import OutputError

GONE = 4_194_305  # above the greatest number of a process


def start(out: Path, body: str) -> "subprocess.Popen[str]":
    """A process that claims a folder, does something, says so and waits."""
    code = (
        "import sys, time; from pathlib import Path; from openrooms_usd import atomic, claims\n"
        f"out = Path({str(out)!r})\n"
        "with claims.claimed(out) as kept:\n"
        f"    {body}\n"
        "    print('now', flush=True); time.sleep(60)\n"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout and process.stdout.readline() == "now\n"
    return process


def test_the_second_process_is_refused_and_told_who_is_there(tmp_path: Path) -> None:
    process = start(tmp_path / "out", "pass")
    try:
        with (
            pytest.raises(OutputError, match=f"process {process.pid} .* is writing into this"),
            claims.claimed(tmp_path / "out"),
        ):
            pass
    finally:
        process.kill()
        process.wait()
        assert process.stdout
        process.stdout.close()


def test_the_second_thread_is_refused(tmp_path: Path) -> None:
    said: list[str] = []

    def claim() -> None:
        try:
            with claims.claimed(tmp_path):
                said.append("mine")
        except OutputError as error:
            said.append(error.message)

    with claims.claimed(tmp_path), claims.claimed(tmp_path):
        thread = threading.Thread(target=claim)
        thread.start()
        thread.join()
    assert len(said) == 1
    assert f"process {os.getpid()}" in said[0]


def test_nothing_stays_of_a_claim(tmp_path: Path) -> None:
    with claims.claimed(tmp_path / "a" / "b"):
        pass
    assert list((tmp_path / "a" / "b").iterdir()) == []
    with pytest.raises(ValueError, match="x"), claims.claimed(tmp_path / "c" / "d"):
        raise ValueError("x")
    assert not (tmp_path / "c").exists()


def test_a_killed_process_leaves_nothing_for_long(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write = "atomic.write_text(out / 'layers' / 'a.txt', 'a')\n    "
    begun = (
        "one = atomic.replacing(out / 'layers' / 'b.txt'); one.__enter__().write_text('b')\n    "
        "two = atomic.replacing_files(out); (two.__enter__() / 'c.txt').write_text('c')"
    )
    process = start(out, write + begun)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert process.stdout
    process.stdout.close()
    assert sum(unfinished.is_unfinished(path) for path in out.rglob("*")) == 3
    photos = out / "photos" / f".thesis.orusd-{GONE}-1f-0"
    photos.mkdir(parents=True)
    with claims.claimed(out) as kept:
        files = {path.relative_to(out).as_posix() for path in out.rglob("*")}
        mine = {path.relative_to(out).as_posix() for path in (photos.parent, photos)}
        assert files - mine == {".orusd.lock", ".orusd.sha256", "layers", "layers/a.txt"}
        assert photos.is_dir()
        assert kept.is_own(out / "layers" / "a.txt")


def test_the_folder_that_made_room_is_put_back(tmp_path: Path) -> None:
    old = tmp_path / f".view.orusd-{GONE}-1f-3.old"
    old.mkdir()
    (old / "a").write_text("a")
    unfinished.sweep(tmp_path)
    assert (tmp_path / "view" / "a").read_text() == "a"
    old.mkdir()
    unfinished.sweep(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["view"]


def test_only_remains_are_swept(tmp_path: Path) -> None:
    kept = [".a.1234.usda", ".a.orusd-x-1-1.usda", "a.orusd-1-1-1.usda", ".new-xyz", "a.txt"]
    kept.append(unfinished.beside(tmp_path / "b.txt").name)
    for name in kept:
        (tmp_path / name).write_text("")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "a").write_text("")
    (tmp_path / f".d.orusd-{GONE}-1f-0").symlink_to("elsewhere")
    (tmp_path / f".a.orusd-{GONE}-1f-0.usda").write_text("")
    # Of an earlier process that had the same number, as in a container.
    (tmp_path / f".c.orusd-{os.getpid()}-1f-0.usda").write_text("")
    unfinished.sweep(tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted([*kept, "elsewhere"])
    assert (tmp_path / "elsewhere" / "a").exists()


def test_the_ledger_is_what_sha256sum_reads(tmp_path: Path) -> None:
    with claims.claimed(tmp_path):
        atomic.write_text(tmp_path / "b" / "x y.txt", "b")
        atomic.write_text(tmp_path / "a" / "a.txt", "first")
        atomic.write_text(tmp_path / "a" / "a.txt", "a")
        atomic.write_text(tmp_path / "top.txt", "top")
    lines = (tmp_path / ledger.FILE).read_text().splitlines()
    assert [line[64:] for line in lines] == ["  a/a.txt", "  b/x y.txt", "  top.txt"]
    check = ["sha256sum", "--check", "--strict", ledger.FILE]
    assert subprocess.run(check, cwd=tmp_path, capture_output=True, check=False).returncode == 0


def test_only_what_was_written_is_removed(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with claims.claimed(out):
        for name in ("a", "changed", "link", "way/a"):
            atomic.write_text(out / "view" / name, "a")
    (out / "view" / "changed").write_text("mine")
    (out / "view" / "mine").write_text("a")
    (out / "view" / "link").unlink()
    (out / "view" / "link").symlink_to(tmp_path / "kept")
    (tmp_path / "kept").write_text("a")
    (out / "view" / "way").rename(tmp_path / "way")
    (out / "view" / "way").symlink_to(tmp_path / "way")
    with claims.claimed(out) as kept:
        stay = kept.remove([*kept.below(out / "view"), out / "view" / "mine"])
    assert [path.name for path in stay] == ["changed", "link", "a", "mine"]
    assert sorted(path.name for path in (out / "view").iterdir()) == [
        "changed",
        "link",
        "mine",
        "way",
    ]
    assert (tmp_path / "kept").read_text() == (tmp_path / "way" / "a").read_text() == "a"


@pytest.mark.parametrize("path", ["../a", "/a", "b/../../a", "", ".", "x/../../../a"])
def test_a_ledger_of_somebody_else_names_nothing_outside(path: str, tmp_path: Path) -> None:
    import hashlib

    out = tmp_path / "out"
    out.mkdir()
    (tmp_path / "a").write_text("a")
    line = f"{hashlib.sha256(b'a').hexdigest()}  {path}\n"
    (out / ledger.FILE).write_text(line + "nonsense\n" + "\0\n")
    with claims.claimed(out) as kept:
        assert kept.below(out) == []
    assert (tmp_path / "a").exists()


def test_a_folder_is_replaced_where_all_in_it_is_ours(tmp_path: Path) -> None:
    with claims.claimed(tmp_path):
        for text in ("one", "two"):
            with atomic.replacing_folder(tmp_path / "view") as beside:
                (beside / text).write_text(text)
    assert [path.name for path in (tmp_path / "view").iterdir()] == ["two"]
    (tmp_path / "view" / "notes.txt").write_text("mine")
    with (
        claims.claimed(tmp_path),
        pytest.raises(OutputError, match=r"'notes.txt' in it was not written"),
        atomic.replacing_folder(tmp_path / "view") as beside,
    ):
        (beside / "three").write_text("three")
    assert sorted(p.name for p in (tmp_path / "view").iterdir()) == ["notes.txt", "two"]
    assert not any(map(unfinished.is_unfinished, tmp_path.iterdir()))


def test_a_link_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "view").symlink_to(tmp_path / "elsewhere")
    with (
        claims.claimed(tmp_path / "out"),
        pytest.raises(OutputError, match="not a folder that this tool made"),
        atomic.replacing_folder(tmp_path / "out" / "view"),
    ):
        pass
    assert (tmp_path / "out" / "view").is_symlink()


@pytest.mark.slow
def test_the_lock_is_taken_by_one_of_many(tmp_path: Path) -> None:
    """Eight processes at once: at any moment one of them is inside, and each is at last."""
    code = (
        "import sys; from pathlib import Path\n"
        "from openrooms_usd import claims; from openrooms_usd.errors import OutputError\n"
        f"out = Path({str(tmp_path / 'out')!r}); inside = Path({str(tmp_path / 'inside')!r})\n"
        "taken = 0\n"
        "while taken < 10:\n"
        "    try:\n"
        "        with claims.claimed(out):\n"
        "            inside.touch(exist_ok=False); taken += 1; inside.unlink()\n"
        "    except OutputError as error:\n"
        "        assert 'is writing into this' in error.message, error.message\n"
    )
    crowd = [subprocess.Popen([sys.executable, "-c", code]) for _ in range(8)]
    assert [process.wait() for process in crowd] == [0] * 8


@pytest.mark.parametrize("name", [claims.FILE, ledger.FILE])
@pytest.mark.parametrize("kind", ["link", "broken link", "pipe", "folder"])
def test_a_lock_or_ledger_that_is_something_else(name: str, kind: str, tmp_path: Path) -> None:
    """Refused by its name: nothing is written through it, and nothing hangs."""
    out, kept = tmp_path / "out", tmp_path / "kept"
    out.mkdir()
    kept.write_text("mine")
    make: dict[str, Callable[[], object]] = {
        "link": lambda: (out / name).symlink_to(kept),
        "broken link": lambda: (out / name).symlink_to(tmp_path / "nowhere"),
        "pipe": lambda: os.mkfifo(out / name),
        "folder": lambda: (out / name).mkdir(),
    }
    make[kind]()
    with pytest.raises(OutputError, match=re.escape(name)), claims.claimed(out):
        atomic.write_text(out / "layers" / "a", "a")
    assert [path.name for path in out.iterdir()] == [name]
    assert kept.read_text() == "mine"
    assert not (tmp_path / "nowhere").exists()


def test_a_file_of_others_is_no_lock(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / claims.FILE).write_text("a thesis")
    with pytest.raises(OutputError, match="not a lock file"), claims.claimed(tmp_path / "out"):
        pass
    assert (tmp_path / "out" / claims.FILE).read_text() == "a thesis"


def test_a_copy_by_links_keeps_its_ledger(tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    with claims.claimed(first):
        atomic.write_text(first / "layers" / "a", "a")
    shutil.copytree(first, second, copy_function=os.link)
    before = (first / ledger.FILE).read_bytes()
    with claims.claimed(second):
        atomic.write_text(second / "layers" / "b", "b")
    assert (first / ledger.FILE).read_bytes() == before
    assert len((second / ledger.FILE).read_text().splitlines()) == 2


def test_filling_spares_what_is_no_file(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    os.mkfifo(tmp_path / "out" / "b")
    with (
        pytest.raises(OutputError, match="a pipe, and will not be replaced"),
        atomic.replacing_files(tmp_path / "out") as beside,
    ):
        (beside / "a").write_text("a")
        (beside / "b").write_text("b")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["b"]


def test_a_folder_that_no_disk_can_have_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="too long"), claims.locked(tmp_path / ("x" * 300)):
        pass


def test_files_that_say_the_same_stay_and_others_stop_all(tmp_path: Path) -> None:
    """Where a room was copied without its ledger, as by a version control."""
    for name in ("a.txt", "b.txt"):
        (tmp_path / name).write_text("same")
    with claims.claimed(tmp_path), atomic.replacing_files(tmp_path) as beside:
        for name in ("a.txt", "b.txt", "c.txt"):
            (beside / name).write_text("same")
    before = {path: path.read_text() for path in tmp_path.glob("*.txt")}
    assert len(before) == 3
    with (
        pytest.raises(OutputError, match="not as an earlier run wrote it") as refused,
        claims.claimed(tmp_path),
        atomic.replacing_files(tmp_path) as beside,
    ):
        for name in ("b.txt", "c.txt", "d.txt"):
            (beside / name).write_text("other")
    assert refused.value.place == str(tmp_path / "b.txt")
    assert {path: path.read_text() for path in tmp_path.glob("*.txt")} == before


@pytest.mark.parametrize("name", ["a\\b.glb", "a\nb.glb"])
def test_a_name_that_no_ledger_holds_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="choose another output"), claims.output(tmp_path / name):
        atomic.write_text(tmp_path / name, "x")
    assert not list(tmp_path.iterdir())
