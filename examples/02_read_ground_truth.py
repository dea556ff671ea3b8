"""Read a render back: back-project depth to points and compare them with the position channel.

Run: python examples/02_read_ground_truth.py OUT
"""

import json
import sys
from pathlib import Path

import numpy as np

from openrooms_usd import compose_room, render_stage
from openrooms_usd.demo import copy_example
from openrooms_usd.render.exr import read_channels


def main(out: Path) -> None:
    scene = compose_room(copy_example(out / "source"), out).scene
    render_stage(
        scene,
        out / "render",
        cameras=["sitting"],
        channels=["depth", "position", "valid"],
        resolution=(160, 120),
        samples=1,
    )
    view = json.loads((out / "render" / "manifest.json").read_text())["views"]["sitting"]
    channels = read_channels(out / "render" / view["files"]["channels"])

    # The manifest says: K in pixels, the centre of the top-left pixel at (0.5, 0.5), OpenCV axes.
    width, height = view["resolution"]
    columns, rows = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    pixels = np.stack([columns, rows, np.ones_like(rows)], axis=-1)
    rays = pixels @ np.linalg.inv(np.array(view["K"])).T
    camera = np.array(view["world_from_camera"])
    points = (rays * channels["depth"]) @ camera[:3, :3].T + camera[:3, 3]

    seen = channels["valid"][..., 0] > 0
    error = np.abs(points - channels["position"])[seen].max()
    print(f"{seen.sum()} pixels see a surface; depth and position agree within {error:.1e} m")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/example_02"))
