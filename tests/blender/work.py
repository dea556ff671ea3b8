"""What a person does in Blender, run by Blender's own Python: `python work.py JOB.json`.

The job names the ``scene`` to import, what to do with it, and the file that receives what was seen.
This module imports nothing of ours: Blender carries a ``pxr`` of its own.
"""

import json
import math
import sys
from pathlib import Path
from typing import Any

import bpy


def imported(scene: str) -> None:
    """The scene in an empty Blender that has a World, without which no sky arrives."""
    bpy.ops.wm.read_factory_settings(use_empty=False)
    for found in list(bpy.data.objects):
        bpy.data.objects.remove(found)
    bpy.ops.wm.usd_import(filepath=scene)


def tree(found: Any) -> list[Any]:
    return [found, *(below for child in found.children for below in tree(child))]


def shader(material: Any) -> Any:
    return material.node_tree.nodes.get("Principled BSDF")


def seen(_: dict[str, Any]) -> dict[str, Any]:
    """What has arrived."""
    kinds: dict[str, int] = {}
    for found in bpy.data.objects:
        kinds[found.type] = kinds.get(found.type, 0) + 1
    glow = {}
    for material in bpy.data.materials:
        node = shader(material)
        if node is not None and node.inputs["Emission Strength"].default_value > 0.0:
            color = node.inputs["Emission Color"].default_value
            glow[material.name] = [
                c * node.inputs["Emission Strength"].default_value for c in color[:3]
            ]
    cameras = {
        found.name: {
            "matrix": [list(row) for row in found.matrix_world],
            "fov": math.degrees(2 * math.atan(found.data.sensor_width / (2 * found.data.lens))),
        }
        for found in bpy.data.objects
        if found.type == "CAMERA"
    }
    exposure = bpy.context.scene.view_settings.exposure
    return {"kinds": kinds, "glow": glow, "cameras": cameras, "exposure": exposure}


def rearranged(job: dict[str, Any]) -> None:
    """Moves, removes, adds, recolours; then exports in every form."""
    objects, kinds = bpy.data.objects, bpy.data
    objects["sofa_0"].location.x += 0.5
    objects["table_lamp_0"].location.y += 0.3
    for found in tree(objects["chair_1"]):
        objects.remove(found)
    copy = objects["dining_table"].copy()
    copy.location.x -= 1.0
    bpy.context.scene.collection.objects.link(copy)
    bpy.ops.mesh.primitive_cube_add(size=0.4, location=(3, 2, 0.2))
    crate, paint = bpy.context.object, kinds.materials.new("Red Paint")
    crate.name = "Crate"
    shader(paint).inputs["Base Color"].default_value = (0.9, 0.1, 0.1, 1.0)
    crate.data.materials.append(paint)
    objects["overview"].data.lens *= 1.2
    [bulb] = [x for x in tree(objects["floor_lamp_0"]) if x.name.startswith("light_bulb")]
    shader(bulb.data.materials[0]).inputs["Emission Strength"].default_value = 0.5
    export(job)


def export(job: dict[str, Any]) -> None:
    """One file for each of the forms."""
    forms: dict[str, dict[str, Any]] = {
        "root": {}, "bare": {"root_prim_path": ""}, "merged": {"merge_parent_xform": True},
        "instanced": {"use_instancing": True}, "unnamed": {"author_blender_name": False},
        "matrices": {"xform_op_mode": "MAT", "export_materials": False},
    }  # fmt: skip
    for name, options in forms.items():
        bpy.ops.wm.usd_export(filepath=str(Path(job["folder"]) / f"{name}.usda"), **options)


def panorama(job: dict[str, Any]) -> None:
    """What the sky is in every direction, from far above: the middle looks along +Y."""
    scene = bpy.context.scene
    lens = bpy.data.cameras.new("panorama")
    eye = bpy.data.objects.new("panorama", lens)
    scene.collection.objects.link(eye)
    lens.type, lens.panorama_type = "PANO", "EQUIRECTANGULAR"
    eye.rotation_euler, eye.location = (math.pi / 2, 0.0, 0.0), (0.0, 0.0, 1000.0)
    photograph(job, eye, samples=1, sharp=True)


def picture(job: dict[str, Any]) -> None:
    """One camera of the room, as docs/blender.md has the settings."""
    photograph(job, bpy.data.objects[job["camera"]], samples=job["samples"])


def photograph(job: dict[str, Any], eye: Any, *, samples: int, sharp: bool = False) -> None:
    scene = bpy.context.scene
    scene.camera = eye
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = samples, False
    # Lamps of thousands of nits: the default of 10 would cut nearly all that they send.
    scene.cycles.sample_clamp_indirect = job.get("clamp", 0.0)
    if sharp:
        scene.cycles.filter_width = 0.01
    width, height = job["size"]
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = job["picture"]
    bpy.ops.render.render(write_still=True)


JOBS = {
    "seen": seen, "rearranged": rearranged, "export": export, "panorama": panorama,
    "picture": picture,
}  # fmt: skip


if __name__ == "__main__":
    job = json.loads(Path(sys.argv[1]).read_text())
    imported(job["scene"])
    Path(job["report"]).write_text(json.dumps(JOBS[job["job"]](job)))
