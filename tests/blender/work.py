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

# What the sky is called among the lights that are asked for.
SKY = "sky"


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


def arrived(_: dict[str, Any]) -> dict[str, Any]:
    """Every mesh as it is drawn, every object, material and lamp.

    A mesh is told by the names of the objects above it, those that carry its instance too.
    """
    drawn = [
        _mesh(instance)
        for instance in bpy.context.evaluated_depsgraph_get().object_instances
        if instance.object.type == "MESH"
    ]
    places = {found.name: _rows(found.matrix_world) for found in bpy.data.objects}
    materials = [_look(material) for material in bpy.data.materials if material.users]
    lamps = {found.name: _lamp(found) for found in bpy.data.objects if found.type == "LIGHT"}
    return {"drawn": drawn, "places": places, "materials": materials, "lamps": lamps}


def _rows(matrix: Any) -> list[list[float]]:
    return [list(row) for row in matrix]


def _mesh(instance: Any) -> dict[str, Any]:
    """A mesh that is drawn: the box around it in the world, metres."""
    found = instance.object
    places = [tuple(instance.matrix_world @ vertex.co) for vertex in found.data.vertices]
    above = [*_above(instance.parent)] if instance.is_instance else []
    return {
        "path": [*above, *_above(found)],
        "vertices": len(places),
        "low": [min(axis) for axis in zip(*places, strict=True)],
        "high": [max(axis) for axis in zip(*places, strict=True)],
        "materials": [slot.name for slot in found.data.materials if slot],
    }


def _above(found: Any) -> list[str]:
    return [*(_above(found.parent) if found.parent else []), found.name]


def _look(material: Any) -> dict[str, Any]:
    """What a material's inputs are: numbers, or the picture that is linked to them."""
    node = shader(material)
    inputs = ("Base Color", "Roughness", "Metallic") if node else ()
    return {"name": material.name} | {name: _input(node.inputs[name]) for name in inputs}


def _input(socket: Any) -> Any:
    """The name of the picture that reaches an input, else its numbers."""
    ends = [link.from_node for link in socket.links]
    while ends:
        node = ends.pop()
        if node.type == "TEX_IMAGE":
            return Path(node.image.filepath.replace("[", "/").rstrip("]")).name
        ends.extend(link.from_node for one in node.inputs for link in one.links)
    value = socket.default_value
    return value if isinstance(value, float) else list(value)[:3]


def _lamp(found: Any) -> dict[str, Any]:
    lamp = found.data
    told = ("type", "energy", "exposure", "normalize", "use_temperature", "temperature")
    sizes = ("shape", "size", "size_y", "shadow_soft_size", "angle")
    given = {name: getattr(lamp, name) for name in (*told, *sizes) if hasattr(lamp, name)}
    return given | {"color": list(lamp.color), "kelvin": list(lamp.temperature_color)}


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


def visited(job: dict[str, Any]) -> None:
    """A chair moved, a pole painted, a lamp dimmed, another one removed; a stool and a sun."""
    objects = bpy.data.objects
    objects["chair_0"].location.x += 0.4
    objects["chair_0"].rotation_euler.z += 0.35
    pole = _part("floor_lamp_0", "lamp_pole")
    paint = shader(pole).inputs["Base Color"]
    for link in list(paint.links):
        pole.node_tree.links.remove(link)
    paint.default_value = (*job["paint"], 1.0)
    shader(_part("ceiling_lamp_0", "light_bulb")).inputs["Emission Strength"].default_value *= 0.5
    for found in tree(objects["table_lamp_0"]):
        objects.remove(found)
    bpy.ops.mesh.primitive_cylinder_add(radius=0.2, depth=0.45, location=(3.0, 3.2, 0.225))
    bpy.context.object.name = "Stool"
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = job["lux"], math.radians(job["degrees"])
    bpy.context.scene.collection.objects.link(objects.new("Sun", sun))
    bpy.ops.wm.usd_export(filepath=job["file"])


def _part(name: str, part: str) -> Any:
    """The material that a part of an object wears."""
    [found] = [x for x in tree(bpy.data.objects[name]) if x.name.split(".")[0] == part]
    return found.data.materials[0]


def export(job: dict[str, Any]) -> None:
    """One file for each of the forms."""
    forms: dict[str, dict[str, Any]] = {
        "root": {},
        "bare": {"root_prim_path": ""},
        "merged": {"merge_parent_xform": True},
        "instanced": {"use_instancing": True},
        "unnamed": {"author_blender_name": False},
        "matrices": {"xform_op_mode": "MAT", "export_materials": False},
    }
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
    """One camera of the room, as docs/howto/blender.md has the settings."""
    photograph(job, bpy.data.objects[job["camera"]], samples=job["samples"])


def alone(job: dict[str, Any]) -> None:
    """A picture for each light, all others off: lamps, materials that glow, and the World."""
    sky = next((x for x in bpy.context.scene.world.node_tree.nodes if x.type == "BACKGROUND"), None)
    strength = sky.inputs["Strength"].default_value if sky else 0.0
    comparable(job["bounces"])
    glows = {}
    for material in bpy.data.materials:
        if (node := shader(material)) is not None:
            glows[material.name] = node.inputs["Emission Strength"].default_value
    for name, picture in job["lights"].items():
        if sky:
            sky.inputs["Strength"].default_value = strength if name == SKY else 0.0
        lit = _worn(name)
        for material, glow in glows.items():
            emission = shader(bpy.data.materials[material]).inputs["Emission Strength"]
            emission.default_value = glow if material in lit else 0.0
        for found in bpy.data.objects:
            if found.type == "LIGHT":
                found.hide_render = found.name != name
        told = job | {"picture": picture}
        photograph(told, bpy.data.objects[job["camera"]], samples=job["samples"])


def comparable(bounces: int) -> None:
    """Cycles with all light that we have too, over as many bounces of every kind."""
    cycles = bpy.context.scene.cycles
    for kind in ("max", "diffuse", "glossy", "transmission", "transparent_max"):
        setattr(cycles, f"{kind}_bounces", bounces)
    cycles.blur_glossy = 0.0
    # A pixel is the mean over its square, as ours: wider filters spread what a window shows.
    cycles.pixel_filter_type = "BOX"


def _worn(name: str) -> set[str]:
    """The materials of an object and of all below it."""
    if name not in bpy.data.objects:
        return set()
    meshes = [found.data for found in tree(bpy.data.objects[name]) if found.type == "MESH"]
    return {slot.name for mesh in meshes for slot in mesh.materials if slot}


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


def subdivided(job: dict[str, Any]) -> list[dict[str, Any]]:
    """Control cages as the modifier refines them, on the limit surface."""
    found = []
    for number, cage in enumerate(job["cages"]):
        mesh = bpy.data.meshes.new(f"cage_{number}")
        rest = iter(cage["indices"])
        faces = [[next(rest) for _ in range(count)] for count in cage["counts"]]
        mesh.from_pydata(cage["points"], [], faces)
        edges = {tuple(sorted(edge.vertices)): edge.index for edge in mesh.edges}
        sharp = mesh.attributes.new("crease_edge", "FLOAT", "EDGE").data
        # What it stores is the root of the sharpness, 1 for 10.
        for one, other, sharpness in cage["creases"]:
            sharp[edges[tuple(sorted((one, other)))]].value = math.sqrt(sharpness / 10.0)
        sharp = mesh.attributes.new("crease_vert", "FLOAT", "POINT").data
        for point, sharpness in cage["corners"]:
            sharp[point].value = math.sqrt(sharpness / 10.0)
        for place, pair in zip(mesh.uv_layers.new(name="st").data, cage["st"], strict=True):
            place.uv = pair
        thing = bpy.data.objects.new(mesh.name, mesh)
        bpy.context.collection.objects.link(thing)
        how = thing.modifiers.new("refined", "SUBSURF")
        how.levels, how.quality, how.use_limit_surface = job["levels"], 6, True
        how.boundary_smooth, how.uv_smooth = cage["boundary"], cage["uv"]
        drawn = thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
        places = [list(vertex.co) for vertex in drawn.vertices]
        pairs = [list(corner.uv) for corner in drawn.uv_layers["st"].data]
        rows = [corner.vertex_index for corner in drawn.loops]
        found.append({"points": [places[row] for row in rows], "st": pairs})
    return found


JOBS = {
    "seen": seen,
    "rearranged": rearranged,
    "export": export,
    "panorama": panorama,
    "picture": picture,
    "arrived": arrived,
    "alone": alone,
    "visited": visited,
    "subdivided": subdivided,
}


if __name__ == "__main__":
    job = json.loads(Path(sys.argv[1]).read_text())
    imported(job["scene"])
    Path(job["report"]).write_text(json.dumps(JOBS[job["job"]](job)))
