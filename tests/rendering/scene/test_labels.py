"""Labels, and the report of what is not in the picture."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdShade

from openrooms_usd.rendering.scene.moving import MovingScene
from openrooms_usd.rendering.scene.translate import translate
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


def said_of(stage):
    """(object, its category, OpenRooms' class) by where each part stands."""
    scene = translate(stage)
    legend = scene.legend
    return {
        legend.part[piece.part]: (
            legend.instance[piece.instance],
            legend.category.get(piece.instance),
            legend.semantic[piece.semantic],
        )
        for piece in scene.pieces
    }


def scattered(made, path, *prototypes, chosen=(0,)):
    instancer = UsdGeom.PointInstancer.Define(made.stage, path)
    instancer.CreatePrototypesRel().SetTargets(list(prototypes))
    instancer.CreateProtoIndicesAttr(list(chosen))
    instancer.CreatePositionsAttr([(2.0 * place, 0, 0) for place in range(len(chosen))])
    return instancer.GetPrim()


def test_a_label_on_a_prototype_makes_each_instance_an_object():
    made = small.Stage()
    made.box("/World/Scatter/Prototypes/cube/Mesh", 0.9)
    label(made.stage.GetPrimAtPath("/World/Scatter/Prototypes/cube"), "cabinet")
    scattered(made, "/World/Scatter", "/World/Scatter/Prototypes/cube", chosen=(0, 0))
    assert said_of(made.stage) == {
        f"/World/Scatter[{n}]/Mesh": (f"/World/Scatter[{n}]", "cabinet", "cabinet") for n in (0, 1)
    }
    losses = translate(made.stage).report.losses()
    assert not [row for row in losses if "Prototypes" in row[0]]


def test_labelled_instancers_are_objects_of_their_own():
    made = small.Stage()
    for name, word in (("Chairs", "chair"), ("Tables", "table")):
        made.box(f"/World/{name}/Prototype", 0.5)
        label(scattered(made, f"/World/{name}", f"/World/{name}/Prototype"), word)
    # One takes the prototype of another, and the parents of that are not its own.
    label(scattered(made, "/World/Beds", "/World/Chairs/Prototype"), "bed")
    scattered(made, "/World/Plain", "/World/Shelf/Prototype", "/World/Chairs/Prototype")
    made.box("/World/Shelf/Prototype", 0.5)
    made.stage.GetPrimAtPath("/World/Shelf").SetSpecifier(Sdf.SpecifierClass)
    label(made.stage.GetPrimAtPath("/World/Shelf"), "bench")
    assert said_of(made.stage) == {
        "/World/Chairs[0]": ("/World/Chairs", "chair", "chair"),
        "/World/Tables[0]": ("/World/Tables", "table", "table"),
        "/World/Beds[0]": ("/World/Beds", "bed", "bed"),
        "/World/Plain[0]": ("/World/Plain[0]", "bench", "bench"),
    }


def test_a_label_above_an_instancer_is_of_what_it_scatters_alone():
    made = small.Stage()
    made.box("/World/Tree/Scatter/Prototypes/Leaf", 0.5)
    scattered(made, "/World/Tree/Scatter", "/World/Tree/Scatter/Prototypes/Leaf", chosen=(0, 0))
    label(made.stage.GetPrimAtPath("/World/Tree"), "sofa")
    made.box("/World/plain", 0.5)
    of_tree = {f"/World/Tree/Scatter[{n}]": ("/World/Tree", "sofa", "sofa") for n in (0, 1)}
    plain = {"/World/plain": ("/World/plain", None, "unlabeled")}
    assert said_of(made.stage) == of_tree | plain
    # Nearer is what stands between the instancer and its prototype.
    label(made.stage.GetPrimAtPath("/World/Tree/Scatter/Prototypes"), "chair")
    assert said_of(made.stage)["/World/Tree/Scatter[1]"] == (
        "/World/Tree/Scatter[1]",
        "chair",
        "chair",
    )


def test_labels_in_instancers_within_instancers():
    made = small.Stage()
    scattered(made, "/World/Outer", "/World/Outer/Inner", chosen=(0, 0))
    inner = ("/World/Outer/Inner/One", "/World/Outer/Inner/Two")
    for path in inner:
        made.box(path, 0.5)
    label(scattered(made, "/World/Outer/Inner", *inner, chosen=(0, 1)), "chair")
    label(made.stage.GetPrimAtPath(inner[1]), "table")
    chair, table = ("chair", "chair"), ("table", "table")
    assert said_of(made.stage) == {
        f"/World/Outer[{n}][{m}]": (f"/World/Outer[{n}]{of}", *what)
        for n in (0, 1)
        for m, of, what in ((0, "", chair), (1, "[1]", table))
    }


def test_labels_where_instancers_and_native_instances_meet():
    made = small.Stage()
    stage = made.stage
    stage.CreateClassPrim("/Asset")
    made.box("/Asset/Scatter/Prototype", 0.5)
    label(scattered(made, "/Asset/Scatter", "/Asset/Scatter/Prototype"), "chair")
    stage.CreateClassPrim("/Lamp")
    label(made.box("/Lamp/Bulb", 0.5).GetPrim(), "lamp")
    for path, asset in (("/World/a", "/Asset"), ("/World/S/P/b", "/Lamp")):
        prim = stage.DefinePrim(path, "Xform")
        prim.GetReferences().AddInternalReference(asset)
        prim.SetInstanceable(True)
    scattered(made, "/World/S", "/World/S/P")
    assert said_of(stage) == {
        "/World/a/Scatter[0]": ("/World/a/Scatter", "chair", "chair"),
        "/World/S[0]/b/Bulb": ("/World/S[0]/b/Bulb", "lamp", "lamp"),
    }
    label(stage.GetPrimAtPath("/World/S"), "desk")
    assert said_of(stage)["/World/S[0]/b/Bulb"][0] == "/World/S[0]/b/Bulb"


def test_what_an_instancer_scatters_moves_with_it():
    made = small.Stage()
    made.box("/World/S/P", 0.5)
    scattered(made, "/World/S", "/World/S/P")
    moving = MovingScene(translate(made.stage))
    aside = np.eye(4)
    aside[0, 3] = 3.0
    assert moving.move({"/World/S": aside})
    moved = moving.scene.patches[0].triangles.hull[:, 0]
    assert (moved.min(), moved.max()) == pytest.approx((2.75, 3.25))


def test_what_is_called_like_a_prototype_is_named_all_the_same():
    made = small.Stage()
    made.box("/World/P", 0.5)
    scattered(made, "/World/S", "/World/P")
    UsdGeom.Imageable(made.box("/World/Post", 0.5)).MakeInvisible()
    assert "/World/Post" in [row[0] for row in translate(made.stage).report.losses()]


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
