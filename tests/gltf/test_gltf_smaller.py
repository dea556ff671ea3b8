"""What is stored smaller on request is the same room, and says which readers it needs."""

import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from pxr import Gf, Sdf, Usd, UsdGeom

from openrooms_usd.errors import MissingPackageError
from openrooms_usd.usd.surfaces import Texture
from orusd_gltf import GltfExporter
from tests.gltf.conftest import Export
from tests.gltf.reading import Glb, local, read
from tests.gltf.test_gltf_materials import CORNERS, save
from tests.small import Stage


def written(scene: Path, target: Path, **options: str) -> Glb:
    GltfExporter().convert(Usd.Stage.Open(str(scene)), target, options)
    return read(target)


def test_draco_keeps_shapes_to_a_millimetre(composed_demo: Path, tmp_path: Path) -> None:
    plain = written(composed_demo, tmp_path / "plain.glb")
    packed = written(composed_demo, tmp_path / "packed.glb", compression="draco")
    assert packed.json["extensionsRequired"] == ["KHR_draco_mesh_compression"]
    vertices = len(plain.data) - sum(
        view["byteLength"] for view in plain.json["bufferViews"] if "target" not in view
    )
    pictures = len(plain.data) - vertices
    assert len(packed.data) - pictures < 0.2 * vertices
    ours, theirs = (trimesh.load_scene(tmp_path / f"{n}.glb") for n in ("plain", "packed"))
    assert ours.geometry.keys() == theirs.geometry.keys()
    for name, shape in ours.geometry.items():
        other = theirs.geometry[name]
        assert len(other.faces) == len(shape.faces)
        assert np.abs(other.bounds - shape.bounds).max() < 1e-3
        assert other.area == pytest.approx(shape.area, rel=0.02)
        uv, wanted = other.visual.uv, shape.visual.uv
        assert (uv is None) == (wanted is None)
        if uv is not None:
            assert np.abs(np.ptp(uv, axis=0) - np.ptp(wanted, axis=0)).max() < 1e-2


def test_draco_is_asked_for_where_it_is_missing(
    export: Export, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    made = Stage()
    made.box("/Box", 1.0)
    with pytest.raises(MissingPackageError) as told:
        export(made.stage, {"compression": "draco"})
    assert "draco" in str(told.value.remedy)


def test_one_node_draws_all_places_of_a_mesh(export: Export) -> None:
    made = Stage()
    made.box("/Parts/chair/seat", 0.4)
    made.stage.GetPrimAtPath("/Parts").SetSpecifier(Sdf.SpecifierClass)
    places = [(0.0, 0.0, 0.0, 1.0), (1.0, 2.0, 30.0, 1.0), (2.0, 0.0, 80.0, 2.0), (3.0, 1.0, 0, -1)]
    for number, (x, y, turn, size) in enumerate(places):
        chair = UsdGeom.Xform.Define(made.stage, f"/World/chair_{number}")
        chair.AddTranslateOp().Set(Gf.Vec3d(x, y, 0.5))
        chair.AddRotateXYZOp().Set(Gf.Vec3f(10, 20, turn))
        chair.AddScaleOp().Set(Gf.Vec3f(size, abs(size), 1.5))
        chair.GetPrim().GetReferences().AddInternalReference("/Parts/chair")
        chair.GetPrim().SetInstanceable(True)
    plain, _ = export(made.stage)
    glb, _ = export(made.stage, {"instances": "gpu"})
    assert glb.json["extensionsRequired"] == ["EXT_mesh_gpu_instancing"]
    worlds = {n["extras"]["prim"]: world for n, world in plain.placed() if "mesh" in n}
    (drawn, rest) = sorted(
        (n for n in glb.json["nodes"] if "mesh" in n), key=lambda n: "extensions" not in n
    )
    # The mirrored one has a node of its own.
    assert rest["extras"]["prim"] == "/World/chair_3/seat"
    said = drawn["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]
    columns = {name.lower(): glb.accessor(number) for name, number in said.items()}
    for row, prim in enumerate(drawn["extras"]["prims"]):
        world = local({name: values[row] for name, values in columns.items()})
        assert np.allclose(world, worlds[prim], atol=1e-6)
    assert len(drawn["extras"]["prims"]) == 3
    names = [node["name"] for node in glb.json["nodes"]]
    assert names.count("seat") == 4


@pytest.mark.parametrize("form", ["jpeg", "webp"])
def test_pictures_are_stored_smaller(form: str, export: Export, tmp_path: Path) -> None:
    made = Stage()
    rows, columns = np.mgrid[0:64, 0:64] / 64.0
    codes = np.stack([rows, columns, 0.5 + 0 * rows, 1 - rows], axis=-1)
    codes = np.round(codes * 255).astype(np.uint8)
    color = Texture(save(tmp_path / "color.png", codes[..., :3]), color_space="sRGB")
    clear = Texture(save(tmp_path / "clear.png", codes[..., 3:]), channel="r")
    made.quad("/Plain", CORNERS, material=made.material("/M", base_color=color))
    leaf = made.material("/Leaf", base_color=color, opacity=clear)
    made.quad("/Cut", CORNERS, material=leaf)
    glb, _ = export(made.stage, {"pictures": form})
    kinds = [image["mimeType"] for image in glb.json["images"]]
    assert kinds == [f"image/{form}", "image/png" if form == "jpeg" else "image/webp"]
    assert ("extensionsRequired" in glb.json) == (form == "webp")
    for number, channels in ((0, 3), (1, 4)):
        shown = glb.picture({"index": number}, tmp_path)
        assert np.abs(shown - codes[..., :channels] / 255.0).mean() < 0.02
