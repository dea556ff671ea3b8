"""The stages that benchmarks render, composed on the fly."""

import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

ORUSD = (sys.executable, "-c", "from openrooms_usd.cli import main; main()")

SMALL_ROOM: Final = """\
name: small
room: office
seed: 3
layout:
  polygon: [[0, 0], [4, 0], [4, 3], [0, 3]]
  openings:
    - {kind: window, wall: 0}
furniture:
  objects:
    - {category: chair, at: [1.5, 0.8], yaw: 180 deg}
    - {category: ceiling_lamp, at: [2, 1.5]}
materials: {resolution: 16}
"""
"""A room that composes in a moment: small textures, two objects."""

SMALL_ROOM_CAMERAS: Final = """\
cameras:
  resolution: [16, 12]
  views:
    - {name: left, eye: [0.5, 0.5, 1.5], target: [2, 1.5, 1]}
    - {name: right, eye: [3.5, 0.5, 1.5], target: [2, 1.5, 1]}
"""


def orusd(*words: object, env: Mapping[str, str] | None = None) -> None:
    """Run the command line in a process of its own, without a word unless it fails.

    Raises:
        SystemExit: It failed; with what it said.
    """
    done = subprocess.run(
        [*ORUSD, *map(str, words)], capture_output=True, text=True, env=env, check=False
    )
    if done.returncode:
        raise SystemExit(f"orusd {' '.join(map(str, words))} failed:\n{done.stderr}{done.stdout}")


def demo_stage(folder: Path) -> Path:
    """Compose the bundled example and return its stage."""
    from openrooms_usd.demo import copy_example

    orusd("compose", copy_example(folder / "source"), "-o", folder / "demo")
    return folder / "demo" / "scene.usda"


def hall(objects: int) -> str:
    """A description with a number of chairs and tables on a grid in a hall that holds them."""
    columns = max(2, round(objects**0.5))
    rows = -(-objects // columns)
    width, depth = 1.5 * columns + 1, 1.5 * rows + 1
    placed = "\n".join(
        f"    - {{category: {'table' if index % 5 == 0 else 'chair'}, "
        f"size: {_size(index)}, at: [{1.25 + 1.5 * (index % columns)}, "
        f"{1.25 + 1.5 * (index // columns)}], yaw: {37 * index % 360}}}"
        for index in range(objects)
    )
    return (
        "name: hall\nseed: 1\nlayout:\n  from: polygon\n"
        f"  polygon: [[0, 0], [{width}, 0], [{width}, {depth}], [0, {depth}]]\n"
        f"furniture:\n  objects:\n{placed}\n"
    )


def _size(index: int) -> Sequence[float]:
    # Ten sizes: most objects are repeats of one asset, as they are in a real hall.
    return [0.5 + 0.01 * (index % 10)] * 2 + [0.8]
