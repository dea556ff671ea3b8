"""One view with all files of the OpenRooms release, by the command that anybody would type."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from benchmarks.light.pictures import Section, Setting, section
from benchmarks.light.rooms import ROOMS, Room
from benchmarks.light.sessions import Target, methods_of
from benchmarks.scenes import ORUSD, demo_stage
from openrooms_usd.channels import definition

_SAMPLES: Final = 16
_CAMERA: Final = "dining"
_ESTIMATES: Final = {
    "worst relative MSE": "estimated_error",
    "worst robust": "estimated_robust_error",
}


def view(setting: Setting) -> Section:
    """A complete view of the example by the command line: seconds, memory, the worst errors."""
    stage = demo_stage(setting.folder)
    resolution, grid = ("64x48", "8x6") if setting.quick else ("640x480", "160x120")
    rows = []
    for method in methods_of(Room(ROOMS["plain"].build(setting.folder), 4, 3)):
        target = setting.folder / f"view_{method}"
        ran = run(
            *ORUSD,
            "render",
            stage,
            "-o",
            target,
            "--camera",
            _CAMERA,
            "--channels",
            "all",
            "--dataset",
            target.with_suffix(".openrooms"),
            "--resolution",
            resolution,
            "--grid",
            grid,
            "--spp",
            _SAMPLES,
            "--method",
            method,
        )
        rows.append(
            {
                "method": method,
                "samples": _SAMPLES,
                "s of all cores": ran.seconds,
                "s by the clock": ran.elapsed,
                "peak GiB": ran.peak_gib,
            }
            | _worst(target)
        )
    return section(
        rows,
        [
            Target("a complete view, s by the clock", 60.0, rows[-1]["s by the clock"]),
            Target(
                "its worst channel of light, estimated robust error", 0.01, rows[-1]["worst robust"]
            ),
        ],
    )


def _worst(target: Path) -> dict[str, Any]:
    """The channels of light whose estimated errors are largest, from the manifest."""
    manifest = json.loads((target / "manifest.json").read_text())
    (shown,) = manifest["views"].values()
    found: dict[str, Any] = {"lights": len(manifest["lights"])}
    for title, figure in _ESTIMATES.items():
        errors = {
            name: entry[figure] or 0.0
            for name, entry in shown["channels"].items()
            if figure in entry and definition(name).kind == "light"
        }
        worst = max(errors, key=lambda name: errors[name], default=None)
        found |= {title: worst and errors[worst], f"{title}: of": worst}
    return found


# Commands in processes of their own: what they take, and how much memory they had at most.

# A small process in between: what a process had at most, Linux begins with what its parent holds.
_MEASURED: Final = """
import os, sys, time
began = time.perf_counter()
child = os.posix_spawnp(sys.argv[1], sys.argv[1:], os.environ)
_, status, used = os.wait4(child, 0)
print(used.ru_utime + used.ru_stime, time.perf_counter() - began, used.ru_maxrss)
sys.exit(status != 0)
"""


@dataclass(frozen=True)
class Ran:
    """A finished process.

    Attributes:
        seconds: Of all cores.
        elapsed: By the clock.
        peak_gib: The most memory that it had at once.
        said: What it printed.
    """

    seconds: float
    elapsed: float
    peak_gib: float
    said: str


def run(*words: object, **environment: str) -> Ran:
    """Run a command and wait for it.

    Raises:
        SystemExit: It failed; with what it said.
    """
    command = [sys.executable, "-S", "-c", _MEASURED, *map(str, words)]
    done = subprocess.run(
        command, capture_output=True, text=True, env={**os.environ, **environment}, check=False
    )
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, words))} failed:\n{done.stderr}{done.stdout}")
    said, _, figures = done.stdout.rstrip().rpartition("\n")
    seconds, elapsed, most = map(float, figures.split())
    # Linux counts in KiB, macOS in bytes.
    peak = most * (1 if sys.platform == "darwin" else 1024)
    return Ran(seconds, elapsed, peak / 2**30, said)
