"""Sound models of the user's own, what people noted about them, and folders of CADs."""

import json
import struct
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tests.fuzz.kinds import AGAIN, TINY, Kind, planting_out
from tests.fuzz.pictures import ramp, write_picture

# A tetrahedron, counter-clockwise from outside.
_POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
_FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])

_OBJ = """\
mtllib a.mtl
o body
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
vt 0 0
vt 1 0
vt 0 1
vn 0 0 1
g one
usemtl wood
f 1/1/1 3/2/1 2/3/1
f 1/1/1 2/2/1 4/3/1
g two
usemtl lamp
f 1/1 4/2 3/3
f 2//1 3//1 4//1
"""
_MTL = """\
newmtl wood
Kd 0.5 0.4 0.3
Ks 0 0 0
Ns 20
d 1
map_Kd -s 1 1 1 color.png
map_Bump -bm 0.5 color.png
newmtl lamp
Kd 0 0 0
Ke 1 1 1
Pr 0.5
Pm 0.1
illum 2
"""
_USD = """\
#usda 1.0
(
    defaultPrim = "Chair"
    metersPerUnit = 0.01
    upAxis = "Y"
)

def Xform "Chair" (
    assetInfo = {
        string license = "CC0-1.0"
    }
    prepend references = @./part.usda@</Part>
)
{
    float3 xformOp:scale = (50, 50, 50)
    uniform token[] xformOpOrder = ["xformOp:scale"]

    def Mesh "Seat" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {
        int[] faceVertexCounts = [3, 3, 3, 3]
        int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)]
        texCoord2f[] primvars:st = [(0, 0), (1, 0), (0, 1), (1, 1)] (
            interpolation = "vertex"
        )
        int[] primvars:st:indices = [0, 1, 2, 3]
        uniform token subdivisionScheme = "none"
        rel material:binding = </Chair/Wood>
    }

    def GeomSubset "left"
    {
        int[] indices = [0, 1]
    }

    def Material "Wood"
    {
        token outputs:surface.connect = </Chair/Wood/Surface.outputs:surface>

        def Shader "Surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor.connect = </Chair/Wood/Picture.outputs:rgb>
            float inputs:roughness = 0.5
            token outputs:surface
        }

        def Shader "Picture"
        {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @./color.png@
            float3 outputs:rgb
        }
    }
}
"""
_PART = """\
#usda 1.0
(
    subLayers = [
        @./more.usda@
    ]
)

class "Part"
{
    def Cube "Leg"
    {
        double size = 0.4
        double3 xformOp:translate = (0.1, 0.2, 0.3)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
"""
_MORE = '#usda 1.0\n\nover "Part"\n{\n    over "Leg"\n    {\n        double size = 0.5\n    }\n}\n'

_ANNOTATION = "# 3 parts\n0 0 6\n1 1\n2 9\n"
_NAMED = "chair\nchair_seat: wood, fabric\nleg: metal\nback:\n"


def _glb(gltf: dict[str, Any], binary: bytes) -> bytes:
    text = json.dumps(
        {"asset": {"version": "2.0"}, "buffers": [{"byteLength": len(binary)}]} | gltf
    )
    head = text.encode() + b" " * (-len(text) % 4)
    body = binary + b"\0" * (-len(binary) % 4)
    size = 28 + len(head) + len(body)
    return (
        struct.pack("<4sIII4s", b"glTF", 2, size, len(head), b"JSON")
        + head
        + struct.pack("<I4s", len(body), b"BIN\0")
        + body
    )


def _gltf(blobs: Sequence[bytes], **more: Any) -> dict[str, Any]:
    views, at = [], 0
    for blob in blobs:
        views.append({"buffer": 0, "byteOffset": at, "byteLength": len(blob)})
        at += len(blob)
    primitive = {
        "attributes": {"POSITION": 0, "TEXCOORD_0": 1},
        "indices": 2,
        "material": 0,
        "mode": 4,
    }
    return {
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": [0, 0, 1], "children": [1]}, {"name": "empty"}],
        "meshes": [{"name": "body", "primitives": [primitive]}],
        "materials": [{"name": "m", "pbrMetallicRoughness": {"roughnessFactor": 0.4}}],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": 4,
                "type": "VEC3",
                "min": [0, 0, 0],
                "max": [1, 1, 1],
            },
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": views,
    } | more


def _png(folder: Path) -> bytes:
    write_picture(folder / "texture.png", ramp())
    data = (folder / "texture.png").read_bytes()
    (folder / "texture.png").unlink()
    return data


def _ktx2() -> bytes:
    """A KTX2 header with one level of noise, supercompressed as Basis ETC1S."""
    head = b"\xabKTX 20\xbb\r\n\x1a\n" + struct.pack("<9I", 0, 1, 16, 16, 0, 0, 1, 1, 1)
    level = bytes(range(64))
    index = struct.pack("<4I2Q", 0, 0, 0, 0, 0, 0) + struct.pack("<3Q", 104, len(level), 1024)
    return head + index + level


def write_glbs(folder: Path) -> None:
    """GLB files: plain, with a picture, with a KTX2 picture, and Draco where that is installed."""
    points, st = _POINTS.astype("<f4").tobytes(), np.zeros((4, 2), "<f4").tobytes()
    blobs = [points, st, _FACES.astype("<u2").tobytes()]
    (folder / "plain.glb").write_bytes(_glb(_gltf(blobs), b"".join(blobs)))
    texture = {"materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]}
    picture = [*blobs, _png(folder)]
    gltf = _gltf(
        picture,
        **texture,
        textures=[{"source": 0}],
        images=[{"bufferView": 3, "mimeType": "image/png"}],
    )
    (folder / "textured.glb").write_bytes(_glb(gltf, b"".join(picture)))
    basisu = [*blobs, _ktx2()]
    gltf = _gltf(
        basisu,
        **texture,
        textures=[{"extensions": {"KHR_texture_basisu": {"source": 0}}}],
        images=[{"bufferView": 3, "mimeType": "image/ktx2"}],
        extensionsUsed=["KHR_texture_basisu"],
        extensionsRequired=["KHR_texture_basisu"],
    )
    (folder / "basisu.glb").write_bytes(_glb(gltf, b"".join(basisu)))
    try:
        import DracoPy
    except ImportError:
        return
    packed = DracoPy.encode(_POINTS, _FACES)
    gltf = _gltf([packed], extensionsUsed=["KHR_draco_mesh_compression"])
    gltf["accessors"] = [
        {"componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
        {"componentType": 5125, "count": 12, "type": "SCALAR"},
    ]
    gltf["meshes"][0]["primitives"] = [
        {
            "attributes": {"POSITION": 0},
            "indices": 1,
            "mode": 4,
            "extensions": {
                "KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}
            },
        }
    ]
    (folder / "draco.glb").write_bytes(_glb(gltf, packed))


def _plant_obj(folder: Path) -> None:
    inner = folder / "in"
    inner.mkdir()
    (inner / "a.obj").write_text(_OBJ)
    (inner / "a.mtl").write_text(_MTL)
    write_picture(inner / "color.png", ramp())


def _plant_glb(folder: Path) -> None:
    (folder / "in").mkdir()
    write_glbs(folder / "in")


def _plant_usd(folder: Path) -> None:
    from pxr import Sdf, UsdUtils

    inner = folder / "in"
    inner.mkdir()
    (inner / "a.usda").write_text(_USD)
    (inner / "part.usda").write_text(_PART)
    (inner / "more.usda").write_text(_MORE)
    write_picture(inner / "color.png", ramp())
    Sdf.Layer.FindOrOpen(str(inner / "a.usda")).Export(str(inner / "b.usdc"))
    UsdUtils.CreateNewUsdzPackage(str(inner / "a.usda"), str(inner / "c.usdz"))


def _model(name: str, folder: Path) -> object:
    from openrooms_usd.library.models.meshfile import dependencies, read_model
    from openrooms_usd.usd.files.diagnostics import quiet

    with quiet():
        dependencies(folder / "in" / name)
        return read_model(folder / "in" / name)


def _plant_annotations(folder: Path) -> None:
    (folder / "in").mkdir()
    (folder / "in/ann.txt").write_text(_ANNOTATION)
    (folder / "in/matNum.txt").write_text("3\n")
    (folder / "in/annoMatParts.txt").write_text(_NAMED)


def _annotation(name: str, folder: Path) -> object:
    from openrooms_usd.library.styles.assignment.annotations import files_of, read_annotation

    files_of(folder / "in" / name)
    return read_annotation(folder / "in" / name)


def _plant_cads(folder: Path) -> None:
    _plant_obj(folder)
    index = {"a": {"category": "chair", "front": "-Y", "up": "Y", "symmetry": "none"}}
    (folder / "in/index.json").write_text(json.dumps(index))


def _cads(folder: Path) -> object:
    from openrooms_usd.library.models.cads import folder_cads

    return [cad.model() for cad in folder_cads(folder / "in")]


_OBJECT = (
    "furniture:\n  from: objects\n  objects:\n    - {category: chair, at: [1, 1], from: file, "
    "file: %s, size: [0.5, 0.5, 0.9]}\n" + TINY + "}\n"
)
KINDS = (
    Kind("model.obj", _plant_obj, ((1, partial(_model, "a.obj")),), share=4),
    Kind(
        "model.obj-composed",
        planting_out(_plant_obj, _OBJECT % "a.obj"),
        ((1, f"{AGAIN}furniture"),),
        ("in/a.*", "in/*.png"),
        share=1,
    ),
    Kind(
        "model.glb",
        _plant_glb,
        tuple((1, partial(_model, f"{name}.glb")) for name in ("plain", "textured", "basisu")),
        share=4,
    ),
    Kind(
        "model.draco",
        _plant_glb,
        ((1, partial(_model, "draco.glb")),),
        ("in/draco.glb",),
        ("DracoPy",),
    ),
    Kind(
        "model.usd",
        _plant_usd,
        tuple((1, partial(_model, name)) for name in ("a.usda", "b.usdc", "c.usdz")),
        share=5,
    ),
    Kind(
        "model.usd-composed",
        planting_out(_plant_usd, _OBJECT % "a.usda"),
        ((1, f"{AGAIN}furniture"),),
        ("in/*.usda", "in/*.png"),
        share=1,
    ),
    Kind("model.cads", _plant_cads, ((1, _cads),), share=2),
    Kind(
        "model.annotations",
        _plant_annotations,
        ((2, partial(_annotation, "ann.txt")), (1, partial(_annotation, "annoMatParts.txt"))),
    ),
)
