"""A room is changed in Blender and comes back: what was done, in few opinions, and nothing else."""

from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.demo import write_starter
from openrooms_usd.rules import validate_stage
from openrooms_usd.usd.light.lights import DistantLight, read_lights
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import bound_material
from tests.blender.conftest import Blender
from tests.commands import output_of

pytestmark = pytest.mark.slow

PAINT: Final = (0.1, 0.4, 0.2)
CHAIR: Final = f"{names.FURNITURE}/chair_0"
POLE: Final = f"{names.FURNITURE}/floor_lamp_0/Geometry/lamp_pole"
LAMP: Final = f"{names.FURNITURE}/ceiling_lamp_0"
GONE: Final = f"{names.FURNITURE}/table_lamp_0"
STOOL: Final = f"{names.WORLD}/Stool"
SUN: Final = f"{names.WORLD}/Sun"
CHOSEN: Final = f"{names.CAMERAS}/view_"
LUX: Final = 3000.0
DEGREES: Final = 2.0


def said_by(scene: Path) -> dict[str, str]:
    """Everything that a composed stage says: types and schemas of prims, values, targets."""
    stage = Usd.Stage.Open(str(scene), Usd.Stage.LoadAll)
    stage.Reload()
    said = {}
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()):
        said[str(prim.GetPath())] = f"{prim.GetTypeName()} {prim.GetAppliedSchemas()}"
        for found in prim.GetAttributes():
            said[str(found.GetPath())] = f"{found.Get()} {found.GetConnections()}"
        for found in prim.GetRelationships():
            said[str(found.GetPath())] = str(found.GetTargets())
    return said


def differences(before: dict[str, str], after: dict[str, str]) -> set[str]:
    return {path for path in before.keys() | after.keys() if before.get(path) != after.get(path)}


def is_below(path: str, root: str) -> bool:
    return path == root or path.startswith((f"{root}/", f"{root}."))


def is_new(path: str) -> bool:
    return is_below(path, STOOL) or is_below(path, SUN)


def opinions_in(layer: Path) -> set[str]:
    """Attributes, and prims that are switched off, of what was there before."""
    found: set[str] = set()
    edits = Sdf.Layer.OpenAsAnonymous(str(layer))

    def look(path: Sdf.Path) -> None:
        if path.IsPropertyPath() or (
            path.IsPrimPath() and edits.GetPrimAtPath(path).HasInfo("active")
        ):
            found.add(str(path))

    edits.Traverse(Sdf.Path.absoluteRootPath, look)
    return {path for path in found if not is_new(path)}


@pytest.fixture(scope="module")
def trip(blender: Blender, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The commands of docs/howto/blender.md, and what the stage said before, between and after."""
    folder = tmp_path_factory.mktemp("trip")
    described, out = write_starter(folder)[0], folder / "out"
    scene, file = out / "scene.usda", folder / "from_blender.usda"
    output_of("compose", described, "-o", out)
    before = said_by(scene)
    blender("visited", scene, paint=PAINT, lux=LUX, degrees=DEGREES, file=str(file))
    output_of("edit", "import-changes", scene, "--from", file)
    adopted, edits = said_by(scene), (out / "layers/edits.usda").read_bytes()
    output_of("compose", described, "-o", out)
    composed = said_by(scene)
    wished = described.read_text().replace("at: [2.2, 2.4]", "at: [2.0, 2.2]")
    described.write_text(wished.replace("height: 260 cm", "height: 270 cm"))
    output_of("compose", described, "-o", out)
    return {
        "scene": scene,
        "before": before,
        "adopted": adopted,
        "composed": composed,
        "edits": edits,
    }


def paint_of(stage: Usd.Stage) -> Sdf.Path:
    material = bound_material(stage.GetPrimAtPath(POLE))
    assert material is not None
    return material.GetPath().AppendPath("Surface.inputs:diffuseColor")


def changed_by(stage: Usd.Stage) -> set[str]:
    return {
        f"{CHAIR}.xformOp:translate",
        f"{CHAIR}.xformOp:rotateXYZ",
        str(paint_of(stage)),
        f"{LAMP}/Geometry/light_bulb.inputs:intensity",
    }


def test_four_changes_are_five_opinions_beside_what_is_new(trip: dict[str, Any]) -> None:
    stage = Usd.Stage.Open(str(trip["scene"]))
    assert opinions_in(trip["scene"].parent / "layers/edits.usda") == {*changed_by(stage), GONE}


def test_nothing_else_of_the_stage_has_changed(trip: dict[str, Any]) -> None:
    """Every attribute and relationship of every prim, those below instances too."""
    assert len(trip["before"]) > 4000
    changed = differences(trip["before"], trip["adopted"])
    others = {path for path in changed if not (is_below(path, GONE) or is_new(path))}
    assert others == changed_by(Usd.Stage.Open(str(trip["scene"])))
    # Composing again lets the dimmed bulb glow less, says what it was made of, and looks at the
    # furniture where it now stands.
    followed = differences(trip["adopted"], trip["composed"])
    [glow] = [p for p in followed if ".authorship:" not in p and not p.startswith(CHOSEN)]
    assert glow.startswith(f"{LAMP}/Materials/") and glow.endswith("emissiveColor")


def test_a_new_sun_is_as_bright_as_in_blender(trip: dict[str, Any]) -> None:
    stage = Usd.Stage.Open(str(trip["scene"]))
    [sun] = [light for light in read_lights(stage) if isinstance(light, DistantLight)]
    np.testing.assert_allclose(sun.irradiance, (LUX, LUX, LUX), rtol=1e-5)
    assert sun.angle == pytest.approx(DEGREES, rel=1e-5)


def test_another_description_keeps_what_was_done(trip: dict[str, Any]) -> None:
    scene = trip["scene"]
    assert (scene.parent / "layers/edits.usda").read_bytes() == trip["edits"]
    stage = Usd.Stage.Open(str(scene))
    stage.Reload()
    table = UsdGeom.Xformable(stage.GetPrimAtPath(f"{names.FURNITURE}/coffee_table"))
    place = table.GetLocalTransformation().ExtractTranslation()
    np.testing.assert_allclose(place, [2.0, 2.2, 0.0], atol=1e-6)
    said = said_by(scene)
    kept = [path for path in trip["composed"] if is_below(path, CHAIR) or is_new(path)]
    assert [path for path in kept if said.get(path) != trip["composed"][path]] == []
    chair = UsdGeom.Xformable(stage.GetPrimAtPath(CHAIR)).GetLocalTransformation()
    np.testing.assert_allclose(chair.ExtractTranslation(), [4.4, 2.15, 0.0], atol=1e-5)
    painted = bound_material(stage.GetPrimAtPath(POLE))
    assert painted and read_preview_surface(painted)[0].base_color == pytest.approx(PAINT)
    assert not stage.GetPrimAtPath(GONE).IsActive()
    assert [x for x in validate_stage(scene) if x.severity == "error"] == []
