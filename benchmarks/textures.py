"""How fast the library's textures are made: megapixels a second on one core, by substance."""

import time
from pathlib import Path
from typing import Any, Final

import click
import numpy as np

from benchmarks.report import publish, table
from openrooms_usd.library.textures import FAMILIES, make

RESOLUTION: Final = 1024


def measured(resolution: int = RESOLUTION, number: int = 0) -> list[dict[str, Any]]:
    """For each family the processor's seconds for one set, all of its maps.

    Args:
        resolution: Texels along each side.
        number: Which material of each family.
    """
    rows = []
    for substance, families in FAMILIES.items():
        for name in families:
            started = time.process_time()
            make(name, number, resolution=resolution)
            seconds = time.process_time() - started
            rows.append({"substance": substance, "family": name, "seconds": seconds})
    return rows


def summary(rows: list[dict[str, Any]], resolution: int = RESOLUTION) -> list[dict[str, Any]]:
    """For each substance the megapixels a second, and the slowest family."""
    found = []
    for substance in FAMILIES:
        own = [row for row in rows if row["substance"] == substance]
        slowest = max(own, key=lambda row: row["seconds"])
        seconds = float(np.sum([row["seconds"] for row in own]))
        found.append(
            {
                "substance": substance,
                "families": len(own),
                "megapixels_per_s": len(own) * resolution**2 / 1e6 / seconds,
                "seconds_median": float(np.median([row["seconds"] for row in own])),
                "seconds_most": slowest["seconds"],
                "slowest": slowest["family"],
            }
        )
    return found


def textures(resolution: int = RESOLUTION) -> tuple[dict[str, Any], str]:
    """The numbers, and a table of them."""
    rows = measured(resolution)
    told = summary(rows, resolution)
    titles = ("substance", "families", "megapixel/s", "median s", "most s", "slowest")
    data = {"resolution": resolution, "substances": told, "families": rows}
    return data, table(titles, [list(row.values()) for row in told])


@click.command()
@click.option("--resolution", type=click.IntRange(16, 8192), default=RESOLUTION, show_default=True)
@click.option("-o", "--out", type=click.Path(path_type=Path))
def main(resolution: int, out: Path | None) -> None:
    """Make one set of every family; results/textures.json keeps the numbers."""
    publish("textures", *textures(resolution), out)


if __name__ == "__main__":
    main()
