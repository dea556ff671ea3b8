"""What engines' importers do not read, by their documentation, is not what a room is made of."""

import re
from pathlib import Path

from pxr import Usd, UsdGeom, UsdShade

from orusd_gltf import GltfExporter
from tests.gltf.reading import read

# docs/howto/engines.md: what both read, or may pass over.
READ_BY_BOTH = {"KHR_lights_punctual", "KHR_materials_clearcoat", "KHR_materials_transmission"}
PASSED_OVER = {"KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_specular"}


def test_the_checks_that_the_page_names_are_there() -> None:
    root = Path(__file__).parents[2]
    named = set(re.findall(r"`(test_\w+)`", (root / "docs/howto/engines.md").read_text()))
    texts = [path.read_text() for path in root.glob("tests/*/test_*.py")]
    assert len(named) > 10
    assert {name for name in named if not any(f"def {name}(" in text for text in texts)} == set()


def test_a_glb_asks_for_nothing_that_engines_lack(composed_demo: Path, tmp_path: Path) -> None:
    GltfExporter().convert(Usd.Stage.Open(str(composed_demo)), tmp_path / "room.glb", {})
    said = read(tmp_path / "room.glb").json
    assert "extensionsRequired" not in said
    assert set(said["extensionsUsed"]) <= READ_BY_BOTH | PASSED_OVER
    assert {image["mimeType"] for image in said["images"]} <= {"image/png", "image/jpeg"}
    primitives = [p for mesh in said["meshes"] for p in mesh["primitives"]]
    assert {p["mode"] for p in primitives} == {4}
    known = {"POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "TEXCOORD_1"}
    assert {name for p in primitives for name in p["attributes"]} <= known


def test_a_room_has_only_what_engines_read_of_usd(composed_demo: Path) -> None:
    stage = Usd.Stage.Open(str(composed_demo))
    assert stage.HasAuthoredMetadata("upAxis") and stage.HasAuthoredMetadata("metersPerUnit")
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()):
        assert not prim.IsA(UsdGeom.PointInstancer)
        if prim.IsA(UsdGeom.Gprim):
            assert prim.IsA(UsdGeom.Mesh), prim.GetPath()
            assert UsdGeom.Mesh(prim).GetSubdivisionSchemeAttr().Get() == "none"
            material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
            source = UsdShade.Shader(material.ComputeSurfaceSource()[0])
            assert source.GetShaderId() == "UsdPreviewSurface"
    for layer in stage.GetUsedLayers():
        for path in layer.GetExternalReferences():
            assert not Path(path).is_absolute(), path
