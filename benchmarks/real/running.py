"""Runs the program on a capture as a newcomer would, and keeps what it wrote and said."""

import json
import os
import shutil
import subprocess
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

from benchmarks.real.captures import Run
from benchmarks.real.variants import variant

# Letters that are kept of what was said, and of that in a refusal.
_SAID: Final = 20_000
_REFUSAL: Final = 300
_ONE_THREAD: Final = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")


@dataclass(frozen=True)
class Outcome:
    """What a run left.

    Attributes:
        folder: The composed room; whether it is there says whether the run went through.
        said: The end of what the commands said.
        seconds: Import and compose together.
        late: They were stopped.
    """

    folder: Path
    said: str
    seconds: float
    late: bool = False

    @property
    def refusal(self) -> str | None:
        """What was said against it; None where a room was composed."""
        if (self.folder / "scene.usda").exists():
            return None
        lines = [line.strip() for line in self.said.splitlines() if line.strip()]
        if "Traceback (most recent call last):" in lines:
            return f"crashed: {lines[-1]}"[:_REFUSAL]
        kept = [line for line in lines if "error" in line or "remedy" in line]
        return " ".join(kept)[:_REFUSAL] or "nothing was composed, and nothing was said"


def outcome_of(run: Run, base: Path, tool: Sequence[str], timeout: float, reuse: bool) -> Outcome:
    """Import and compose one run of a capture.

    Args:
        run: Of the capture.
        base: A folder for it; what is in it is removed, unless it is used again.
        tool: The words of the ``orusd`` command.
        timeout: Seconds for both commands together.
        reuse: Take what an earlier run left there.
    """
    log, out = base / "outcome.json", base / "out"
    if reuse and log.exists():
        kept = json.loads(log.read_text(encoding="utf-8"))
        return Outcome(out, kept["said"], kept["seconds"], kept["late"])
    shutil.rmtree(base, ignore_errors=True)
    base.mkdir(parents=True)
    words = list(run.words)
    if run.change:
        variant(Path(words[1]), run.change, base / "scan.ply")
        words = ["scan", str(base / "scan.ply")]
    begin = time.monotonic()
    said, late = "", False
    for command in (
        ["import", *words, "-o", str(base / "room")],
        ["compose", str(base / "room" / "room.yaml"), "-o", str(out)],
    ):
        if command[0] == "compose" and run.partial:
            _tell_partial(base / "room" / "room.yaml")
        left = max(1.0, timeout - (time.monotonic() - begin))
        code, text = _run([*tool, *command], base, left)
        said, late = said + text, code is None
        if code != 0:
            break
    outcome = Outcome(out, said[-_SAID:], round(time.monotonic() - begin, 1), late)
    log.write_text(json.dumps({**asdict(outcome), "folder": str(out)}), encoding="utf-8")
    return outcome


def _run(command: Sequence[str], folder: Path, seconds: float) -> tuple[int | None, str]:
    """Exit code and words of a command; no code where it was stopped."""
    env = {**os.environ, **_ONE_THREAD}
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            timeout=seconds,
            env=env,
            cwd=folder,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return None, f"error: stopped after {seconds:.0f} s\n"
    return done.returncode, done.stdout + done.stderr


def _tell_partial(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("from: scan", "partial: true\n  from: scan", 1), encoding="utf-8")
