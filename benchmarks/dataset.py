"""Datasets: views an hour against their error, and what the runner adds.

The first table runs one dataset of generated rooms for each number of samples. Seconds are of the
clock; those of a phase are what workers measured, so with one worker what is left over is the
runner's: planning, records, checksums, manifests, the index, and starting: the command, a worker
and all that it imports. Starting is measured by a dataset of one room that cannot be described.

The second table puts the same runs beside two published ones, pixel by pixel: OpenRooms' 700 s a
view of 640x480 on one GPU (600 s and 100 s for its environment maps), by the clock; and Hypersim's
26.2 hours of virtual cores a view of 1024x768, by the processor time of all processes, where an
hour of a virtual core counts as one of ours. Neither publishes an error: ours stands beside it.
"""

import json
import resource
import statistics
import tempfile
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import click

from benchmarks.report import publish, table
from benchmarks.scenes import orusd

# Of a pixel: seconds of the clock of one GPU (RTX 2080 Ti), and of a virtual core.
PAPER_S: Final = 700.0 / (640 * 480)
HYPERSIM_CORE_S: Final = 26.2 * 3600.0 / (1024 * 768)

PHASES: Final = ("compose", "translation", "render", "output")
POISONED: Final = "room: nowhere\n"
# What all views of a job share; the rest each view has for itself.
_SHARED: Final = frozenset({"compose", "translation"})


@click.command(help=__doc__)
@click.option("--types", default="living_room,bedroom,kitchen", show_default=True)
@click.option("--rooms", type=int, default=3, show_default=True)
@click.option("--views", type=int, default=3, show_default=True, help="Of each room.")
@click.option("--size", type=(int, int), default=(640, 480), show_default=True)
@click.option("--channels", default="all", show_default=True)
@click.option("--samples", type=int, multiple=True, default=(16, 64), show_default=True)
@click.option("--workers", type=int, default=1, show_default=True)
@click.option("--quick", is_flag=True, help="One small room.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(
    types: str,
    rooms: int,
    views: int,
    size: tuple[int, int],
    channels: str,
    samples: tuple[int, ...],
    workers: int,
    quick: bool,
    target: Path | None,
) -> None:
    if quick:
        types, rooms, views, size, samples = "bathroom", 1, 2, (64, 48), (4,)
        channels = "usual"
    wanted: dict[str, Any] = {
        "rooms": [{"types": types.split(","), "count": rooms}],
        "views": {"count": views, "resolution": list(size)},
        "channels": channels.split(","),
    }
    with tempfile.TemporaryDirectory() as folder:
        runs = [measure(Path(folder), wanted, count, workers) for count in samples]
    pixels = size[0] * size[1]
    beside = [compared(run, pixels) for run in runs]
    heads = (
        "samples",
        "robust error",
        "views an hour",
        "s a view",
        "MB a view",
        *PHASES,
        "starting s",
        "runner % besides",
        "processor s a view",
    )
    other_heads = (
        "samples",
        "robust error",
        "us a pixel",
        "OpenRooms', times as long",
        "core-us a pixel",
        "Hypersim's, times as long",
    )
    markdown = table(heads, [list(row.values()) for row in runs])
    others = table(other_heads, [list(row.values()) for row in beside])
    numbers = {"runs": runs, "beside_others": beside}
    publish("dataset", numbers, f"{markdown}\n\n{others}", target)


def measure(folder: Path, wanted: dict[str, Any], samples: int, workers: int) -> dict[str, Any]:
    """Make a dataset, and see where the time went."""
    # JSON is YAML.
    file, out = folder / f"{samples}.yaml", folder / f"out_{samples}"
    file.write_text(json.dumps({**wanted, "budget": {"samples": samples}}))
    words = ("dataset", "run", file, "-o", out, "--workers", workers)
    (folder / "room.yaml").write_text(POISONED)
    (folder / "poisoned.yaml").write_text("rooms: [{files: [room.yaml]}]\nretries: 0\n")
    starting = _timed("dataset", "run", folder / "poisoned.yaml", "-o", folder / f"none_{samples}")
    before = _processor_seconds()
    whole = _timed(*words)
    processor = _processor_seconds() - before
    phases: Counter[str] = Counter()
    for room in sorted((out / "timing").glob("*/*")):
        rows = [json.loads(path.read_text()) for path in sorted(room.glob("*.json"))]
        for phase in PHASES:
            phases[phase] += sum(row[phase] for row in rows[: 1 if phase in _SHARED else None])
    lines = (out / "index.jsonl").read_text().splitlines()
    errors = [json.loads(line)["errors"].get("radiance", 0.0) for line in lines]
    size = sum(p.stat().st_size for p in (out / "renders").rglob("*") if p.is_file())
    count = len(lines)
    return {
        "samples": samples,
        "error": statistics.median(errors),
        "views_an_hour": 3600.0 * count / whole,
        "s_a_view": whole / count,
        "MB_a_view": size / count / 1e6,
        **{f"{phase}_s": phases[phase] / count for phase in PHASES},
        "starting_s": starting,
        # With more workers some wait for the last one: that is theirs.
        "runner_percent": 100.0 * (1.0 - (starting + sum(phases.values()) / workers) / whole),
        "processor_s_a_view": processor / count,
    }


def compared(run: dict[str, Any], pixels: int) -> dict[str, Any]:
    """A run beside published ones, by the pixel; how many times longer those take.

    Args:
        run: What `measure` gave.
        pixels: Of a view.
    """
    clock, core = run["s_a_view"] / pixels, run["processor_s_a_view"] / pixels
    return {
        "samples": run["samples"],
        "error": run["error"],
        "us_a_pixel": 1e6 * clock,
        "paper_times": PAPER_S / clock,
        "core_us_a_pixel": 1e6 * core,
        "hypersim_times": HYPERSIM_CORE_S / core,
    }


def _processor_seconds() -> float:
    """Of all processes that this one began and that have ended, and of theirs."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _timed(*words: object) -> float:
    began = time.perf_counter()
    with suppress(SystemExit):
        orusd(*words)
    return time.perf_counter() - began


if __name__ == "__main__":
    main()
