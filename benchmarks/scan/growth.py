"""How time and memory grow with the number of points: each size in a process of its own."""

import json
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.scan.built import Hole, Placed, built
from benchmarks.scan.rooms import SimulatedRoom
from benchmarks.scan.symmetry import surface_samples
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.thinning import clean
from openrooms_usd.scan.reconstruction import find_rooms

SIZES: Final = (10_000, 100_000, 300_000, 1_000_000, 10_000_000)
QUICK_SIZES: Final = (10_000, 100_000)
NOISE: Final = 0.005


def growth(quick: bool) -> list[dict[str, Any]]:
    """One row for each number of points: seconds and the peak of memory."""
    return [_apart(size) for size in (QUICK_SIZES if quick else SIZES)]


def _apart(size: int) -> dict[str, Any]:
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.scan.growth", str(size)],
        cwd=Path(__file__).parents[2], capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode:
        raise SystemExit(f"{size} points failed:\n{done.stderr}")
    row: dict[str, Any] = json.loads(done.stdout)
    return row


def _room() -> SimulatedRoom:
    holes = (Hole(0, 1.0, 0.9, 0.0, 2.0), Hole(2, 2.0, 1.6, 0.9, 2.1, "window"))
    places = [(x, y) for x in (1.2, 3.0, 4.8, 6.6) for y in (1.2, 3.0, 4.8)]
    names = ("table", "chair", "cabinet", "shelf")
    things = [Placed(names[i % 4], (x, y, 0), 25.0 * i) for i, (x, y) in enumerate(places)]
    outline = ((0, 0), (8, 0), (8, 6), (3, 6), (3, 5.9), (0, 5.9))
    return built(outline, holes=holes, things=things)


def sampled(size: int) -> Cloud:
    """Points that are uniform on the surfaces of a furnished room, 5 mm off."""
    room = _room()
    random = np.random.default_rng(size)
    a, b, c = np.moveaxis(room.points[room.triangles], 1, 0)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    counts = random.multinomial(size, areas / areas.sum())
    points = np.concatenate(
        [
            surface_samples(room.points, room.triangles[i : i + 1], count, random)
            for i, count in enumerate(counts)
            if count
        ]
    )
    points += random.normal(0.0, NOISE, points.shape)
    part = np.repeat(room.part, counts)
    label, instance = (
        np.array([getattr(p, key) for p in room.parts], np.int32)[part]
        for key in ("label", "instance")
    )
    return Cloud(points, label=label, instance=instance)


def measured(size: int) -> dict[str, Any]:
    """Seconds from points to rooms, and the peak of this process's memory."""
    cloud = sampled(size)
    before = _peak()
    began, worked = time.perf_counter(), time.process_time()
    rooms = find_rooms(clean(cloud)[0]).rooms
    seconds, cpu = time.perf_counter() - began, time.process_time() - worked
    return {
        "points": size, "rooms": len(rooms), "seconds": seconds, "cpu_s": cpu,
        "memory_MB": _peak(), "cloud_MB": before,
    }  # fmt: skip


def _peak() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


if __name__ == "__main__":
    print(json.dumps(measured(int(sys.argv[1]))))
