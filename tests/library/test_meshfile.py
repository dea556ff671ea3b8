"""The user's models: frames, units, names, mending, and everything that can be wrong with them."""

import json
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
from pxr import Usd, UsdGeom

from openrooms_usd.errors import InputError, MissingPackageError
from openrooms_usd.furniture import CATEGORIES, make
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.normals import face_vectors
from openrooms_usd.geometry.solids import box
from openrooms_usd.geometry.uvquality import uv_quality
from openrooms_usd.imagefile import write_png
from openrooms_usd.library.assets import Asset, publish
from openrooms_usd.library.models.meshfile import read_model
from openrooms_usd.library.models.pieces import prim_names
from openrooms_usd.usd.shading.materials import Texture
from openrooms_usd.usd.shapes.meshes import define_mesh
from tests.furniture.pieces import piece

# A wedge 2 wide, 1 deep, 3 high in a Y-up file; only the low corner in front is missing.
WEDGE = """\
v 0 0 0
v 2 0 0
v 2 0 1
v 0 0 1
v 0 3 0
v 2 3 0
g body
f 1 2 3 4
f 1 5 6 2
f 4 3 6 5
g side 1
f 1 4 5
f 2 6 3
"""


def _write(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def test_obj_groups_become_parts_in_our_frame(tmp_path: Path) -> None:
    model = read_model(_write(tmp_path / "wedge.obj", WEDGE))
    assert list(model.parts) == ["body", "side_1"]
    assert dict(model.titles) == {"side_1": "side 1"}
    np.testing.assert_allclose(model.extent, [[-1, -0.5, 0], [1, 0.5, 3]], atol=1e-12)
    whole = joined(list(model.parts.values()))
    assert whole.volume() == pytest.approx(3.0)
    # Y up to Z up turns +Z to -Y: the slope looks to the front and upwards.
    slope = whole.points[np.isclose(whole.points[:, 2], 3)]
    assert np.allclose(slope[:, 1], 0.5)


@pytest.mark.parametrize(
    ("front", "back"), [("-Y", (0, 1)), ("+Y", (0, -1)), ("+X", (1, 0)), ("-X", (-1, 0))]
)
def test_the_front_is_turned_towards_minus_y(
    tmp_path: Path, front: str, back: tuple[int, int]
) -> None:
    # The wedge's tall side lies at +Y of a Z-up frame; with another front it comes elsewhere.
    model = read_model(_write(tmp_path / "wedge.obj", WEDGE), front=front)  # type: ignore[arg-type]
    whole = joined(list(model.parts.values()))
    top = whole.points[np.isclose(whole.points[:, 2], 3)][:, :2].mean(axis=0)
    np.testing.assert_allclose(np.sign(np.round(top, 9)), back)
    assert whole.volume() == pytest.approx(3.0)


def test_up_and_unit_are_taken_from_the_description(tmp_path: Path) -> None:
    model = read_model(_write(tmp_path / "wedge.obj", WEDGE), up="Z", unit=0.01)
    np.testing.assert_allclose(model.extent[1] - model.extent[0], [0.02, 0.03, 0.01])


def test_stretched_to_its_box(tmp_path: Path) -> None:
    model = read_model(_write(tmp_path / "wedge.obj", WEDGE), size=(0.5, 0.6, 0.7))
    np.testing.assert_allclose(model.extent, [[-0.25, -0.3, 0], [0.25, 0.3, 0.7]], atol=1e-12)
    for mesh in model.parts.values():
        facing = np.einsum(
            "ij,ij->i", np.repeat(face_vectors(mesh), mesh.counts, axis=0), mesh.normals
        )
        assert facing.min() > 0
        assert mesh.st is not None


def test_the_same_solid_in_every_format(tmp_path: Path) -> None:
    size = np.array([0.4, 0.5, 0.6])
    solid = trimesh.creation.box(extents=size[[0, 2, 1]])
    solid.export(tmp_path / "box.obj")
    solid.export(tmp_path / "box.glb")
    turned = solid.copy()
    turned.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    turned.export(tmp_path / "box.ply")
    stage = Usd.Stage.CreateNew(str(tmp_path / "box.usda"))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    define_mesh(stage, "/box", box(100 * size[[0, 2, 1]]))
    stage.Save()
    for suffix in ("obj", "glb", "ply", "usda"):
        model = read_model(tmp_path / f"box.{suffix}")
        (mesh,) = model.parts.values()
        np.testing.assert_allclose(model.extent[1] - model.extent[0], size, atol=1e-6)
        assert mesh.volume() == pytest.approx(size.prod(), rel=1e-5)
        # Eight corners, however often the file repeats them.
        assert len(mesh.points) == 8
        np.testing.assert_allclose(np.abs(mesh.normals).max(axis=1), 1, atol=1e-5)
        assert not model.double_sided


def test_glb_nodes_keep_their_place_and_constants(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    red = trimesh.visual.material.PBRMaterial(
        baseColorFactor=[255, 0, 0, 255], metallicFactor=0.0, roughnessFactor=0.25
    )
    leg = trimesh.creation.box(extents=(0.1, 1, 0.1))
    leg.visual = trimesh.visual.TextureVisuals(material=red)
    for x in (-1, 1):
        place = np.eye(4)
        place[0, 3] = x
        scene.add_geometry(leg, node_name=f"leg {x}", geom_name="leg", transform=place)
    scene.export(tmp_path / "legs.glb")
    model = read_model(tmp_path / "legs.glb")
    assert len(model.parts) == 2
    np.testing.assert_allclose(model.extent[1] - model.extent[0], [2.1, 0.1, 1], atol=1e-6)
    for surface in model.surfaces.values():
        assert surface.base_color == (1.0, 0.0, 0.0)
        assert surface.roughness == pytest.approx(0.25)


def test_the_copyright_of_a_glb_is_kept(tmp_path: Path) -> None:
    trimesh.Scene(trimesh.creation.box()).export(tmp_path / "plain.glb")
    assert read_model(tmp_path / "plain.glb").licence == ""

    def sign(tree: dict) -> None:
        tree["asset"]["copyright"] = "2026 A. Maker, CC-BY-4.0"

    trimesh.Scene(trimesh.creation.box()).export(tmp_path / "own.glb", tree_postprocessor=sign)
    assert read_model(tmp_path / "own.glb").licence == "2026 A. Maker, CC-BY-4.0"


def test_mtl_colours_and_pictures(tmp_path: Path) -> None:
    _write(tmp_path / "wedge.mtl", "newmtl red\nKd 1 0 0\nNs 6\nnewmtl wood\nmap_Kd w.png\n")
    write_png(tmp_path / "w.png", np.zeros((2, 2, 3), np.uint8))
    head = "mtllib wedge.mtl\nvt 0 0\nvt 5 0\nvt 5 5\n"
    body = WEDGE.replace("g body", "g body\nusemtl red").replace(
        "f 1 4 5", "usemtl wood\nf 1/1 4/2 5/3"
    )
    body = body.replace("f 2 6 3", "f 2/1 6/2 3/3")
    model = read_model(_write(tmp_path / "wedge.obj", head + body))
    assert model.surfaces["body"].base_color == (1.0, 0.0, 0.0)
    # alpha = sqrt(2 / (6 + 2)) = 1 / 2, roughness its root.
    assert model.surfaces["body"].roughness == pytest.approx(np.sqrt(0.5), abs=1e-4)
    picture = model.surfaces["side_1"].base_color
    assert isinstance(picture, Texture)
    assert Path(picture.file) == tmp_path / "w.png"
    assert model.parts["side_1"].st.max() == 5
    # Without a texture of its own, a part is mapped in metres.
    assert model.parts["body"].st.max() < 4


def test_files_outside_the_models_folder_are_ignored(tmp_path: Path) -> None:
    (tmp_path / "model").mkdir()
    _write(tmp_path / "secret.mtl", "newmtl a\nKd 1 0 0\n")
    _write(tmp_path / "model" / "own.mtl", "newmtl a\nmap_Kd ../../secret.png\n")
    text = "mtllib ../secret.mtl\nmtllib own.mtl\nmtllib none.mtl\nusemtl a\n" + WEDGE
    model = read_model(_write(tmp_path / "model" / "wedge.obj", text))
    assert not isinstance(model.surfaces["body"].base_color, Texture)
    assert model.surfaces["body"].base_color != (1.0, 0.0, 0.0)
    outside = [note for note in model.notes if "outside the model's folder" in note]
    assert len(outside) == 2
    assert any("none.mtl" in note for note in model.notes)


@pytest.mark.parametrize(
    ("name", "taken", "note"),
    [
        ("none.png", "", "does not exist"),
        ("WOOD.png", "Wood.PNG", "Wood.PNG is used"),
        ("folder%20a\\b%20c.png", "folder a/b c.png", "b c.png is used"),
        ("C:\\me\\folder%20a\\b%20c.png", "folder a/b c.png", "b c.png is used"),
        ("/maps/me/wood.png", "Wood.PNG", "outside the model's folder, Wood.PNG is used"),
        ("../me/wood.png", "Wood.PNG", "outside the model's folder, Wood.PNG is used"),
        ("%2e%2e/outside.png", "", "does not exist"),
        ("empty.png", "", "the file is empty"),
        ("pointer.png", "", "git lfs pull"),
    ],
)
def test_pictures_of_other_systems_and_broken_ones(
    tmp_path: Path, name: str, taken: str, note: str
) -> None:
    home = tmp_path / "model"
    (home / "folder a").mkdir(parents=True)
    for file in ("model/Wood.PNG", "model/folder a/b c.png", "outside.png"):
        write_png(tmp_path / f"{file}.png", np.zeros((2, 2, 3), np.uint8))
        (tmp_path / f"{file}.png").rename(tmp_path / file)
    (home / "empty.png").write_bytes(b"")
    (home / "pointer.png").write_text("version https://git-lfs.github.com/spec/v1\n")
    _write(home / "own.mtl", f"newmtl a\nKd 1 0 0\nmap_Kd {name}\n")
    model = read_model(_write(home / "wedge.obj", "mtllib own.mtl\nusemtl a\n" + WEDGE))
    color = model.surfaces["body"].base_color
    if taken:
        assert isinstance(color, Texture) and Path(color.file) == home / taken
    else:
        assert color == (1.0, 0.0, 0.0)
    assert any(note in one for one in model.notes)


def test_inside_out_faces_follow_their_normals(tmp_path: Path) -> None:
    text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nf 3//1 2//1 1//1\n"
    (mesh,) = read_model(_write(tmp_path / "flat.obj", text)).parts.values()
    facing = np.einsum("ij,ij->i", np.repeat(face_vectors(mesh), 3, axis=0), mesh.normals)
    assert facing.min() > 0
    # Y up to Z up turns +Z to -Y.
    np.testing.assert_allclose(mesh.normals, [[0, -1, 0]] * 3, atol=1e-6)


@pytest.mark.parametrize("inside_out", [False, True])
def test_normals_of_a_wrong_sign_follow_the_faces_of_a_solid(
    tmp_path: Path, inside_out: bool
) -> None:
    """The faces bound it from outside whichever of both was written wrongly."""
    corners = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    quads = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    sign = 1 if inside_out else -1
    lines += [
        f"vn {sign * (2 * x - 1)} {sign * (2 * y - 1)} {sign * (2 * z - 1)}" for x, y, z in corners
    ]
    for quad in quads:
        order = quad[::-1] if inside_out else quad
        lines.append("f " + " ".join(f"{corner}//{corner}" for corner in order))
    (mesh,) = read_model(_write(tmp_path / "box.obj", "\n".join(lines) + "\n")).parts.values()
    assert mesh.volume() == pytest.approx(1.0)
    outward = mesh.points[mesh.indices] - mesh.points.mean(axis=0)
    assert mesh.normals is not None
    assert np.einsum("ij,ij->i", outward, mesh.normals).min() > 0.5


def test_a_sheet_is_seen_from_both_sides(tmp_path: Path) -> None:
    text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"
    assert read_model(_write(tmp_path / "flat.obj", text), size=(1, 1, 1)).double_sided


def test_names_become_unique_and_valid() -> None:
    titles = ["leg", "leg", "3 pieds", "Straße", "", "leg_1", "лампа"]
    assert prim_names(titles) == ["leg", "leg_1", "_3_pieds", "Stra_e", "part", "leg_1_1", "part_1"]


def _glb(header: bytes, length: int | None = None) -> bytes:
    header += b" " * (-len(header) % 4)
    total = 20 + len(header) if length is None else length
    return struct.pack("<4sIIII", b"glTF", 2, total, len(header), 0x4E4F534A) + header


BROKEN = {
    "empty.obj": b"",
    "words.obj": b"v 0 0 zero\n",
    "index.obj": b"v 0 0 0\nf 1 2 3\n",
    "short.obj": b"v 0 0\nv 0 0\nv 1 1\nf 1 2 3\n",
    "two.obj": b"v 0 0 0\nv 1 0 0\nf 1 2\n",
    "nan.obj": b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "inf.obj": b"v 1e999 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "flat.obj": b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n",
    "points.obj": b"v 0 0 0\nv 1 0 0\n",
    "huge.obj": b"v 0 0 0\nv 1e7 0 0\nv 0 1e7 0\nf 1 2 3\n",
    "binary.obj": bytes(range(256)) * 8,
    "empty.glb": b"",
    "words.glb": b"this is no glTF file at all",
    "truncated.glb": _glb(b"{}", 10_000),
    "json.glb": _glb(b"{[}"),
    "list.glb": _glb(b"[1, 2]"),
    "nothing.glb": _glb(b'{"asset": {"version": "2.0"}}'),
    "empty.ply": b"",
    "cut.ply": b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n",
    "points.ply": b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
    b"property float z\nend_header\n0 0 0\n",
    "words.usda": b"this is no USD",
    "empty.usda": b"#usda 1.0\n",
    "words.usdz": b"PK",
    "model.fbx": b"",
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_are_input_errors_with_a_remedy(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(BROKEN[name])
    with pytest.raises(InputError) as caught:
        read_model(path)
    assert name in str(caught.value.place)
    assert caught.value.remedy


def test_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_model(tmp_path / "none.obj")


def test_mistakes_in_obj_have_a_line(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        read_model(_write(tmp_path / "bad.obj", "v 0 0 0\n\nf 1 2 9\n"))
    assert str(caught.value.place).endswith("bad.obj:3")


def test_draco_without_its_decoder_names_the_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    header = json.dumps({"extensionsRequired": ["KHR_draco_mesh_compression"]}).encode()
    (tmp_path / "packed.glb").write_bytes(_glb(header))
    with pytest.raises(MissingPackageError, match="Draco") as caught:
        read_model(tmp_path / "packed.glb")
    assert "openrooms-usd[draco]" in str(caught.value)


@pytest.mark.parametrize(
    "folder", ["furniture_glb", "ikea_furniture_parts/assembled", "sweethome3d_furniture/resources"]
)
def test_real_models(folder: str, real: Callable[[str], Path], tmp_path: Path) -> None:
    files = [path for path in sorted(real(folder).iterdir()) if path.suffix in {".obj", ".glb"}]
    assert len(files) > 4
    for path in files:
        check_real_model(path, tmp_path / path.stem)


def check_real_model(path: Path, folder: Path) -> None:
    model = read_model(path, size=(1.0, 0.5, 2.0))
    np.testing.assert_allclose(model.extent, [[-0.5, -0.25, 0], [0.5, 0.25, 2]], atol=1e-9)
    stage = Usd.Stage.Open(str(folder / publish(folder, Asset("chair", (), lambda: model))))
    assert sum(prim.IsA(UsdGeom.Mesh) for prim in stage.Traverse()) == len(model.parts)
    for mesh in model.parts.values():
        assert np.isfinite(mesh.points).all()
        assert np.abs(np.linalg.norm(mesh.normals, axis=1) - 1).max() < 1e-4


SHEET = (
    "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 1 {t}\nvt 0 {t}\nf 1/1 2/2 3/3 4/4\n"
)


def test_good_coordinates_of_a_file_are_kept_in_metres(tmp_path: Path) -> None:
    model = read_model(_write(tmp_path / "sheet.obj", SHEET.format(t=1)))
    assert not model.notes
    (mesh,) = model.parts.values()
    # Two metres of the file under one unit of its texture; the projection would centre them.
    np.testing.assert_allclose([mesh.st.min(axis=0), mesh.st.max(axis=0)], [[0, 0], [2, 2]])


@pytest.mark.parametrize(("t", "reason"), [("0", "no place in the texture"), ("9", "stretch")])
def test_useless_coordinates_of_a_file_are_projected_and_reported(
    tmp_path: Path, t: str, reason: str
) -> None:
    model = read_model(_write(tmp_path / "sheet.obj", SHEET.format(t=t)))
    (mesh,) = model.parts.values()
    np.testing.assert_allclose(np.ptp(mesh.st, axis=0), [2, 2], atol=1e-6)
    (note,) = model.notes
    assert reason in note and note.endswith("; projected")


def test_coordinates_of_a_part_with_pictures_are_its_own(tmp_path: Path) -> None:
    write_png(tmp_path / "wood.png", np.zeros((2, 2, 3), np.uint8))
    _write(tmp_path / "sheet.mtl", "newmtl wood\nmap_Kd wood.png\n")
    text = "mtllib sheet.mtl\nusemtl wood\n"
    for t, number in (("9", 9.0), ("nan", 2.0)):
        model = read_model(_write(tmp_path / "sheet.obj", text + SHEET.format(t=t)))
        (mesh,) = model.parts.values()
        assert np.ptp(mesh.st[:, 1]) == pytest.approx(number, abs=1e-6)
        assert len(model.notes) == 1


@pytest.mark.one_in(3, rest="long")
@pytest.mark.parametrize("category", CATEGORIES)
def test_texture_coordinates_of_furniture_are_metric_and_hardly_stretched(category: str) -> None:
    spec = CATEGORIES[category]
    for style in spec.styles:
        # In its category's usual size, where the style is for such sizes.
        suits = spec.styles[style].suits(spec.size)
        rng = np.random.default_rng(0)
        made = make(category, spec.size, style, rng) if suits else piece(category, style)
        for name, mesh in made.parts.items():
            quality = uv_quality(mesh)
            assert quality.finite and quality.folded < 1e-6, (style, name)
            assert 0.7 < quality.density < 1.4, (style, name, quality)
            assert quality.stretch < 1.6, (style, name, quality)
