"""Colours of vertices, sparse arrays, and what else models have that is not used."""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.library.assets import Model
from openrooms_usd.library.models.meshfile import read_model

POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "<f4")
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], "<u4")
GREEN = np.tile([0.0, 0.5, 0.0, 1.0], (4, 1))


def accessor(view: int, kind: int, shape: str, count: int, **more: Any) -> dict[str, Any]:
    return {"bufferView": view, "componentType": kind, "type": shape, "count": count, **more}


def glb(path: Path, arrays: list[np.ndarray], accessors: list[dict], **more: Any) -> Model:
    """A tetrahedron: its points are the first accessor, its triangles the second."""
    views, body = [], b""
    for array in arrays:
        views.append({"buffer": 0, "byteOffset": len(body), "byteLength": array.nbytes})
        body += array.tobytes() + bytes(-array.nbytes % 4)
    attributes = {"POSITION": 0} | more.pop("attributes", {})
    header = {
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "meshes": [
            {"primitives": [{"attributes": attributes, "indices": 1, **more.pop("of", {})}]}
        ],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(body)}],
    } | more
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(body), b"BIN\0") + body
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
    return read_model(path, unit=1.0, up="Z")


def colour_of(model: Model) -> np.ndarray:
    (surface,) = model.surfaces.values()
    return np.asarray(surface.base_color)


@pytest.mark.parametrize(
    ("values", "kind"),
    [
        (GREEN.astype("<f4"), 5126),
        (np.rint(GREEN * 255).astype("u1"), 5121),
        (np.rint(GREEN * 65535).astype("<u2"), 5123),
    ],
    ids=["float", "byte", "short"],
)
@pytest.mark.parametrize("factor", [None, 0.5])
def test_a_glb_has_the_colour_of_its_vertices(
    tmp_path: Path, values: np.ndarray, kind: int, factor: float | None
) -> None:
    more: dict[str, Any] = {"attributes": {"COLOR_0": 2}}
    if factor is not None:
        surface = {"pbrMetallicRoughness": {"baseColorFactor": [factor] * 3 + [1.0]}}
        more |= {"of": {"material": 0}, "materials": [surface]}
    model = glb(
        tmp_path / "green.glb",
        [POINTS, FACES, values],
        [
            accessor(0, 5126, "VEC3", 4),
            accessor(1, 5125, "SCALAR", 12),
            accessor(2, kind, "VEC4", 4, normalized=kind != 5126),
        ],
        **more,
    )
    # Linear, and a factor of the material's own; trimesh keeps eight bits.
    np.testing.assert_allclose(colour_of(model), [0.0, 0.5 * (factor or 1.0), 0.0], atol=0.005)
    assert not model.notes


OBJ = "".join(f"v {x:g} {y:g} {z:g} {{}}\n" for x, y, z in POINTS) + "".join(
    f"f {a} {b} {c}\n" for a, b, c in FACES + 1
)
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    + "".join(f"{x:g} {y:g} {z:g} {{}}\n" for x, y, z in POINTS)
    + "".join(f"3 {a} {b} {c}\n" for a, b, c in FACES)
)


USDA = (
    '#usda 1.0\n(metersPerUnit = 1\nupAxis = "Z")\ndef Mesh "m" {{\n'
    f"point3f[] points = {[tuple(p) for p in POINTS.tolist()]}\n"
    "int[] faceVertexCounts = [3, 3, 3, 3]\n"
    f"int[] faceVertexIndices = {FACES.reshape(-1).tolist()}\n"
    'color3f[] primvars:displayColor = [({})] (interpolation = "constant")\n}}\n'
)


@pytest.mark.parametrize(
    ("name", "text", "colour"),
    [("a.obj", OBJ, "0 0.5 1"), ("b.obj", OBJ, "0 127.5 255"), ("c.ply", PLY, "0 128 255")],
)
def test_colours_are_linear_or_decoded(tmp_path: Path, name: str, text: str, colour: str) -> None:
    (tmp_path / name).write_text(text.format(*[colour] * 4))
    model = read_model(tmp_path / name, unit=1.0, up="Z")
    # IEC 61966-2-1: 0.5 is 0.2140 linear.
    np.testing.assert_allclose(colour_of(model), [0.0, 0.214, 1.0], atol=0.003)
    assert not model.notes


def test_colours_that_differ_are_told(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text(OBJ.format("0 0 0", "1 1 1", "1 1 1", "0 0 0"))
    model = read_model(tmp_path / "a.obj", unit=1.0, up="Z")
    np.testing.assert_allclose(colour_of(model), 0.5)
    assert model.notes == ("the colours of the vertices of a differ: their mean is used",)


@pytest.mark.parametrize("others", ["0 0.5 1", "0 127.5 255"])
def test_colours_that_are_no_numbers_do_not_count(tmp_path: Path, others: str) -> None:
    (tmp_path / "a.obj").write_text(OBJ.format("nan 0 0", *[others] * 3))
    model = read_model(tmp_path / "a.obj", unit=1.0, up="Z")
    np.testing.assert_allclose(colour_of(model), [0.0, 0.214, 1.0], atol=0.003)
    assert model.notes == ("colours of vertices of a are not numbers, and are not used",)
    (tmp_path / "a.obj").write_text(OBJ.format(*["nan 0 0"] * 4))
    assert not read_model(tmp_path / "a.obj", unit=1.0, up="Z").surfaces


@pytest.mark.parametrize("based", [False, True])
def test_sparse_accessors_are_filled_in(tmp_path: Path, based: bool) -> None:
    # Without values below them the other rows are zero, as the first point is.
    rows = np.array([1, 3] if based else [1, 2, 3], "u1")
    below = POINTS.copy()
    below[rows] = 7.0
    sparse = {
        "count": len(rows),
        "indices": {"bufferView": 2, "componentType": 5121},
        "values": {"bufferView": 3},
    }
    points = accessor(0, 5126, "VEC3", 4, sparse=sparse)
    if not based:
        del points["bufferView"]
    arrays = [below, FACES, rows, POINTS[rows]]
    (mesh,) = glb(
        tmp_path / "a.glb", arrays, [points, accessor(1, 5125, "SCALAR", 12)]
    ).parts.values()
    assert {tuple(p) for p in np.add(mesh.points, (0.5, 0.5, 0.0))} == {tuple(p) for p in POINTS}


@pytest.mark.parametrize(
    ("change", "rows"), [({"count": 9}, [1, 3]), ({}, [3, 1]), ({}, [1, 9])], ids=str
)
def test_broken_sparse_accessors_are_refused(
    tmp_path: Path, change: dict[str, int], rows: list[int]
) -> None:
    sparse = {
        "count": 2,
        "indices": {"bufferView": 2, "componentType": 5121},
        "values": {"bufferView": 3},
    } | change
    points = accessor(0, 5126, "VEC3", 4, sparse=sparse)
    arrays = [POINTS, FACES, np.array(rows, "u1"), POINTS[:2]]
    with pytest.raises(InputError, match="not a readable GLB"):
        glb(tmp_path / "a.glb", arrays, [points, accessor(1, 5125, "SCALAR", 12)])


@pytest.mark.parametrize(("mode", "told"), [(6, "triangle fans"), (1, "points and lines")])
def test_primitives_without_triangles_are_told(tmp_path: Path, mode: int, told: str) -> None:
    one = {"attributes": {"POSITION": 0}, "indices": 1}
    model = glb(
        tmp_path / "a.glb",
        [POINTS, FACES],
        [accessor(0, 5126, "VEC3", 4), accessor(1, 5125, "SCALAR", 12)],
        meshes=[{"primitives": [one, {**one, "mode": mode}]}],
    )
    assert any(told in note for note in model.notes)


def test_what_is_not_used_is_told(tmp_path: Path) -> None:
    st = np.zeros((4, 2), "<f4")
    model = glb(
        tmp_path / "a.glb",
        [POINTS, FACES, st],
        [
            accessor(0, 5126, "VEC3", 4),
            accessor(1, 5125, "SCALAR", 12),
            accessor(2, 5126, "VEC2", 4),
        ],
        attributes={"TEXCOORD_0": 2, "TEXCOORD_1": 2},
        of={"material": 0},
        materials=[{"emissiveFactor": [1, 1, 1]}],
        extensionsUsed=["KHR_texture_transform"],
    )
    told = "not used of the GLB file: TEXCOORD_1, emission, KHR_texture_transform"
    assert told in model.notes
    (tmp_path / "b.ply").write_text(
        PLY.replace("uchar blue\n", "uchar blue\nproperty float quality\n").format(*["0 0 0 1"] * 4)
    )
    assert "not used of the PLY file: quality" in read_model(tmp_path / "b.ply", unit=1.0).notes
    (tmp_path / "c.mtl").write_text("newmtl m\nKd 1 0 0\nmap_Bump a.png\n")
    (tmp_path / "c.obj").write_text("mtllib c.mtl\nusemtl m\n" + OBJ.format(*[""] * 4) + "l 1 2\n")
    notes = read_model(tmp_path / "c.obj", unit=1.0).notes
    assert "not used of the OBJ file: l" in notes
    assert "not used of the material 'm': map_Bump" in notes
