"""A small dataset of OpenRooms' form, with every construct of the released scene files."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from openrooms_usd import imagefile
from orusd_openrooms.pickles import write_pickled

SCENE = "scene0000_00"
# Of the layout, into a world with Y up.
SHIFT = (-2.0, -1.3, 1.5)
WIDTH, DEPTH, HEIGHT = 4.0, 3.0, 3.0
# Along the wall and in height, metres: in the wall y = 0, and in the wall x = 4.
DOOR = (1.0, 0.0, 1.9, 2.1)
WINDOW = (0.8, 0.9, 2.0, 2.1)
CHAIR_SCALE = (0.8, 1.2, 0.9)
SNAP, PUSH = (0.0, -0.07, 0.0), (0.02, 0.0, -0.03)
RADIANCE = (461.874, 452.328, 506.107)
FOV = 58.2327
LAYOUT_STEPS = f"""<scale x="1.0" y="1.0" z="1.0"/>
            <rotate angle="90.0" x="-1.0" y="0.0" z="0.0"/>
            <translate x="{SHIFT[0]}" y="{SHIFT[1]}" z="{SHIFT[2]}"/>"""
UP = "../../../../../"


def obj(quads: Sequence[tuple[str, Sequence[Sequence[float]]]]) -> str:
    """An OBJ file of quads, each with its material."""
    lines, count, worn = [], 0, ""
    for material, corners in quads:
        lines += [f"usemtl {material}"] * (material != worn)
        worn = material
        for x, y, z in corners:
            lines.append(f"v {x:.4f} {y:.4f} {z:.4f}")
            lines.append(f"vt {(x + y) * 4.0:.4f} {(z - y) * 4.0:.4f}")
        index = [f"{count + i}/{count + i}" for i in range(1, 5)]
        lines += [f"f {index[0]} {index[1]} {index[2]}", f"f {index[0]} {index[2]} {index[3]}"]
        count += 4
    return "\n".join(lines) + "\n"


def box(material: str, low: Sequence[float], high: Sequence[float]) -> list:
    """The six sides of a box."""
    corners = np.array([low, high])
    quads = []
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        for side in range(2):
            ring = np.zeros((4, 3))
            ring[:, axis] = corners[side, axis]
            ring[:, a] = corners[[0, 1, 1, 0], a]
            ring[:, b] = corners[[0, 0, 1, 1], b]
            quads.append((material, ring if side else ring[::-1]))
    return quads


def layout() -> str:
    """The shell with two true holes, Z up."""
    floor = [(0, 0), (WIDTH, 0), (WIDTH, DEPTH), (0, DEPTH)]
    quads = [(f"{SCENE}_floor", [(x, y, 0.0) for x, y in floor])]
    quads.append((f"{SCENE}_ceiling", [(x, y, HEIGHT) for x, y in floor]))
    holes = {0: DOOR, 1: WINDOW}
    for number in range(4):
        start, end = np.array(floor[number]), np.array(floor[(number + 1) % 4])
        length = float(np.linalg.norm(end - start))
        x0, z0, x1, z1 = holes.get(number, (0.0, 0.0, 0.0, 0.0))
        parts = [(0, 0, x0, HEIGHT), (x0, 0, x1, z0), (x0, z1, x1, HEIGHT), (x1, 0, length, HEIGHT)]
        for a, low, b, high in parts if number in holes else [(0, 0, length, HEIGHT)]:
            if b > a and high > low:
                one, other = (start + (end - start) * t / length for t in (a, b))
                quads.append(
                    (f"{SCENE}_wall", [(*one, low), (*other, low), (*other, high), (*one, high)])
                )
    return obj(quads)


def textured(name: str, material: str, scale: float = 1.3) -> str:
    """A ``microfacet`` with maps and factors."""
    folder = f"{UP}BRDFOriginDataset/Material__{material}/tiled"
    maps = "".join(
        f'<texture name="{kind}" type="bitmap">'
        f'<string name="filename" value="{folder}/{file}_tiled.png"/></texture>'
        for kind, file in (("albedo", "diffuse"), ("normal", "normal"), ("roughness", "rough"))
    )
    return f"""<bsdf id="{name}" type="microfacet"><float name="uvScale" value="{scale}"/>
        {maps}<rgb name="albedoScale" value="1.2 0.8 1.0"/>
        <float name="roughnessScale" value="0.9"/></bsdf>"""


def plain(name: str) -> str:
    """A ``microfacet`` of constants with factors."""
    return f"""<bsdf id="{name}" type="microfacet"><rgb name="albedo" value="0.5 0.4 0.9"/>
        <rgb name="albedoScale" value="1.1 1.0 1.3"/><float name="roughness" value="0.5"/>
        <float name="roughnessScale" value="0.8"/></bsdf>"""


def shape(model: str, file: str, steps: str, refs: Sequence[str] = (), emits: str = "") -> str:
    """A shape; its id repeats wherever its model does."""
    emitter = f'<emitter type="area"><rgb value="{emits}"/></emitter>' if emits else ""
    named = "".join(f'<ref id="{ref}" name="bsdf"/>' for ref in refs)
    return f"""<shape id="{model.replace("/", "_")}_object" type="obj">
        <string name="filename" value="{UP}{file}"/>{emitter}
        <transform name="toWorld">{steps}</transform>{named}</shape>"""


def scene(*, shapes: str | None = None, sky: str = "0.00000001", head: str = "") -> str:
    """A whole scene file."""
    shell = [f"{SCENE}_{part}" for part in ("wall", "ceiling", "floor")]
    chair, lamp = "03001627/abc", "ceiling_lamp/15650"

    def moved(x: float, angle: float, fixes: str) -> str:
        scale = 'x="{}" y="{}" z="{}"'.format(*CHAIR_SCALE)
        return f"""<scale {scale}/><rotate angle="{angle}" x="0.0" y="1.0" z="0.0"/>
            <translate x="{x}" y="-0.63" z="0.2"/>{fixes}"""

    snap, push = ('<translate x="{}" y="{}" z="{}"/>'.format(*each) for each in (SNAP, PUSH))
    # Y up in the model, Z up in the layout.
    stand = '<rotate angle="90.0" x="1.0" y="0.0" z="0.0"/>'
    hang = f'<scale x="1" y="0.5" z="1"/>{stand}<translate x="2.0" y="1.5" z="2.9"/>{LAYOUT_STEPS}'
    door = f'<scale value="1.0"/>{stand}<translate x="1.45" y="0.0" z="0.0"/>{LAYOUT_STEPS}'
    own = [
        shape(SCENE, f"layoutMesh/{SCENE}/uv_mapped.obj", LAYOUT_STEPS, shell),
        shape(SCENE, f"layoutMesh/{SCENE}/container.obj", LAYOUT_STEPS, shell),
        shape(
            chair,
            f"uv_mapped/{chair}/alignedNew.obj",
            moved(-0.5, 30, snap + push),
            ["03001627_abc_part0", "03001627_abc_part1"],
        ),
        shape(
            chair,
            f"uv_mapped/{chair}/alignedNew.obj",
            moved(0.6, -75, snap),
            ["03001627_abc_part0", "03001627_abc_part1"],
        ),
        shape(
            "04379243/none",
            "uv_mapped/04379243/none/alignedNew.obj",
            '<scale x="1.8" y="1.6" z="1.8"/><translate x="1.0" y="-0.95" z="-0.4"/>',
        ),
        shape(lamp, f"uv_mapped/{lamp}/aligned_shape.obj", hang, ["ceiling_lamp_15650_part1"]),
        shape("door/7", "uv_mapped/door/7/alignedNew.obj", door, ["door_7_part0"]),
        shape("window/3", "uv_mapped/window/3/alignedNew.obj", f'<scale value="1"/>{LAYOUT_STEPS}'),
        shape(lamp, f"uv_mapped/{lamp}/aligned_light.obj", hang, (), " ".join(map(str, RADIANCE))),
    ]
    bsdfs = [
        textured(shell[0], "clay_large", 0.5),
        plain(shell[1]),
        textured(shell[2], "carpet_loop"),
        textured("03001627_abc_part0", "wood_oak"),
        plain("03001627_abc_part1"),
        textured("ceiling_lamp_15650_part1", "gold_leaf"),
        plain("door_7_part0"),
    ]
    return f"""<?xml version="1.0" ?>{head}
<scene verion="0.5.0"><integrator type="path"/>
{"".join(bsdfs)}{"".join(own) if shapes is None else shapes}
<sensor type="perspective"><float name="fov" value="{FOV}"/><string name="fovAxis" value="x"/>
<film type="hdrfilm"><integer name="width" value="640"/><integer name="height" value="480"/></film>
<sampler type="adaptive"><integer name="sampleCount" value="1024"/></sampler></sensor>
<emitter type="envmap"><string name="filename" value="{UP}EnvDataset/173L.hdr"/>
<float name="scale" value="{sky}"/></emitter></scene>"""


def write_dataset(root: Path, **how: str) -> Path:
    """Write the dataset; of its models the table and the window are not there.

    Returns:
        The scene file.
    """
    chair = box("03001627_abc_part0", (-0.25, -0.5, -0.25), (0.25, 0.0, 0.25))
    chair += box("03001627_abc_part1", (-0.25, 0.0, -0.25), (0.25, 0.5, -0.2))
    meshes = {
        f"layoutMesh/{SCENE}/uv_mapped.obj": layout(),
        f"layoutMesh/{SCENE}/container.obj": layout(),
        "uv_mapped/03001627/abc/alignedNew.obj": obj(chair),
        "uv_mapped/ceiling_lamp/15650/aligned_shape.obj": obj(
            box("ceiling_lamp_15650_part1", (-0.2, 0.0, -0.2), (0.2, 0.1, 0.2))
        ),
        "uv_mapped/ceiling_lamp/15650/aligned_light.obj": obj(
            box("light", (-0.15, -0.1, -0.15), (0.15, 0.0, 0.15))
        ),
        "uv_mapped/door/7/alignedNew.obj": obj(
            box("door_7_part0", (-0.45, 0.0, -0.03), (0.45, 2.1, 0.03))
        ),
    }
    folder = root / "scenes/xml" / SCENE
    folder.mkdir(parents=True)
    for name, text in meshes.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    colors = {"carpet_loop": (200, 100, 50), "wood_oak": (120, 90, 40)}
    for material, color in colors.items():
        tiled = root / f"BRDFOriginDataset/Material__{material}/tiled"
        tiled.mkdir(parents=True)
        for file, texel in (("diffuse", color), ("normal", (128, 128, 255)), ("rough", (140,) * 3)):
            pixels = np.full((4, 4, 3), texel, dtype=np.uint8)
            imagefile.write_png(tiled / f"{file}_tiled.png", pixels)
    (root / "EnvDataset").mkdir()
    sky = np.ones((8, 16, 3), dtype=np.float32)
    imagefile.write(root / "EnvDataset/173L.hdr", sky, "float", {})
    poses = [(0.0, 0.3, 1.0, 0.0, 0.3, 0.0, 0.0, 1.0, 0.0), (1.0, 0.2, 1.0, 0.2, 0.2, 0.4, 0, 1, 0)]
    rows = [" ".join(f"{v:.3f}" for v in pose[i : i + 3]) for pose in poses for i in (0, 3, 6)]
    (folder / "cam.txt").write_text("\n".join(["2", *rows]) + "\n")
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    write_pickled(
        folder / "transform.dat", [[("s", np.ones(3)), ("rot", turn), ("t", np.array(SHIFT))]]
    )
    (folder / "main.xml").write_text(scene(**how))
    return folder / "main.xml"
