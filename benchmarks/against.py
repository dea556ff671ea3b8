"""Two composed stages beside each other, each with its own code: seconds at equal error.

Both are rendered in one run, turn by turn, each in a process of its own, which counts the seconds
of the processor. The error is that of `benchmarks.radiance`, against a picture of the stage's own
with many more samples by full paths. What falls as one over the samples costs as much time as it is
large: so the ratio of the seconds times that of the errors is that of the seconds at equal error.

A room that was composed by other code is rendered by that code: give the folder of its checkout.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from statistics import median
from typing import Any, Final, Protocol

import click
import numpy as np

from benchmarks.report import publish, table
from openrooms_usd.render.estimates import relative_mse, robust_error

_SIDES: Final = ("before", "after")
_METHODS: Final = ("reference", "cache")
# What a checkout has on Python's path.
_ROOTS: Final = ("", "schemas", "converters")
# Renders what it is told, line by line; only with what checkouts of all ages have.
_WORKER: Final = """
import json, sys, time
from pathlib import Path
import numpy as np
from openrooms_usd import adapters
from openrooms_usd.render import RenderRequest
from openrooms_usd.render.opened import open_with
from openrooms_usd.usd.layers import open_stage
out, sys.stdout = sys.stdout, sys.stderr
job = json.loads(sys.stdin.readline())
renderer = adapters.load(adapters.RENDERERS, "mitsuba")
session = open_with(renderer, open_stage(Path(job["stage"])), {"variant": job["variant"]})
camera = job["camera"] or next(iter(session.cameras))
for line in sys.stdin:
    wanted = json.loads(line)
    request = RenderRequest(
        camera, ("radiance",), *job["resolution"], samples=wanted["samples"],
        seed=wanted["seed"], method=wanted["method"],
    )
    began = time.process_time()
    image = session.render(request).images["radiance"]
    seconds = time.process_time() - began
    np.save(wanted["file"], image.pixels)
    print(json.dumps(seconds), file=out, flush=True)
"""


@click.command(help=__doc__)
@click.option("--before", type=click.Path(path_type=Path, exists=True), required=True)
@click.option("--after", type=click.Path(path_type=Path, exists=True), required=True)
@click.option("--before-code", type=click.Path(path_type=Path, exists=True), help="Its checkout.")
@click.option("--camera", help="Its path; by default each stage's first.")
@click.option("--samples", default=32, show_default=True)
@click.option("--reference", default=1024, show_default=True, help="Its samples.")
@click.option("--rounds", default=3, show_default=True)
@click.option("--resolution", nargs=2, default=(320, 240), show_default=True)
@click.option("--variant", default="llvm", show_default=True)
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(
    before: Path,
    after: Path,
    before_code: Path | None,
    camera: str | None,
    samples: int,
    reference: int,
    rounds: int,
    resolution: tuple[int, int],
    variant: str,
    target: Path | None,
) -> None:
    job = {"camera": camera, "resolution": resolution, "variant": variant}
    with tempfile.TemporaryDirectory() as folder:
        sides = {
            "before": Side({**job, "stage": str(before)}, before_code, Path(folder, "before.npy")),
            "after": Side({**job, "stage": str(after)}, None, Path(folder, "after.npy")),
        }
        rows = compared(sides, samples, reference, rounds)
    titles = ("method", "seconds", "relative MSE", "robust", "first view, s")
    shown = [
        [row["method"], *(f"{row['before'][key]:.3g} -> {row['after'][key]:.3g}" for key in _SHOWN)]
        for row in rows
    ]
    ratios = table(
        ("method", "seconds at equal relative MSE", "at equal robust error"),
        [[row["method"], row["ratio"], row["robust_ratio"]] for row in rows],
    )
    publish("against", {"rows": rows}, f"{table(titles, shown)}\n\n{ratios}", target)


_SHOWN: Final = ("seconds", "relative_mse", "robust", "first_s")


class Side:
    """A process that renders one stage with the code of one checkout."""

    def __init__(self, job: dict[str, Any], code: Path | None, file: Path) -> None:
        env = dict(os.environ)
        if code is not None:
            env["PYTHONPATH"] = os.pathsep.join(str(code / root) for root in _ROOTS)
        self._file = file
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-c", _WORKER],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=env,
        )  # fmt: skip
        self._tell(job)

    def render(self, method: str, samples: int, seed: int) -> tuple[float, np.ndarray]:
        """Seconds of the processor, and the pixels."""
        self._tell({"method": method, "samples": samples, "seed": seed, "file": str(self._file)})
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise SystemExit("a renderer ended: its message stands above")
        return float(json.loads(line)), np.load(self._file)

    def _tell(self, what: dict[str, Any]) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(what) + "\n")
        self._process.stdin.flush()


class Renders(Protocol):
    """What gives a picture, and says how many seconds it took."""

    def render(self, method: str, samples: int, seed: int) -> tuple[float, np.ndarray]:
        """Seconds of the processor, and the pixels."""


def compared(
    sides: Mapping[str, Renders], samples: int, reference: int, rounds: int
) -> list[dict[str, Any]]:
    """For each method what both sides take, how far they are off, and the ratios."""
    truths = {name: side.render("reference", reference, 0)[1] for name, side in sides.items()}
    rows = []
    for method in _METHODS:
        # The first compiles, and fills the cache of light.
        first = {name: side.render(method, samples, 1)[0] for name, side in sides.items()}
        taken: dict[str, list[tuple[float, float, float]]] = {name: [] for name in sides}
        for turn in range(rounds):
            for name, side in sides.items():
                seconds, pixels = side.render(method, samples, turn + 2)
                truth = truths[name]
                taken[name].append(
                    (seconds, relative_mse(pixels, truth), robust_error(pixels, truth))
                )
        row: dict[str, Any] = {"method": method}
        for name, found in taken.items():
            seconds, error, robust = (median(column) for column in zip(*found, strict=True))
            row[name] = {"seconds": seconds, "relative_mse": error, "robust": robust,
                         "first_s": first[name]}  # fmt: skip
        old, new = (row[name] for name in _SIDES)
        for key, error in (("ratio", "relative_mse"), ("robust_ratio", "robust")):
            row[key] = new["seconds"] / old["seconds"] * new[error] / old[error]
        rows.append(row)
    return rows


if __name__ == "__main__":
    main()
