"""Read a render back: back-project depth to points and compare them with the position channel.

Run: python examples/02_read_ground_truth.py OUT
"""

import sys
from pathlib import Path

import numpy as np

import openrooms_usd as ou


def main(out: Path) -> None:
    scene = ou.compose(ou.copy_example(out / "source"), out)
    render = ou.render(
        scene,
        cameras="sitting",
        channels=["depth", "position", "valid"],
        resolution=(160, 120),
        samples=1,
    )
    view = render["sitting"]

    # K is in pixels, the centre of the top-left pixel at (0.5, 0.5); the camera has OpenCV axes.
    columns, rows = np.meshgrid(np.arange(view.width) + 0.5, np.arange(view.height) + 0.5)
    pixels = np.stack([columns, rows, np.ones_like(rows)], axis=-1)
    rays = pixels @ np.linalg.inv(view.K).T
    camera = view.world_from_camera
    points = (rays * view["depth"][..., None]) @ camera[:3, :3].T + camera[:3, 3]

    seen = view["valid"]
    error = np.abs(points - view["position"])[seen].max()
    print(f"{seen.sum()} pixels see a surface; depth and position agree within {error:.1e} m")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/example_02"))
