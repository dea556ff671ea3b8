"""The command line as a user meets it, and what must be true of every refusal."""

import json
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from benchmarks.scenes import SMALL_ROOM, SMALL_ROOM_CAMERAS
from tests.disks import disk

MAIN = "from openrooms_usd.cli import main; main()"

ROOM = f"{SMALL_ROOM}{SMALL_ROOM_CAMERAS}"
# Every layer and every texture of it differ from those of ROOM.
OTHER_ROOM = ROOM.replace("4, ", "5, ").replace("seed: 3", "seed: 4")

QUICK = ("--variant", "scalar", "--spp", "1", "--resolution", "16x12")


@dataclass(frozen=True)
class Outcome:
    """What a command said and left with."""

    code: int
    out: str
    err: str

    def refused(self, code: int, *fragments: str) -> None:
        """It failed as it should: one message with these words, a code, no traceback."""
        said = self.out + self.err
        assert "Traceback" not in said
        assert "pxrInternal" not in said
        assert "Warning: in " not in said
        assert self.code == code, said
        assert self.err.lower().count("error: ") == 1, self.err
        for fragment in fragments:
            assert fragment in self.err, self.err
        if self.out:
            json.loads(self.out)


@pytest.fixture
def orusd(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Callable[..., Outcome]:
    """Run a command in this process, through the function that the script calls."""
    from openrooms_usd.cli import main

    def call(*words: object) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["orusd", *map(str, words)])
        capfd.readouterr()
        try:
            main()
            code = 0
        except SystemExit as left:
            assert isinstance(left.code, int)
            code = left.code
        return Outcome(code, *capfd.readouterr())

    return call


def start(*words: object, largest_file: int | None = None) -> subprocess.Popen[str]:
    """Start a command in a process of its own; its files stay below a size in bytes."""

    def limit() -> None:
        # A shell's background jobs ignore Ctrl-C, and so would what they start.
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        if largest_file is not None:
            import resource  # not on Windows

            resource.setrlimit(resource.RLIMIT_FSIZE, (largest_file, largest_file))

    command = [sys.executable, "-c", MAIN, *map(str, words)]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, preexec_fn=limit)


def finish(process: subprocess.Popen[str]) -> Outcome:
    out, err = process.communicate(timeout=120)
    return Outcome(process.returncode, out, err)


def tree(folder: Path) -> dict[str, bytes | None] | None:
    """Every file and folder with its bytes; None where there is nothing."""
    if not folder.exists():
        return None
    return {
        path.relative_to(folder).as_posix(): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
    }


class Lab:
    """A room that was composed, packaged, rendered and converted, and the means to spoil it."""

    QUICK = QUICK
    OTHER_ROOM = OTHER_ROOM
    start = staticmethod(start)
    finish = staticmethod(finish)
    tree = staticmethod(tree)
    disk = staticmethod(disk)

    def __init__(self, folder: Path) -> None:
        self.room = folder / "room.yaml"
        self.other = folder / "other.yaml"
        self.composed = folder / "composed"
        self.rendered = folder / "rendered"
        self.converted = folder / "converted"
        self.scene = self.composed / "scene.usda"


@pytest.fixture(scope="session")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Lab:
    done = Lab(tmp_path_factory.mktemp("lab"))
    done.room.write_text(ROOM)
    done.other.write_text(OTHER_ROOM)
    for words in (
        ["compose", done.room, "-o", done.composed, "--flatten", "--usdz"],
        ["render", done.scene, "-o", done.rendered, *QUICK],
        ["convert", done.scene, done.converted],
    ):
        outcome = finish(start(*words))
        assert outcome.code == 0, outcome.err
        assert outcome.err == ""
    return done
