"""Runs the program on a capture as a newcomer would, and keeps what it wrote and said."""

import json
import os
import shutil
import subprocess
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.real.captures import Change, Run
from openrooms_usd.arrays import Ints

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


# The same scan without its labels, lying on its side, or in millimetres: another PLY file.

# Z up to Y up: x stays, what was up is y.
ON_ITS_SIDE: Final = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
_COLORS: Final = ("red", "green", "blue")


def variant(source: Path, change: Change, target: Path) -> None:
    """Write the points (and triangles) of a scan anew, without what says what they are.

    Args:
        source: Any scan that `orusd import scan` reads.
        change: What is done to it, beside.
        target: A PLY file.
    """
    from orusd_scans.plainscan import read_scanned

    scanned = read_scanned(source)
    cloud = scanned.cloud
    points = cloud.points * (1000.0 if change == "millimetres" else 1.0)
    turn = ON_ITS_SIDE if change == "on its side" else np.eye(3)
    places = points @ turn.T
    columns: dict[str, NDArray[Any]] = {name: places[:, k] for k, name in enumerate("xyz")}
    if cloud.normals is not None:
        normals = cloud.normals @ turn.T
        columns |= {f"n{name}": normals[:, k] for k, name in enumerate("xyz")}
    if cloud.colors is not None:
        columns |= {name: cloud.colors[:, k] for k, name in enumerate(_COLORS)}
    write_ply(target, columns, scanned.faces)


def write_ply(target: Path, columns: Mapping[str, NDArray[Any]], faces: Ints | None = None) -> None:
    """A binary PLY file: bytes stay bytes, all else becomes float (places: double)."""
    kinds = {
        name: "u1" if values.dtype == np.uint8 else "<f8" if name in "xyz" else "<f4"
        for name, values in columns.items()
    }
    count = len(next(iter(columns.values())))
    rows = np.zeros(count, dtype=list(kinds.items()))
    for name, values in columns.items():
        rows[name] = values
    words = {"u1": "uchar", "<f4": "float", "<f8": "double"}
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {count}"]
    lines += [f"property {words[kind]} {name}" for name, kind in kinds.items()]
    body = rows.tobytes()
    if faces is not None:
        lines += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
        polygons = np.zeros(len(faces), dtype=[("n", "u1"), ("rows", "<i4", 3)])
        polygons["n"], polygons["rows"] = 3, faces
        body += polygons.tobytes()
    target.write_bytes("\n".join([*lines, "end_header", ""]).encode() + body)
