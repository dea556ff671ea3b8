"""Materials that people choose: opinions in the edits alone, which survive and compose."""

import hashlib
import shutil
from pathlib import Path

import pytest
from pxr import Usd, UsdShade

from openrooms_usd import names
from openrooms_usd.composing import compose_room
from openrooms_usd.description import parse_room
from openrooms_usd.edits.assigning import assign, look_of, unassign
from openrooms_usd.errors import DescriptionError, InputError

SEAT = "/World/Furniture/chair_0/Geometry/seat"
OAK = {"family": "oak_planks", "number": 3}


@pytest.fixture
def scene(composed_demo: Path, tmp_path: Path) -> Path:
    shutil.copytree(composed_demo.parents[1], tmp_path / "room")
    return tmp_path / "room/out/scene.usda"


def others(scene: Path) -> dict[str, str]:
    """Hashes of everything that compose wrote."""
    mine = scene.parent / "layers" / "edits"
    return {
        str(path.relative_to(scene.parent)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(scene.parent.rglob("*"))
        if path.is_file()
        and path.suffix in (".usda", ".usdc", ".png", ".exr")
        and path.name != "edits.usda"
        and not path.is_relative_to(mine)
    }


def worn(scene: Path) -> dict[str, tuple[str, int]]:
    """Family and number of what each surface is made of, by USD's own rules of binding."""
    stage, found = Usd.Stage.Open(str(scene)), {}
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
        if prim.GetTypeName() == "Mesh" and material:
            said = (
                material.GetPrim().GetAttribute(n)
                for n in (names.MATERIAL_FAMILY, names.MATERIAL_NUMBER)
            )
            found[str(prim.GetPath())] = tuple(one.Get() for one in said)
    return found  # type: ignore[return-value]


@pytest.mark.parametrize(
    ("path", "scope", "meant"),
    [
        (SEAT, "part", lambda path: path == SEAT),
        (SEAT, "object", lambda path: "/chair_0/" in path),
        (SEAT, "alike", lambda path: "/chair_" in path and path.endswith("seat")),
        (SEAT, "category", lambda path: "/chair_" in path),
        ("/World/Room/Floor", "part", lambda path: path == "/World/Room/Floor"),
        ("/World/Room/Walls/wall_1", "category", lambda path: path.startswith("/World/Room/Walls")),
        (
            "/World/Furniture/table_lamp_0/Geometry/base",
            "object",
            lambda path: "/table_lamp_0/" in path and not path.endswith("light_bulb"),
        ),
    ],
)
def test_what_is_meant_is_made_of_it_and_nothing_else(
    scene: Path, path: str, scope: str, meant: object
) -> None:
    before, bytes_before = worn(scene), others(scene)
    done = assign(scene, path, scope, look_of(OAK))  # type: ignore[arg-type]
    after = worn(scene)
    changed = {path for path in after if after[path] != before[path]}
    assert changed == {path for path in before if meant(path)} == set(done.parts)  # type: ignore[operator]
    assert {after[path] for path in changed} == {("oak_planks", 3)}
    assert others(scene) == bytes_before


def test_it_survives_compositions(scene: Path, assert_valid: object) -> None:
    assign(scene, SEAT, "category", look_of(OAK))
    edits = (scene.parent / "layers/edits.usda").read_bytes()
    wanted = worn(scene)
    for _ in range(2):
        done = compose_room(scene.parents[1] / "room.yaml", scene.parent)
        assert not done.orphans
    assert worn(scene) == wanted
    assert (scene.parent / "layers/edits.usda").read_bytes() == edits
    assert_valid(scene)  # type: ignore[operator]


def test_what_was_chosen_before_leaves_nothing_behind(scene: Path) -> None:
    edits = scene.parent / "layers/edits.usda"
    empty, before = edits.read_bytes(), worn(scene)
    assign(scene, SEAT, "category", look_of(OAK))
    assign(scene, SEAT, "category", look_of("linen"))
    assert b"oak_planks" not in edits.read_bytes()
    unassign(scene, SEAT, "category")
    assert edits.read_bytes() == empty and worn(scene) == before


def test_a_constant_and_a_substance_are_looks_too(scene: Path) -> None:
    assign(scene, SEAT, "part", look_of({"color": [0.2, 0.3, 0.4], "roughness": 0.4}))
    assert worn(scene)[SEAT] == (None, None)
    assign(scene, SEAT, "part", look_of("leather"))
    stage = Usd.Stage.Open(str(scene))
    material = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(SEAT)).ComputeBoundMaterial()[0]
    assert material.GetPrim().GetAttribute(names.MATERIAL_CATEGORY).Get() == "leather"


@pytest.mark.parametrize("said", [{"family": "oak_plank"}, {"color": [2, 0, 0]}, {"number": 3}, 7])
def test_what_compose_refuses_is_refused_in_its_words(said: object) -> None:
    with pytest.raises(DescriptionError) as ours:
        look_of(said)  # type: ignore[arg-type]
    import json

    with pytest.raises(DescriptionError) as theirs:
        parse_room(f"materials: {{floor: {json.dumps(said)}}}")
    told = [str(error.value).split("\n")[1].split("materials.floor")[1] for error in (ours, theirs)]
    assert told[0] == told[1]


def test_a_part_that_is_not_there_is_refused_and_nothing_written(scene: Path) -> None:
    before = (scene.parent / "layers/edits.usda").read_bytes()
    for path in ("/World/Furniture/chair_9/Geometry/seat", "no path", "/"):
        with pytest.raises(InputError, match="no such prim"):
            assign(scene, path, "part", look_of(OAK))
    assert (scene.parent / "layers/edits.usda").read_bytes() == before
