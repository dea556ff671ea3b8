"""Seconds of ``orusd compose`` against the number of objects, cold and warm.

Cold composes into an empty folder; warm composes the same description again, which does nothing.
Both are whole processes, start-up included.
"""

import tempfile
import time
from pathlib import Path

import click

from benchmarks.report import publish, table
from benchmarks.scenes import hall, orusd


@click.command(help=__doc__)
@click.option("--objects", type=int, multiple=True, default=(10, 100, 1_000, 10_000))
@click.option("--quick", is_flag=True, help="Ten objects only.")
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
    publish("compose", {"rows": rows}, markdown, target)


def measure(folder: Path, objects: int) -> dict[str, float]:
    """Compose a hall twice."""
    room, out = folder / "room.yaml", folder / "out"
    room.write_text(hall(objects))
    seconds = []
    for _ in range(2):
        began = time.perf_counter()
        orusd("compose", room, "-o", out)
        seconds.append(time.perf_counter() - began)
    size = sum(path.stat().st_size for path in out.rglob("*") if path.is_file())
    return {"cold_s": seconds[0], "warm_s": seconds[1], "disk_MB": size / 1e6}


if __name__ == "__main__":
    main()
