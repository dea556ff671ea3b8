"""Draws ``docs/blender.png``: the example by our renderer, and by Cycles in Blender beside it.

``python -m docs.blender_picture`` needs Blender's environment (``.ci/install-blender``, or
``ORUSD_BLENDER_PYTHON``). Both pictures are denoised and shown at the same exposure.
"""

import json
import os
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np
import OpenImageIO
from numpy.typing import NDArray

from benchmarks.scenes import demo_stage, orusd
from openrooms_usd.imagefile import write_png
from openrooms_usd.rendering.color import fitted_exposure
from openrooms_usd.rendering.previews import preview

Radiance = NDArray[np.float32]

SIZE: Final = (320, 240)
SAMPLES: Final = 192
CAMERA: Final = "dining"
_ROOT: Final = Path(__file__).parents[1]


def ours(scene: Path, folder: Path) -> Radiance:
    """Our radiance, denoised."""
    size = f"{SIZE[0]}x{SIZE[1]}"
    orusd(
        "render",
        scene,
        "-o",
        folder / "ours",
        "--camera",
        CAMERA,
        "--resolution",
        size,
        "--spp",
        SAMPLES,
        "--denoise",
    )
    [picture] = (folder / "ours").glob("*/denoised.exr")
    return _read(picture)


def theirs(scene: Path, folder: Path) -> Radiance:
    """Cycles' picture of what Blender imports, denoised."""
    python = os.environ.get("ORUSD_BLENDER_PYTHON", str(_ROOT / ".venv-blender/bin/python"))
    picture, job = folder / "cycles.exr", folder / "job.json"
    shot = {"samples": SAMPLES, "seed": 1, "denoise": True, "picture": str(picture)}
    told = {
        "scene": str(scene),
        "camera": CAMERA,
        "size": SIZE,
        "shots": [shot],
        "report": str(folder / "report.json"),
    }
    job.write_text(json.dumps(told))
    work = Path(__file__).with_name("in_blender.py")
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    subprocess.run([python, "-P", str(work), str(job)], check=True, env=environment)
    return _read(picture)


def _read(path: Path) -> Radiance:
    pixels = OpenImageIO.ImageBuf(str(path)).get_pixels(OpenImageIO.FLOAT)
    return np.asarray(pixels, dtype=np.float32)[..., :3]


def draw(target: Path) -> None:
    """Ours on the left, Cycles' on the right, with a little white between them."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        scene = demo_stage(folder)
        both = ours(scene, folder), theirs(scene, folder)
    exposure = fitted_exposure(both[0])
    left, right = (preview("radiance", radiance, exposure).pixels for radiance in both)
    gap = np.full((SIZE[1], 6, 3), 255, dtype=np.uint8)
    write_png(target, np.concatenate([left, gap, right], axis=1))


if __name__ == "__main__":
    draw(_ROOT / "docs/blender.png")
