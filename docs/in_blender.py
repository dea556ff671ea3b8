"""Pictures by Cycles, run by Blender's own Python: ``python in_blender.py JOB.json``.

The job names the ``scene``, its ``camera``, the ``size``, the ``shots`` and the ``report`` that
receives their seconds of all cores. This module imports nothing of ours: Blender brings a ``pxr``
of its own.
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

import bpy


def prepared(job: dict[str, Any]) -> Any:
    """The scene in an empty Blender that has a World, with Cycles' own defaults but for the clamp.

    Lamps are thousands of nits bright: the clamp of 10 would cut nearly all that they send.
    """
    bpy.ops.wm.read_factory_settings(use_empty=False)
    for found in list(bpy.data.objects):
        bpy.data.objects.remove(found)
    bpy.ops.wm.usd_import(filepath=job["scene"])
    scene = bpy.context.scene
    scene.camera = bpy.data.objects[job["camera"]]
    render = scene.render
    render.engine = "CYCLES"
    render.use_persistent_data = True
    render.resolution_x, render.resolution_y = job["size"]
    render.resolution_percentage = 100
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    scene.cycles.sample_clamp_indirect = 0.0
    # As many samples everywhere as are asked for.
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.denoiser = "OPENIMAGEDENOISE"
    scene.cycles.denoising_input_passes = "RGB_ALBEDO_NORMAL"
    return scene


def photograph(scene: Any, shot: dict[str, Any]) -> float:
    """One picture, and its seconds."""
    scene.cycles.samples, scene.cycles.seed = shot["samples"], shot["seed"]
    scene.cycles.use_denoising = shot.get("denoise", False)
    scene.render.filepath = shot["picture"]
    began = time.process_time()
    bpy.ops.render.render(write_still=True)
    return time.process_time() - began


if __name__ == "__main__":
    job = json.loads(Path(sys.argv[1]).read_text())
    scene = prepared(job)
    seconds = [photograph(scene, shot) for shot in job["shots"]]
    Path(job["report"]).write_text(json.dumps(seconds))
