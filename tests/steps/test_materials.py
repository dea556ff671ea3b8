"""The materials step: everything is bound, repeats share, overrides hold, bytes never depend."""

import hashlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdShade, UsdUtils, UsdValidation

from openrooms_usd import names
from openrooms_usd.description.room import Room
from openrooms_usd.errors import DescriptionError
from openrooms_usd.furniture import category
from openrooms_usd.furniture.registry import records
from openrooms_usd.library.styles.finishes import ANY, FINISHES, GENERIC, METALS, PARTS, finishes_of
from openrooms_usd.library.textures import FAMILIES, substance_of
from openrooms_usd.steps import runner
from openrooms_usd.steps.alignment.step import AlignmentStep
from openrooms_usd.steps.draft import drafting
from openrooms_usd.steps.layout.step import LayoutStep
from openrooms_usd.steps.materials.step import MaterialsStep
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import Texture, bound_material

OBJECTS = [
    {"name": "table", "category": "table", "at": [2.0, 1.5]},
    {"name": "chair_a", "category": "chair", "at": [2.0, 0.7], "style": "slat"},
    {"name": "chair_b", "category": "chair", "at": [2.0, 2.3], "style": "slat", "yaw": 180},
    {"name": "chair_c", "category": "chair", "at": [3.2, 1.5], "style": "slat", "yaw": 90},
    {"name": "sofa", "category": "sofa", "at": [4.0, 3.3]},
    {"name": "cabinet", "category": "cabinet", "at": [0.6, 3.6], "style": "doors"},
    {"name": "lamp", "category": "floor_lamp", "at": [5.4, 3.4]},
]
OPENINGS = [
    {"kind": "window", "name": "window", "wall": 0},
    {"kind": "door", "name": "door", "wall": 2, "open": 40},
]


def room(**materials: object) -> Room:
    return Room.model_validate(
        {
            "seed": 11,
            "layout": {"polygon": [[0, 0], [6, 0], [6, 4], [0, 4]], "openings": OPENINGS},
            "furniture": {"objects": OBJECTS},
            "materials": {"resolution": 16, "floor": "oak_planks", **materials},
        }
    )


def compose(folder: Path, described: Room, *, workers: int = 1) -> Usd.Stage:
    with drafting(folder) as draft:
        runner.create_edits(draft)
        for step in (LayoutStep(), AlignmentStep(), MaterialsStep()):
            runner.run(step, described, folder, draft, "fingerprint", workers)
        runner.write_scene(draft)
    stage = Usd.Stage.Open(str(folder / names.SCENE))
    # USD caches layers by name, also those that were written again since then.
    stage.Reload()
    return stage


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Usd.Stage:
    return compose(tmp_path_factory.mktemp("plain"), room())


def surfaces(stage: Usd.Stage) -> list[Usd.Prim]:
    prims = Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies())
    return [prim for prim in prims if prim.IsA(UsdGeom.Gprim)]


def material_of(stage: Usd.Stage, path: str) -> UsdShade.Material:
    material = bound_material(stage.GetPrimAtPath(path))
    assert material is not None
    return material


def substance(stage: Usd.Stage, path: str) -> str:
    return str(attribute(stage, path, "category"))


def attribute(stage: Usd.Stage, path: str, name: str) -> object:
    return material_of(stage, path).GetPrim().GetAttribute(f"openrooms:material:{name}").Get()


def test_every_surface_has_a_material_that_reads_without_loss(plain: Usd.Stage) -> None:
    assert len(surfaces(plain)) > 30
    for prim in surfaces(plain):
        material = bound_material(prim)
        assert material is not None, prim.GetPath()
        surface, losses = read_preview_surface(material)
        assert losses == ()
        if isinstance(surface.base_color, Texture):
            for texture in (surface.base_color, surface.roughness, surface.normal):
                assert isinstance(texture, Texture) and Path(texture.file).is_file()
            assert (
                "OpenRoomsMaterialAPI"
                in material.GetPrim().GetPrimTypeInfo().GetAppliedAPISchemas()
            )
            size = material.GetPrim().GetAttribute("openrooms:material:size").Get()
            np.testing.assert_allclose(1.0 / np.array(size), surface.base_color.uv_scale, 1e-6)


def test_the_core_validators_find_nothing_in_the_materials(plain: Usd.Stage) -> None:
    registry = UsdValidation.ValidationRegistry()
    errors = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators()).Validate(plain)
    found = [str(error.GetIdentifier()) + error.GetMessage() for error in errors]
    assert [text for text in found if "hade" in text or "aterial" in text] == []
    assert plain.GetCompositionErrors() == []


def test_repeats_share_a_prototype_and_its_material(plain: Usd.Stage) -> None:
    chairs = [plain.GetPrimAtPath(f"{names.FURNITURE}/chair_{x}") for x in "abc"]
    assert len({chair.GetPrototype().GetPath() for chair in chairs}) == 1
    seats = [bound_material(chair.GetPrimAtPath("Geometry/seat")) for chair in chairs]
    assert len({read_preview_surface(seat)[0] for seat in seats}) == 1  # type: ignore[arg-type]


def test_the_rules_of_the_room_and_the_furniture(plain: Usd.Stage) -> None:
    assert attribute(plain, names.FLOOR, "family") == "oak_planks"
    assert substance(plain, names.CEILING) == "paint"
    walls = {material_of(plain, f"{names.WALLS}/wall_{i}").GetPath() for i in range(4)}
    assert len(walls) == 1
    assert substance(plain, f"{names.OPENINGS}/window/Frame") == "paint"
    for prim in surfaces(plain):
        part = read_label(prim, names.PART)
        if part in ("seat_cushion", "back_cushion", "lamp_shade"):
            assert substance(plain, str(prim.GetPath())) == "fabric"
        if part in ("handle", "lamp_pole"):
            surface, _ = read_preview_surface(bound_material(prim))  # type: ignore[arg-type]
            dark = "powder" in str(getattr(surface.base_color, "file", ""))
            assert surface.f0 == pytest.approx(0.05)
            assert surface.metallic == 1.0 or dark


def test_floorboards_run_along_the_longer_side(tmp_path: Path, plain: Usd.Stage) -> None:
    def grain(stage: Usd.Stage) -> np.ndarray:
        texture = read_preview_surface(material_of(stage, names.FLOOR))[0].base_color
        assert isinstance(texture, Texture)
        # Which direction of the floor moves along the picture's t, the grain?
        return np.abs(np.linalg.inv(texture.uv_matrix[:2, :2]) @ [0.0, 1.0])

    assert grain(plain)[0] > grain(plain)[1]
    turned = room().model_copy(
        update={
            "layout": Room.model_validate(
                {"layout": {"polygon": [[0, 0], [4, 0], [4, 6], [0, 6]]}}
            ).layout
        }
    )
    deep = compose(tmp_path, turned)
    assert grain(deep)[1] > grain(deep)[0]


def test_overrides_reach_one_object_alone(tmp_path: Path) -> None:
    green = {"family": "paint", "color": [0.1, 0.3, 0.1], "roughness": 0.5}
    stage = compose(
        tmp_path,
        room(overrides={"chair_b": {"seat": "fabric", "all": green}, "lamp": {"all": green}}),
    )
    chair = f"{names.FURNITURE}/chair_b/Geometry"
    assert substance(stage, f"{chair}/seat") == "fabric"
    assert substance(stage, f"{chair}/leg_0") == "paint"
    assert attribute(stage, f"{chair}/leg_0", "family") in FINISHES["lacquer"].families
    others = [stage.GetPrimAtPath(f"{names.FURNITURE}/chair_{x}") for x in "ac"]
    own = stage.GetPrimAtPath(f"{names.FURNITURE}/chair_b")
    assert others[0].GetPrototype() == others[1].GetPrototype() != own.GetPrototype()
    assert own.IsInstance()
    # All of a lamp is painted, but for what shines.
    assert substance(stage, f"{names.FURNITURE}/lamp/Geometry/light_bulb") == "specular_stone"


def test_given_colors_and_families_are_used(tmp_path: Path) -> None:
    from openrooms_usd.usd.shading.textures import read_texture

    wall = {"family": "paint", "color": [0.3, 0.5, 0.7], "roughness": 0.8}
    stage = compose(tmp_path, room(walls=wall, floor="fabric", texture_size="50 cm"))
    surface, _ = read_preview_surface(material_of(stage, f"{names.WALLS}/wall_0"))
    assert isinstance(surface.base_color, Texture) and isinstance(surface.roughness, Texture)
    srgb = read_texture(surface.base_color.file).mean(axis=(0, 1))
    expected = [1.055 * c ** (1 / 2.4) - 0.055 for c in wall["color"]]  # type: ignore[attr-defined]
    np.testing.assert_allclose(srgb, expected, atol=0.01)
    assert read_texture(surface.roughness.file).mean() == pytest.approx(0.8, abs=0.02)
    assert substance(stage, names.FLOOR) == "fabric"
    # Every repeat covers 50 cm.
    assert surface.base_color.uv_scale == pytest.approx((2.0, 2.0))


def test_more_objects_change_nothing_of_the_others(tmp_path: Path, plain: Usd.Stage) -> None:
    more = room().model_dump(by_alias=True)
    more["furniture"]["objects"] = [
        {"name": "bed", "category": "cabinet", "at": [1, 1], "style": "shelves"},
        *OBJECTS,
    ]
    stage = compose(tmp_path, Room.model_validate(more))
    for prim in surfaces(plain):
        path = str(prim.GetPath())
        assert material_of(stage, path).GetPath() == material_of(plain, path).GetPath()


@pytest.mark.slow
def test_bytes_never_depend_on_workers_or_on_what_was_there(tmp_path: Path) -> None:
    def digests(folder: Path) -> dict[str, str]:
        files = sorted(path for path in (folder / "layers").rglob("*") if path.is_file())
        return {
            str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in files
        }

    compose(tmp_path / "one", room())
    compose(tmp_path / "four", room(), workers=4)
    compose(tmp_path / "again", room(floor="paint"))
    compose(tmp_path / "again", room())
    assert digests(tmp_path / "one") == digests(tmp_path / "four") == digests(tmp_path / "again")


def test_layers_are_anchored_and_hold_no_absolute_path(plain: Usd.Stage) -> None:
    looks = [
        Path(layer.realPath)
        for layer in plain.GetUsedLayers()
        if layer.realPath and "/materials" in layer.realPath
    ]
    assert len(looks) > 5
    for path in looks:
        layer = Sdf.Layer.FindOrOpen(str(path))
        for dependency in layer.GetExternalReferences():
            assert dependency.startswith(("./", "../"))
        for found in UsdUtils.ExtractExternalReferences(str(path)):
            assert all(name.startswith(("./", "../")) for name in found)


def test_names_that_are_not_there_are_refused(tmp_path: Path, plain: Usd.Stage) -> None:
    with pytest.raises(DescriptionError, match=r"chair_a has no part 'sead' \(did you mean 'seat'"):
        compose(tmp_path, room(overrides={"chair_a": {"sead": "wood"}}))
    captured = room().model_copy(
        update={
            "materials": room().materials.model_copy(
                update={"overrides": {"chiar_a": room().materials.overrides}}
            )
        }
    )
    with pytest.raises(DescriptionError, match=r"'chiar_a' \(did you mean 'chair_a'"):
        compose(tmp_path, captured)


def test_openings_can_be_overridden_too(tmp_path: Path) -> None:
    described = room()
    wooden = room(overrides={"lamp": {"base": "wood"}}).materials.overrides["lamp"]["base"]
    materials = described.materials.model_copy(update={"overrides": {"door": {"panel": wooden}}})
    stage = compose(tmp_path, described.model_copy(update={"materials": materials}))
    assert substance(stage, f"{names.OPENINGS}/door/Leaf/Panel") == "wood"
    assert substance(stage, f"{names.OPENINGS}/door/Frame") == "paint"


@pytest.fixture
def painted_box(tmp_path: Path) -> Path:
    """A user's model whose one mesh has its own material, and whose other has none."""
    stage = Usd.Stage.CreateNew(str(tmp_path / "box.usda"))
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, "/Box").GetPrim()
    stage.SetDefaultPrim(root)
    for index, name in enumerate(("own", "bare")):
        mesh = UsdGeom.Mesh.Define(stage, f"/Box/{name}")
        corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 1)]
        mesh.CreatePointsAttr([(x + index, y, z) for x, y, z in corners])
        mesh.CreateFaceVertexCountsAttr([3, 3])
        mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 0, 2, 3])
    material = UsdShade.Material.Define(stage, "/Box/Red")
    shader = UsdShade.Shader.Define(stage, "/Box/Red/S")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set((1.0, 0.0, 0.0))
    material.CreateSurfaceOutput().ConnectToSource(
        shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    )
    UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath("/Box/own")).Bind(material)
    stage.Save()
    return tmp_path


def boxed(**materials: object) -> Room:
    described = room(**materials).model_dump(by_alias=True)
    described["furniture"]["objects"] = [
        {"from": "file", "name": "lamp", "category": "gadget", "file": "box.usda", "at": [1, 1]}
    ]
    return Room.model_validate(described)


def test_what_is_bound_already_stays_unless_overridden(painted_box: Path) -> None:
    stage = compose(painted_box, boxed())
    box = f"{names.FURNITURE}/lamp/Geometry"
    assert read_preview_surface(material_of(stage, f"{box}/own"))[0].base_color == (1.0, 0.0, 0.0)
    assert substance(stage, f"{box}/bare") == "paint"
    stage = compose(painted_box, boxed(overrides={"lamp": {"own": "wood"}}))
    assert substance(stage, f"{box}/own") == "wood"


def test_human_bindings_stay(tmp_path: Path) -> None:
    layers = tmp_path / names.LAYERS
    layers.mkdir()
    edits = Usd.Stage.CreateNew(str(layers / "edits.usda"))
    mine = UsdShade.Material.Define(edits, "/World/Mine")
    UsdShade.MaterialBindingAPI.Apply(edits.OverridePrim(names.FLOOR)).Bind(mine)
    edits.Save()
    stage = compose(tmp_path, room())
    assert str(material_of(stage, names.FLOOR).GetPath()) == "/World/Mine"
    written = Sdf.Layer.FindOrOpen(str(layers / "materials.usda"))
    assert written.GetPrimAtPath(names.FLOOR) is None


@pytest.mark.slow
def test_an_override_outdoes_the_subsets_of_a_mesh(tmp_path: Path) -> None:
    layers = tmp_path / names.LAYERS
    layers.mkdir()
    edits = Usd.Stage.CreateNew(str(layers / "edits.usda"))
    mesh = UsdGeom.Mesh.Define(edits, f"{names.FURNITURE}/found/shell")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    mine = UsdShade.Material.Define(edits, f"{names.FURNITURE}/found/Mine")
    api = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim())
    subset = api.CreateMaterialBindSubset("part", [0])
    UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(mine)
    edits.Save()
    shown = f"{names.FURNITURE}/found/shell/part"
    stage = compose(tmp_path, room())
    assert material_of(stage, shown).GetPath().name == "Mine"
    described = room(overrides={"lamp": {"all": "wood"}})
    overrides = {"found": described.materials.overrides["lamp"]}
    materials = described.materials.model_copy(update={"overrides": overrides})
    stage = compose(tmp_path, described.model_copy(update={"materials": materials}))
    assert substance(stage, shown) == "wood"


def test_every_finish_can_be_made_and_every_rule_names_one() -> None:
    for finish in FINISHES.values():
        assert {substance_of(name) for name in finish.families} <= {finish.substance}
        assert finish.families or (finish.colors and finish.roughness)
    assert {FINISHES[name].substance: name for name in GENERIC.values()} == GENERIC
    assert set(GENERIC) == set(FAMILIES)
    known = {*FINISHES, "metal"}
    assert set(METALS) <= set(FINISHES)
    assert set(PARTS.values()) <= known
    for _, told in records():
        for scheme in told.schemes:
            assert set(scheme.finishes.values()) <= known and ANY in scheme.finishes


def test_schemes_are_drawn_by_their_weights() -> None:
    rng = np.random.Generator(np.random.PCG64(0))
    drawn = [finishes_of("chair", ["seat", "leg"], rng)["seat"] for _ in range(500)]
    share = drawn.count("bent_wood") / 500
    fitting = [s for s in category("chair").schemes if s.needs is None]
    expected = sum(s.weight for s in fitting if s.finishes[ANY] == "bent_wood")
    assert share == pytest.approx(expected / sum(s.weight for s in fitting), abs=0.07)
    assert finishes_of("thing", ["knob"], rng) == {"knob": "lacquer"}
    assert finishes_of("sofa", ["rail", "seat_cushion"], rng)["seat_cushion"] == "upholstery"


def test_the_whole_is_clean(
    tmp_path: Path, composed_demo: Path, assert_valid: Callable[..., None]
) -> None:
    assert_valid(composed_demo)
