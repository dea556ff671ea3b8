"""Seconds of ``orusd compose``: halls of ever more objects, and a furnished room with small things.

Halls: cold composes into an empty folder; warm composes the same description again, which does
nothing. Rooms: a generated living room into an empty folder, cold with an empty cache, warm with
one that holds what the cold run has made. All are whole processes, start-up included; processor
seconds are those of all their threads.
"""

import os
import resource
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import click

from benchmarks.report import publish, table
from benchmarks.scenes import hall, orusd

_CLUTTER: Final = (0, 3)
_SEED: Final = 1


@click.command(help=__doc__)
@click.option("--objects", type=int, multiple=True, default=(10, 100, 1_000, 10_000))
@click.option("--quick", is_flag=True, help="A hall of ten objects only.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(objects: tuple[int, ...], quick: bool, target: Path | None) -> None:
    counts = (10,) if quick else objects
    rows = []
    for count in counts:
        with tempfile.TemporaryDirectory() as folder:
            rows.append({"objects": count, **measure(Path(folder), count)})
    markdown = table(
        ("objects", "cold s", "warm s", "MB on disk"), [list(row.values()) for row in rows]
    )
    rooms = []
    for clutter in () if quick else _CLUTTER:
        with tempfile.TemporaryDirectory() as folder:
            rooms.append({"clutter": clutter, **measure_room(Path(folder), clutter)})
    if rooms:
        heads = ("clutter", "cold s", "cold processor s", "warm s", "warm processor s")
        markdown += "\n" + table(heads, [list(row.values()) for row in rooms])
    publish("compose", {"rows": rows, "rooms": rooms}, markdown, target)


def measure(folder: Path, objects: int) -> dict[str, float]:
    """Compose a hall twice."""
    room, out = folder / "room.yaml", folder / "out"
    room.write_text(hall(objects))
    seconds = [_composed(room, out)[0] for _ in range(2)]
    size = sum(path.stat().st_size for path in out.rglob("*") if path.is_file())
    return {"cold_s": seconds[0], "warm_s": seconds[1], "disk_MB": size / 1e6}


def measure_room(folder: Path, clutter: int) -> dict[str, float]:
    """Compose a living room with an empty cache, then with a full one."""
    orusd("generate", "--type", "living_room", "--seed", _SEED, "--clutter", clutter, "-o", folder)
    env = {**os.environ, "ORUSD_CACHE": str(folder / "cache")}
    cold, warm = (_composed(folder / "room.yaml", folder / name, env) for name in ("a", "b"))
    return {
        "cold_s": cold[0],
        "cold_processor_s": cold[1],
        "warm_s": warm[0],
        "warm_processor_s": warm[1],
    }


def _composed(room: Path, out: Path, env: Mapping[str, str] | None = None) -> tuple[float, float]:
    """Seconds on the clock, and of processors."""
    began, used = time.perf_counter(), _used()
    orusd("compose", room, "-o", out, env=env)
    return time.perf_counter() - began, _used() - used


def _used() -> float:
    """Processor seconds of the processes that this one has started and that have ended."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return children.ru_utime + children.ru_stime


if __name__ == "__main__":
    main()
