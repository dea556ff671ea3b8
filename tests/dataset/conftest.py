"""A small dataset: rooms that compose in a moment, and one that cannot be composed at all."""

import hashlib
import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from benchmarks.scenes import SMALL_ROOM

POISONED = SMALL_ROOM.replace("category: chair", "category: chiar")
DATASET = """\
name: small
seed: 5
rooms:
  - files: [good/room.yaml, poisoned/room.yaml]
views: {count: 2, resolution: [24, 18]}
variants: [main, mainDiffMat]
channels: [radiance, depth, instance, valid]
budget: {samples: 2}
rendering: {renderer: preview}
retries: 0
"""


PATIENCE_S = 300.0
MAIN = "from openrooms_usd.cli import main; main()"


Start = Callable[..., subprocess.Popen[str]]
Made = tuple[Path, Path]
Checksums = Callable[[Path], dict[str, str]]


def start(file: Path, out: object, workers: int = 1, *words: str) -> subprocess.Popen[str]:
    """Begin a run in a process of its own."""
    command = [sys.executable, "-c", MAIN, "dataset", "run", str(file), "-o", str(out), "--json"]
    command += ["--workers", str(workers), *words]
    pipe = subprocess.PIPE
    # A shell's background jobs ignore Ctrl-C, and so would what they start.
    heeding = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, preexec_fn=heeding)


def wait_for(process: subprocess.Popen[str], out: Path, pattern: str) -> None:
    """Wait until a run has written something."""
    deadline = time.monotonic() + PATIENCE_S
    while not any(out.glob(pattern)):
        assert process.poll() is None and time.monotonic() < deadline, pattern
        time.sleep(0.002)


@pytest.fixture(scope="session", name="start")
def start_fixture() -> Callable[..., subprocess.Popen[str]]:
    return start


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The dataset.yaml, and what an undisturbed run of one worker made of it."""
    folder = tmp_path_factory.mktemp("made")
    file, out = write_source(folder / "source"), folder / "out"
    process = start(file, out)
    said, wrong = process.communicate()
    assert process.returncode == 1, wrong
    done = json.loads(said)
    assert (done["made"], len(done["failed"])) == (4, 4)
    return file, out


@pytest.fixture
def source(tmp_path: Path) -> Path:
    """The dataset.yaml, with its rooms beside it."""
    return write_source(tmp_path / "source")


@pytest.fixture(scope="session", name="write_source")
def write_source_fixture() -> Callable[[Path], Path]:
    return write_source


def write_source(folder: Path) -> Path:
    for name, text in (("good", SMALL_ROOM), ("poisoned", POISONED)):
        (folder / name).mkdir(parents=True)
        (folder / name / "room.yaml").write_text(text)
    (folder / "dataset.yaml").write_text(DATASET)
    return folder / "dataset.yaml"


@pytest.fixture(scope="session")
def checksums() -> Callable[[Path], dict[str, str]]:
    """Of all files of a dataset but times, failures, and lists of what may be removed again."""

    def of(root: Path) -> dict[str, str]:
        return {
            path.relative_to(root).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(root.rglob("*"))
            if path.is_file()
            and not path.name.startswith(".orusd.")
            and path.relative_to(root).parts[0] not in ("timing", "failures")
        }

    return of
