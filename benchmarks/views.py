"""Many pictures of one scene from Python: opening it, the first picture, and every other.

Beside them, at the same samples and the same error: the bare session of the renderer, which gets a
camera and gives pixels, and `ou.render`, which opens the scene and writes files every time.
"""

import tempfile
import time
from pathlib import Path
from typing import Any, Final

import click
import numpy as np

import openrooms_usd as ou
from benchmarks.report import publish, table
from benchmarks.scenes import demo_stage
from openrooms_usd.rendering.opening import open_for_rendering

CHANNELS: Final = ("radiance", "depth")
_TURN_M: Final = 0.02


@click.command(help=__doc__)
@click.option("--stage", type=click.Path(path_type=Path), help="By default the bundled example.")
@click.option("--samples", type=int, default=16, show_default=True)
@click.option("--pictures", type=int, default=8, show_default=True)
@click.option("--quick", is_flag=True, help="32x24 pixels, 2 samples and 3 pictures.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(stage: Path | None, samples: int, pictures: int, quick: bool, target: Path | None) -> None:
    size, samples, pictures = ((32, 24), 2, 3) if quick else ((320, 240), samples, pictures)
    with tempfile.TemporaryDirectory() as folder:
        scene = stage or demo_stage(Path(folder))
        rows = measure(scene, Path(folder), size, samples, pictures)
    markdown = table(
        ("what", "s", "over the bare session", "estimated error"),
        [
            (row["what"], row["seconds"], row["seconds"] / rows[-1]["seconds"], row["error"])
            for row in rows
        ],
    )
    publish("views", {"resolution": size, "samples": samples, "rows": rows}, markdown, target)


def measure(
    scene: Path, folder: Path, size: tuple[int, int], samples: int, pictures: int
) -> list[dict[str, Any]]:
    """Medians of the steps; the bare session comes last."""
    settings = ou.RenderSettings(
        channels=CHANNELS, samples=samples, resolution=size, method="reference"
    )
    began = time.perf_counter()
    renderer = ou.open_renderer(scene, settings=settings)
    rows = [{"what": "ou.open_renderer", "seconds": time.perf_counter() - began, "error": None}]
    began = time.perf_counter()
    first = renderer.render(renderer.cameras[0])
    steps: list[tuple[str, list[float], float | None]] = [
        ("first picture", [time.perf_counter() - began], first.error("radiance"))
    ]
    cameras = [
        ou.Camera(first.K, _moved(first.world_from_camera, k), size) for k in range(pictures)
    ]
    spent, error = [], None
    for camera in cameras:
        began = time.perf_counter()
        error = renderer.render(camera).error("radiance")
        spent.append(time.perf_counter() - began)
    steps.append(("every other", spent, error))
    spent = []
    for number in range(2):
        began = time.perf_counter()
        ou.render(scene, folder / f"files_{number}", settings=settings, cameras=renderer.cameras[0])
        spent.append(time.perf_counter() - began)
    steps.append(("ou.render, one view", spent, first.error("radiance")))
    context = open_for_rendering(scene, settings)
    spent, error = [], None
    for camera in cameras:
        request = context.request(camera.name, channels=("radiance",))
        began = time.perf_counter()
        image = context.session.render(camera.pinhole(), request, lambda done: None)["radiance"]
        spent.append(time.perf_counter() - began)
        error = image.robust_error
    steps.append(("the bare session, radiance alone", spent[1:], error))
    rows += [
        {"what": what, "seconds": float(np.median(spent)), "error": error}
        for what, spent, error in steps
    ]
    return rows


def _moved(pose: np.ndarray, steps: int) -> np.ndarray:
    """A camera so many steps to the right."""
    found = np.array(pose)
    found[:3, 3] += _TURN_M * steps * found[:3, 0]
    return found


if __name__ == "__main__":
    main()
