"""What stands where in a GLB file is what stands there in the stage."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import trimesh
from pxr import Gf, Sdf, Usd, UsdGeom

from openrooms_usd.usd.meshes import read_meshes
from orusd_gltf import GltfExporter
from tests.gltf.conftest import Export
from tests.gltf.reading import Glb, read, volume
from tests.small import Stage

SHEAR = Gf.Matrix4d(1, 0.4, 0, 0, 0, 1, 0.3, 0, 0.2, 0, 1, 0, 0.5, 1, 2, 1)


def of_stage(stage: Usd.Stage) -> dict[str, np.ndarray]:
    """(M, 3, 3) corners in the world by the path where they stand, the front counter-clockwise."""
    found = {}
    for mesh in read_meshes(stage):
        corners = mesh.world_points()[mesh.mesh.triangles]
        found[mesh.path] = corners[:, ::-1] if mesh.mirrored else corners
    return found


def assert_same(glb: Glb, stage: Usd.Stage) -> None:
    ours, theirs = of_stage(stage), glb.triangles()
    assert theirs.keys() == ours.keys()
    for path, corners in ours.items():
        # Which corner of a triangle comes first says nothing.
        order = [np.roll(theirs[path], turn, axis=1) for turn in range(3)]
        off = np.min([np.abs(one - corners).max(axis=(1, 2)) for one in order], axis=0)
        assert off.max() < 1e-5, path


def test_meshes_stand_where_they_stood_whatever_moves_turns_mirrors_or_shears_them(
    export: Export,
) -> None:
    made = Stage(up="Y", metres=0.01)
    made.box("/A/plain", 30.0).AddTranslateOp().Set(Gf.Vec3d(100, 20, 3))
    UsdGeom.Xform.Define(made.stage, "/A").AddRotateXYZOp().Set(Gf.Vec3f(20, 30, 40))
    made.box("/A/mirrored", 20.0).AddScaleOp().Set(Gf.Vec3f(-1, 2, 3))
    made.box("/A/sheared", 20.0).AddTransformOp().Set(SHEAR)
    # Inside of a shear and a mirror, and out of all of it.
    UsdGeom.Xform.Define(made.stage, "/S").AddTransformOp().Set(SHEAR * Gf.Matrix4d().SetScale(-2))
    made.box("/S/child", 10.0).AddRotateZOp().Set(33.0)
    free = made.box("/S/free", 5.0)
    free.AddTranslateOp().Set(Gf.Vec3d(7, 8, 9))
    free.SetResetXformStack(True)
    UsdGeom.Sphere.Define(made.stage, "/Ball").CreateRadiusAttr(40.0)
    glb, report = export(made.stage)
    assert_same(glb, made.stage)
    assert all(volume(corners) > 0 for corners in glb.triangles().values())
    assert volume(glb.triangles()["/A/mirrored"]) == pytest.approx(6 * 0.2**3, rel=1e-4)
    assert report.count("skipped") == 0


def test_what_repeats_is_stored_once(export: Export) -> None:
    made = Stage()
    made.box("/Parts/chair/seat", 0.4)
    made.stage.GetPrimAtPath("/Parts").SetSpecifier(Sdf.SpecifierClass)
    for number in range(3):
        chair = UsdGeom.Xform.Define(made.stage, f"/World/chair_{number}")
        chair.AddTranslateOp().Set(Gf.Vec3d(number, 0, 0))
        chair.GetPrim().GetReferences().AddInternalReference("/Parts/chair")
        chair.GetPrim().SetInstanceable(True)
    scattered = UsdGeom.PointInstancer.Define(made.stage, "/World/Cups")
    made.box("/World/Cups/cup", 0.1)
    scattered.CreatePrototypesRel().SetTargets(["/World/Cups/cup"])
    scattered.CreateProtoIndicesAttr([0, 0])
    scattered.CreatePositionsAttr([(0, 1, 0), (0, 2, 1)])
    glb, _ = export(made.stage)
    assert_same(glb, made.stage)
    assert len(glb.json["meshes"]) == 2
    assert [node["name"] for node in glb.json["nodes"] if "mesh" in node].count("seat") == 3


def test_the_same_stage_gives_the_same_bytes(composed_demo: Path, tmp_path: Path) -> None:
    for name in ("a.glb", "b.glb"):
        GltfExporter().convert(Usd.Stage.Open(str(composed_demo)), tmp_path / name, {})
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()


def test_trimesh_reads_a_room_as_it_is(composed_demo: Path, tmp_path: Path) -> None:
    stage = Usd.Stage.Open(str(composed_demo))
    report = GltfExporter().convert(stage, tmp_path / "room.glb", {})
    assert_same(read(tmp_path / "room.glb"), stage)
    scene = trimesh.load_scene(tmp_path / "room.glb")
    ours = of_stage(stage)
    assert len(scene.graph.nodes_geometry) == len(ours)
    assert sum(len(g.faces) for g in scene.dump()) == sum(map(len, ours.values()))
    corners = np.concatenate(list(ours.values())).reshape(-1, 3)
    x, y, z = corners.T
    assert np.allclose(scene.bounds, [(x.min(), z.min(), -y.max()), (x.max(), z.max(), -y.min())])
    whole = sum(volume(corners) for corners in ours.values())
    assert sum(volume(g.triangles) for g in scene.dump()) == pytest.approx(whole, rel=1e-4)
    # Trimesh numbers what has the name of another.
    names = Counter(path.rpartition("/")[2].rstrip("_0123456789") for path in ours)
    found = (node.rstrip("_0123456789") for node in scene.graph.nodes_geometry)
    assert Counter(found) == names
    rows = {prim for prim, _, _ in report.rows}
    assert rows >= {str(p.GetPath()) for p in stage.Traverse() if p.IsA(UsdGeom.Gprim)}
