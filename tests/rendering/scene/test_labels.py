"""Labels, and the report of what is not in the picture."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdShade

from openrooms_usd.usd.semantics import NYU40, OPENROOMS45, label, label_part
from tests import small
from tests.small import square

LABELS = tuple(
    "semantic semantic_nyu40 semantic_ade20k semantic_coco instance part material".split()
)


def shelf():
    """Two labelled chairs of two parts each, an unlabelled box, all in a row along X."""
    made = small.Stage()
    for paint in ("red", "blue"):
        made.material(f"/Materials/{paint}", base_color=(0.5, 0.1, 0.1))
    for number in range(2):
        chair = UsdGeom.Xform.Define(made.stage, f"/World/chair_{number}")
        chair.AddTranslateOp().Set(Gf.Vec3d(2.0 * number, 0, 0))
        label(chair.GetPrim(), "chair")
        for part, z in (("seat", 0.0), ("back", 1.0)):
            mesh = made.box(
                f"/World/chair_{number}/Geometry/{part}", 0.9, material="/Materials/red"
            )
            mesh.AddTranslateOp().Set(Gf.Vec3d(0, 0, z))
            label_part(mesh.GetPrim(), part)
    made.box("/World/plain", 0.9, at=(4, 0, 0))
    made.camera((2, -6, 0.5), (2, 0, 0.5))
    return made


def at(view, name, x, z):
    """The label of what is seen at a point of the plane y = -0.45."""
    K, pose = view.K, view.world_from_camera
    p = np.linalg.inv(pose) @ [x, -0.45, z, 1]
    column, row = (K @ p[:3])[:2] / p[2]
    return int(view.images[name].pixels[int(row), int(column), 0])


def test_labels_name_the_object_the_part_the_class_and_the_material(open_stage, shoot):
    made = shelf()
    view = shoot(made.stage, *LABELS)
    legend = open_stage(made.stage).legend
    for number in range(2):
        for part, z in (("seat", 0.0), ("back", 1.0)):
            where = (view, "instance", 2.0 * number, z)
            assert legend.instance[at(*where)] == f"/World/chair_{number}"
            assert legend.category[at(*where)] == "chair"
            path = legend.part[at(view, "part", 2.0 * number, z)]
            assert path == f"/World/chair_{number}/Geometry/{part}"
            assert at(view, "semantic", 2.0 * number, z) == OPENROOMS45.index("chair") == 21
            assert at(view, "semantic_nyu40", 2.0 * number, z) == NYU40.index("chair") == 5
            assert at(view, "semantic_ade20k", 2.0 * number, z) == 20
            assert at(view, "semantic_coco", 2.0 * number, z) == 62
            assert legend.material[at(view, "material", 2.0 * number, z)] == "/Materials/red"
    assert legend.instance[at(view, "instance", 4, 0)] == "/World/plain"
    assert at(view, "semantic", 4, 0) == 0
    assert at(view, "material", 4, 0) == 0
    assert legend.semantic == dict(enumerate(OPENROOMS45))
    assert legend.semantic_nyu40 == dict(enumerate(NYU40))
    assert (legend.semantic_ade20k[20], legend.semantic_coco[62]) == ("chair", "chair")
    for name in LABELS:
        assert (view.images[name].pixels % 1 == 0).all()


def test_subsets_have_materials_of_their_own(open_stage, shoot):
    made = shelf()
    mesh = UsdGeom.Mesh(made.stage.GetPrimAtPath("/World/chair_0/Geometry/seat"))
    # The third face of the box looks along -Y, at the camera.
    subset = UsdShade.MaterialBindingAPI(mesh).CreateMaterialBindSubset("front", [2])
    made.bind(subset.GetPrim(), "/Materials/blue")
    view = shoot(made.stage, *LABELS)
    legend = open_stage(made.stage).legend
    assert legend.material[at(view, "material", 0, 0)] == "/Materials/blue"
    assert legend.material[at(view, "material", 2, 0)] == "/Materials/red"


def test_the_points_of_an_instancer_are_objects(open_stage, shoot):
    made = small.Stage()
    instancer = UsdGeom.PointInstancer.Define(made.stage, "/World/Scatter")
    made.box("/World/Scatter/Prototypes/cube/Mesh", 0.9)
    label(made.stage.GetPrimAtPath("/World/Scatter/Prototypes/cube"), "cabinet")
    instancer.CreatePrototypesRel().AddTarget("/World/Scatter/Prototypes/cube")
    instancer.CreateProtoIndicesAttr([0, 0])
    instancer.CreatePositionsAttr([(0, 0, 0), (2, 0, 0)])
    made.camera((2, -6, 0.5), (2, 0, 0.5))
    view = shoot(made.stage, *LABELS)
    session = open_stage(made.stage)
    names = [session.legend.instance[at(view, "instance", x, 0)] for x in (0, 2)]
    assert names == ["/World/Scatter[0]", "/World/Scatter[1]"]
    assert at(view, "semantic", 0, 0) == OPENROOMS45.index("cabinet")
    assert not [row for row in session.report.losses() if "Prototypes" in row[0]]


def test_emission_is_masked_on_the_side_that_emits(shoot):
    made = small.Stage()
    made.box("/Bulb", 1.0)
    UsdLux.MeshLightAPI.Apply(made.stage.GetPrimAtPath("/Bulb"))
    made.quad("/Wall", square((0, 2, 0), 9, "-Y"))
    made.camera((0, -4, 0), (0, 0, 0))
    view = shoot(made.stage, "emission_mask", "instance")
    lit = view.images["instance"].pixels == view.images["instance"].pixels[12, 16]
    assert 0 < lit.mean() < 1
    assert np.array_equal(view.images["emission_mask"].pixels == 1, lit)
    light = made.light("Rect", "/Panel", 1.0, at=(0, -1, 0))
    light.AddRotateXOp().Set(90.0)  # from -Z to +Y: its back is seen, which is not there
    channels = ("emission_mask", "depth")
    behind = shoot(made.stage, *channels).images
    assert behind["emission_mask"].pixels[12, 16, 0] == 1
    assert behind["depth"].pixels[12, 16, 0] == pytest.approx(3.5, abs=1e-4)
    light.GetPrim().GetAttribute("xformOp:rotateX").Set(-90.0)
    front = shoot(made.stage, *channels).images
    assert front["emission_mask"].pixels[12, 16, 0] == 1
    assert front["depth"].pixels[12, 16, 0] == pytest.approx(3.0, abs=1e-4)


def test_what_is_hidden_is_not_seen_and_is_named(open_stage, shoot):
    made = small.Stage()
    hidden = {"/invisible": "invisible", "/proxy": "proxy", "/guide": "guide"}
    for number, path in enumerate(hidden):
        made.box(path, 0.9, at=(number, 0, 0))
    UsdGeom.Imageable(made.stage.GetPrimAtPath("/invisible")).MakeInvisible()
    for path in ("/proxy", "/guide"):
        UsdGeom.Imageable(made.stage.GetPrimAtPath(path)).CreatePurposeAttr(path[1:])
    made.box("/seen", 0.9, at=(3, 0, 0))
    UsdGeom.Imageable(made.stage.GetPrimAtPath("/seen")).CreatePurposeAttr("render")
    made.camera((1.5, -6, 0), (1.5, 0, 0))
    session = open_stage(made.stage)
    assert list(session.legend.instance.values()) == ["/seen"]
    rows = {path: (outcome, reason) for path, outcome, reason in session.report.rows}
    for path, reason in hidden.items():
        assert rows[path][0] == "skipped"
        assert reason in rows[path][1]
    assert (shoot(made.stage, "valid").images["valid"].pixels == 1).mean() < 0.2


@pytest.mark.parametrize(
    ("kind", "outcome"),
    [
        ("BasisCurves", "skipped"),
        ("Points", "skipped"),
        ("Volume", "skipped"),
        ("PortalLight", "translated"),
        ("GeometryLight", "skipped"),
        ("MadeUpType", "skipped"),
        ("Cube", "approximated"),  # it has no material
    ],
)
def test_every_kind_of_prim_is_accounted_for(open_stage, kind, outcome):
    made = small.Stage()
    made.stage.DefinePrim("/Thing", kind)
    rows = {path: found for path, found, _ in open_stage(made.stage).report.rows}
    assert rows["/Thing"] == outcome


def test_all_domes_are_used(open_stage):
    made = small.Stage()
    made.dome("/A")
    made.dome("/B")
    rows = {path: found for path, found, _ in open_stage(made.stage).report.rows}
    assert rows == {"/A": "translated", "/B": "translated"}


def test_display_color_stands_in_for_a_material(open_stage, shoot):
    made = small.Stage()
    box = made.box("/Box", 1.0)
    box.CreateDisplayColorAttr([(0.2, 0.4, 0.6)])
    made.camera((0, -4, 0), (0, 0, 0))
    color = shoot(made.stage, "base_color").images["base_color"].pixels[12, 16]
    assert np.allclose(color, (0.2, 0.4, 0.6))
    losses = {path: reason for path, _, reason in open_stage(made.stage).report.losses()}
    assert "displayColor" in losses["/Box"]


def test_an_empty_stage_renders_nothing(shoot):
    made = small.Stage()
    made.camera((0, -4, 0), (0, 0, 0))
    images = shoot(made.stage, "radiance", *LABELS, "depth", "normal").images
    assert all((image.pixels == 0).all() for image in images.values())


def test_without_a_camera_the_scene_is_framed(open_stage, shoot):
    made = small.Stage()
    made.box("/Box", 1.0)
    session = open_stage(made.stage)
    assert session.cameras == ()
    assert session.resolution == (640, 480)
    view = shoot(made.stage, "valid", camera=None)
    assert view.camera is None
    assert (view.images["valid"].pixels == 1).mean() > 0.1


def test_the_stage_says_its_cameras_and_its_resolution(open_stage, shoot):
    made = small.Stage()
    made.camera((0, -4, 0), (0, 0, 0), path="/Cameras/b")
    made.camera((0, -4, 0), (0, 0, 0), path="/Cameras/a")
    made.camera((0, -4, 0), (0, 0, 0), path="/Other/a")
    settings = made.stage.DefinePrim("/Render/Settings", "RenderSettings")
    settings.CreateAttribute("resolution", Sdf.ValueTypeNames.Int2).Set(Gf.Vec2i(320, 200))
    session = open_stage(made.stage)
    assert session.cameras == ("/Cameras/a", "/Cameras/b", "/Other/a")
    assert session.resolution == (320, 200)


def test_points_that_are_no_numbers_are_skipped(open_stage):
    made = small.Stage()
    made.mesh("/Broken", [(0, 0, 0), (1, 0, 0), (float("nan"), 1, 0)], [[0, 1, 2]])
    rows = {path: found for path, found, _ in open_stage(made.stage).report.rows}
    assert rows["/Broken"] == "skipped"


def test_a_mirrored_mesh_keeps_its_outside(shoot):
    made = small.Stage()
    UsdLux.MeshLightAPI.Apply(made.box("/Bulb", 1.0).GetPrim())
    mirrored = UsdGeom.Xformable(made.stage.GetPrimAtPath("/Bulb"))
    mirrored.AddScaleOp().Set(Gf.Vec3f(-1, 1, 1))
    made.camera((0.5, -4, 0.7), (0, 0, 0))
    assert shoot(made.stage, "emission_mask").images["emission_mask"].pixels[12, 16, 0] == 1


def test_an_unreadable_stage_path_is_a_usd_stage_nonetheless(open_stage):
    # A reference to a file that is missing leaves an empty prim, which is no reason to stop.
    made = small.Stage()
    prim = made.stage.DefinePrim("/Lost", "Xform")
    prim.GetReferences().AddReference("./nowhere.usda")
    assert open_stage(made.stage).legend.instance == {}
