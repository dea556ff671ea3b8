"""Each rule finds exactly what breaks it, and a clean room breaks none."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from click.testing import CliRunner
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.cli.validating import validate
from openrooms_usd.errors import InputError
from openrooms_usd.rules import RULES
from openrooms_usd.rules import validate_stage as validate_all
from openrooms_usd.usd.files import layers
from openrooms_usd.usd.semantics import label
from openrooms_usd.validation.model import Finding
from openrooms_usd.validation.physx_rules import PHYSX_RULES
from openrooms_usd.validation.room_rules import ROOM_RULES

# What a room shows that nobody meant: its chairs are squares here (see `test_room_rules`); and what
# bodies are, of which there are none here (see `test_physx_rules`).
SHOWN = {rule.code for rule in (*ROOM_RULES, *PHYSX_RULES)}
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def validate_stage(path: Path, *, strict: bool = False) -> list[Finding]:
    """What is wrong with a stage as a stage."""
    return [found for found in validate_all(path, strict=strict) if found.code not in SHOWN]


@dataclass(frozen=True)
class SmallRoom:
    """The files of a clean scene: two instances of a chair on a floor."""

    folder: Path

    @property
    def scene(self) -> Path:
        return self.folder / "scene.usda"

    def edit(self, name: str, old: str, new: str) -> Path:
        """Replace text in one of the files and return the scene."""
        path = self.folder / name
        text = path.read_text()
        assert old in text, f"{old!r} is not in {name}"
        path.write_text(text.replace(old, new))
        return self.scene

    def edits(self, body: str) -> Path:
        """Write the body of the human layer and return the scene."""
        return self.edit("layers/edits.usda", "\n)\n", "\n)\n" + body)

    def statue(self, content: str = "") -> str:
        """A prim for the edits that refers to a file of another program: Y up, centimetres."""
        (self.folder / "statue.usda").write_text(
            '#usda 1.0\n(\n defaultPrim = "root"\n metersPerUnit = 0.01\n upAxis = "Y"\n)\n'
            f'def Xform "root"\n{{\n{content}}}\n'
        )
        return (
            'over "World" {\n def Xform "Statue" (prepend references = @../statue.usda@) {\n }\n}\n'
        )


def square(stage: Usd.Stage, path: str) -> UsdGeom.Mesh:
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(SQUARE)
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateExtentAttr([(0, 0, 0), (1, 1, 0)])
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateNormalsAttr([(0, 0, 1)] * 4)
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.faceVarying)
    return mesh


def material(stage: Usd.Stage, path: str) -> UsdShade.Material:
    shade = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, f"{path}/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(0.5))
    shade.CreateSurfaceOutput().ConnectToSource(
        shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    )
    return shade


def new_layer(path: Path) -> Sdf.Layer:
    path.parent.mkdir(parents=True, exist_ok=True)
    layer = Sdf.Layer.CreateNew(str(path))
    layers.apply_metadata(layer)
    return layer


def write_chair(path: Path) -> None:
    stage = Usd.Stage.Open(new_layer(path))
    stage.CreateClassPrim("/__class__").SetTypeName("Scope")
    stage.CreateClassPrim("/__class__/Chair").SetTypeName("Xform")
    root = UsdGeom.Xform.Define(stage, "/Chair").GetPrim()
    root.GetInherits().AddInherit("/__class__/Chair")
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    UsdGeom.ModelAPI.Apply(root).SetExtentsHint([(0, 0, 0), (1, 1, 0)])
    label(root, "chair")
    UsdGeom.Scope.Define(stage, "/Chair/Geometry")
    seat = square(stage, "/Chair/Geometry/seat").GetPrim()
    UsdGeom.Scope.Define(stage, "/Chair/Materials")
    UsdShade.MaterialBindingAPI.Apply(seat).Bind(material(stage, "/Chair/Materials/plain"))
    stage.SetDefaultPrim(root)
    stage.Save()


def write_layout(stage: Usd.Stage) -> None:
    for path, kind in ((names.WORLD, "assembly"), (names.ROOM, "component")):
        Usd.ModelAPI(UsdGeom.Xform.Define(stage, path)).SetKind(kind)
    label(square(stage, names.FLOOR).GetPrim(), "floor")
    guide = UsdGeom.Cube.Define(stage, f"{names.ROOM}/guide")
    guide.CreatePurposeAttr(UsdGeom.Tokens.guide)


def write_alignment(stage: Usd.Stage) -> None:
    Usd.ModelAPI(UsdGeom.Xform.Define(stage, names.FURNITURE)).SetKind("group")
    for i in range(2):
        chair = UsdGeom.Xform.Define(stage, f"{names.FURNITURE}/chair_{i}").GetPrim()
        chair.GetReferences().AddReference("./alignment/chair.usda")
        chair.SetInstanceable(True)


def write_materials(stage: Usd.Stage) -> None:
    UsdGeom.Scope.Define(stage, names.MATERIALS)
    wood = material(stage, f"{names.MATERIALS}/wood")
    UsdShade.MaterialBindingAPI.Apply(stage.OverridePrim(names.FLOOR)).Bind(wood)


@pytest.fixture
def small_room(tmp_path: Path) -> SmallRoom:
    write_chair(tmp_path / "layers/alignment/chair.usda")
    scene = new_layer(tmp_path / "scene.usda")
    stack = [
        new_layer(tmp_path / f"layers/{name}.usda")
        for name in ("edits", "materials", "alignment", "layout")
    ]
    scene.subLayerPaths = [f"./layers/{Path(layer.identifier).name}" for layer in stack]
    stage = Usd.Stage.Open(scene)
    writers = (write_layout, write_alignment, write_materials)
    for layer, write in zip(reversed(stack), writers, strict=False):
        stage.SetEditTarget(layer)
        write(stage)
    stage.Save()
    return SmallRoom(tmp_path)


def test_a_clean_room_is_clean(small_room: SmallRoom, assert_valid: Callable[[Path], None]) -> None:
    assert_valid(small_room.scene)


def test_the_second_opinion_is_one(
    small_room: SmallRoom, assert_valid: Callable[[Path], None]
) -> None:
    """A broken topology is none of our rules: usd-validation-nvidia is really asked."""
    broken = small_room.edit(
        "layers/alignment/chair.usda",
        "faceVertexIndices = [0, 1, 2, 3]",
        "faceVertexIndices = [0, 1, 2, 9]",
    )
    assert validate_stage(broken, strict=True) == []
    with pytest.raises(AssertionError, match="opology"):
        assert_valid(broken)


CHAIR = "layers/alignment/chair.usda"
LAYOUT = "layers/layout.usda"
MATERIALS = "layers/materials.usda"
OVER_SEAT = """over "World" {
    over "Furniture" {
        over "chair_1" {
            over "Geometry" {
                over "seat" {
                    bool doubleSided = 1
                }
            }
        }
    }
}
"""


def bodies(*, nested: bool) -> str:
    """Two bodies that move, one in the other or beside it."""
    body = '(prepend apiSchemas = ["PhysicsRigidBodyAPI"]) {'
    above, beside = (body, "") if nested else ("{", f'over "guide" {body} }}\n')
    return f'over "World" {{\nover "Room" {above}\nover "Floor" {body} }}\n{beside}}}\n}}\n'


def joined(room: SmallRoom) -> Path:
    room.edits(bodies(nested=False))
    room.edit(
        LAYOUT,
        'def Xform "Room"',
        """def PhysicsFixedJoint "Joint" {
            rel physics:body0 = </World/Room/Floor>
            rel physics:body1 = </World/Room/guide>
        }
        def Xform "Room" """,
    )
    return room.scene


# rule: (what breaks it, where it is found)
MILLIMETRES = """over "World"
{
    def Camera "Odd"
    {
        float focalLength = 24
        float horizontalAperture = 20.955
        float fStop = 1.8
    }
}
"""
BREAKS: dict[str, tuple[Callable[[SmallRoom], Path], str]] = {
    "equal-metadata": (
        lambda room: room.edit(MATERIALS, "kilogramsPerUnit = 1", "kilogramsPerUnit = 0.001"),
        "layers/materials.usda",
    ),
    "absolute-path": (
        lambda room: room.edit(
            "layers/alignment.usda", "@./alignment/", f"@{room.folder}/layers/alignment/"
        ),
        "layers/alignment.usda",
    ),
    "unanchored-path": (
        lambda room: room.edit("scene.usda", "@./layers/edits.usda@", "@layers/edits.usda@"),
        "scene.usda",
    ),
    "one-definer": (
        lambda room: room.edit(MATERIALS, 'over "Floor"', 'def Mesh "Floor"'),
        names.FLOOR,
    ),
    "below-instance": (lambda room: room.edits(OVER_SEAT), f"{names.FURNITURE}/chair_1/Geometry"),
    "orphan": (
        lambda room: room.edits('over "World" {\n over "Gone" {\n bool x = 1\n }\n}\n'),
        "/World/Gone",
    ),
    "units": (lambda room: room.edits(room.statue()), "/World/Statue"),
    "plausible": (lambda room: room.edits(MILLIMETRES), "/World/Odd"),
    "extent": (
        lambda room: room.edit(LAYOUT, "extent = [(0, 0, 0), (1, 1, 0)]", "extent:not = []"),
        names.FLOOR,
    ),
    "subdivision-scheme": (
        lambda room: room.edit(CHAIR, 'uniform token subdivisionScheme = "none"', ""),
        f"{names.FURNITURE}/chair_0/Geometry/seat",
    ),
    "material": (
        lambda room: room.edit(MATERIALS, "rel material:binding = </World/Materials/wood>", ""),
        names.FLOOR,
    ),
    "label": (
        lambda room: room.edit(CHAIR, 'semantics:labels:category = ["chair"]', "x:y = []"),
        f"{names.FURNITURE}/chair_0/Geometry/seat",
    ),
    "kind": (lambda room: room.edit(LAYOUT, 'kind = "assembly"', ""), "/World"),
    "component": (
        lambda room: room.edit(CHAIR, "prepend inherits = </__class__/Chair>", ""),
        f"{names.FURNITURE}/chair_0",
    ),
    "nested-body": (lambda room: room.edits(bodies(nested=True)), f"{names.ROOM}/Floor"),
    "articulation": (joined, "/World/Joint"),
    "contract": (
        lambda room: room.edit(MATERIALS, 'def Scope "Materials"', 'def Xform "Materials"'),
        names.MATERIALS,
    ),
}


def test_every_rule_has_a_stage_that_breaks_it() -> None:
    assert list(BREAKS) == [rule.code for rule in RULES if rule.code not in SHOWN]


@pytest.mark.parametrize("code", BREAKS)
def test_a_rule_finds_what_breaks_it(code: str, small_room: SmallRoom) -> None:
    breaks, place = BREAKS[code]
    findings = [f for f in validate_stage(breaks(small_room)) if f.code == code]
    assert place in {finding.place for finding in findings}
    assert all(
        finding.severity == ("warning" if code in ("orphan", "plausible", "units") else "error")
        for finding in findings
    )
    assert all(finding.remedy for finding in findings)


@pytest.mark.parametrize("code", sorted(set(BREAKS) - {"kind", "one-definer", "contract"}))
def test_and_nothing_else(code: str, small_room: SmallRoom) -> None:
    assert {finding.code for finding in validate_stage(BREAKS[code][0](small_room))} == {code}


def test_an_extent_that_is_too_small_is_found(small_room: SmallRoom) -> None:
    scene = small_room.edit(
        CHAIR, "extent = [(0, 0, 0), (1, 1, 0)]", "extent = [(0, 0, 0), (1, 0.9, 0)]"
    )
    assert [f.code for f in validate_stage(scene)] == ["extent"]


@pytest.mark.parametrize("extent", ["None", "[(0, 0, 0)]"])
def test_an_extent_without_a_box_is_none(extent: str, small_room: SmallRoom) -> None:
    scene = small_room.edit(CHAIR, "extent = [(0, 0, 0), (1, 1, 0)]", f"extent = {extent}")
    assert [f.message for f in validate_stage(scene)] == ["has no extent"]


def test_materials_of_all_faces_count_as_material(small_room: SmallRoom) -> None:
    binding = "rel material:binding = </World/Materials/wood>"
    subset = """def GeomSubset "part" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    ) {
        uniform token elementType = "face"
        uniform token familyName = "materialBind"
        int[] indices = [%s]
        rel material:binding = </World/Materials/wood>
    }
    uniform token subsetFamily:materialBind:familyType = "nonOverlapping" """
    covered = small_room.edit(MATERIALS, binding, subset % "0")
    assert "material" not in {f.code for f in validate_stage(covered)}
    bare = small_room.edit(MATERIALS, "indices = [0]", "indices = []")
    assert "material" in {f.code for f in validate_stage(bare)}


def test_instances_that_inherit_different_things_are_told_apart(small_room: SmallRoom) -> None:
    """Two instances share a prototype without a material; one has it from its root."""
    small_room.edit(CHAIR, "rel material:binding = </Chair/Materials/plain>", "")
    scene = small_room.edits(
        """over "World" {
    over "Furniture" {
        over "chair_0" (
            prepend apiSchemas = ["MaterialBindingAPI"]
        ) {
            rel material:binding = </World/Materials/wood>
        }
    }
}
"""
    )
    found = [f.place for f in validate_stage(scene) if f.code == "material"]
    assert found == [f"{names.FURNITURE}/chair_1/Geometry/seat"]


def test_our_rules_are_warnings_for_a_foreign_stage(tmp_path: Path) -> None:
    path = tmp_path / "plain.usda"
    path.write_text(
        '#usda 1.0\n(\n defaultPrim = "Cube"\n metersPerUnit = 0.01\n upAxis = "Y"\n)\n'
        'def Cube "Cube"\n{\n}\n'
    )
    assert {(f.severity, f.code) for f in validate_stage(path)} == {
        ("warning", code) for code in ("extent", "material", "label", "kind")
    }
    assert {f.severity for f in validate_stage(path, strict=True)} == {"error"}


def test_usd_errors_are_errors_for_a_foreign_stage(tmp_path: Path) -> None:
    path = tmp_path / "broken.usda"
    (tmp_path / "unreadable.usda").write_text("#usda 1.0\n what {")
    path.write_text(
        '#usda 1.0\ndef Xform "A" (references = @./missing.usda@)\n{\n'
        ' asset t = @./missing.png@\n}\ndef Xform "B" (references = @./unreadable.usda@)\n{\n}\n'
    )
    found = [f for f in validate_stage(path) if f.severity == "error"]
    text = " ".join(f.message for f in found)
    assert "missing.usda" in text and "unreadable.usda:2" in text
    assert "/A" in {f.place for f in found}
    assert any(f.code.endswith("MissingDefaultPrim") for f in found)


def test_usd_looks_into_what_instances_share_once(small_room: SmallRoom) -> None:
    scene = small_room.edit(CHAIR, 'prepend apiSchemas = ["MaterialBindingAPI"]', "")
    found = [f for f in validate_stage(scene) if "MaterialBindingApiApplied" in f.code]
    assert [f.place for f in found] == [f"{names.FURNITURE}/chair_0/Geometry/seat"]


def test_a_missing_texture_is_an_error(small_room: SmallRoom) -> None:
    scene = small_room.edit(
        MATERIALS,
        "color3f inputs:diffuseColor",
        "asset t = @./no.png@\n color3f inputs:diffuseColor",
    )
    assert "MissingReferenceValidator" in " ".join(f.code for f in validate_stage(scene))


def test_unknown_materialx_nodes_are_no_error(small_room: SmallRoom) -> None:
    shader = '"UsdPreviewSurface"'
    scene = small_room.edit(MATERIALS, shader, '"ND_standard_surface_surfaceshader"')
    assert validate_stage(scene, strict=True) == []
    small_room.edit(MATERIALS, "ND_standard_surface", "XX_standard_surface")
    assert validate_stage(scene) != []


def test_what_is_no_stage_is_refused(tmp_path: Path) -> None:
    (tmp_path / "bad.usda").write_text("not USD")
    for name in ("bad.usda", "none.usda"):
        with pytest.raises(InputError):
            validate_stage(tmp_path / name)


@pytest.mark.slow
def test_thousands_of_instances_are_looked_at_once(small_room: SmallRoom) -> None:
    from openrooms_usd.validation.model import Subject

    path = small_room.folder / "layers/alignment.usda"
    layer = Sdf.Layer.FindOrOpen(str(path))
    source = Sdf.Path(f"{names.FURNITURE}/chair_0")
    with Sdf.ChangeBlock():
        for i in range(2, 3_000):
            Sdf.CopySpec(layer, source, layer, source.ReplaceName(f"chair_{i}"))
    layer.Save()
    stage = layers.open_stage(small_room.scene)
    assert len(Subject(stage).gprims) == 2
    assert validate_stage(small_room.scene, strict=True) == []


def test_the_command_prints_a_table_and_exits_with_1(small_room: SmallRoom) -> None:
    run = CliRunner().invoke
    # Its chairs are squares, and it is dark: that is warned of, and nothing else.
    before = json.loads(run(validate, [str(small_room.scene), "--json"]).output)
    assert {finding["code"] for finding in before["findings"]} <= SHOWN
    BREAKS["orphan"][0](small_room)
    assert run(validate, [str(small_room.scene)]).exit_code == 0
    strict = run(validate, [str(small_room.scene), "--strict"])
    assert strict.exit_code == 1
    assert "orphan" in strict.output and "/World/Gone" in strict.output
    report = json.loads(run(validate, [str(small_room.scene), "--json"]).output)
    assert report["valid"] is True
    assert {finding["code"] for finding in report["findings"]} - SHOWN == {"orphan"}
