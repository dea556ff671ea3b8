"""Looks: one geometry, many materials, as variants that are chosen on the roots."""

from pathlib import Path

import pytest
from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.description.room import Room
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import bound_material
from tests.steps.dressed import compose

CHAIRS = [f"{names.FURNITURE}/chair_{x}" for x in "abc"]


def room(**materials: object) -> Room:
    return Room.model_validate(
        {
            "room": "living_room",
            "seed": 4,
            "layout": {"openings": [{"kind": "door", "name": "door", "wall": 0}]},
            "furniture": {
                "objects": [
                    {"name": "sofa", "category": "sofa", "at": [2, 3.4]},
                    {"name": "lamp", "category": "floor_lamp", "at": [0.5, 3.4]},
                    *(
                        {"name": f"chair_{x}", "category": "chair", "at": [i, 1], "style": "slat"}
                        for i, x in enumerate("abc", start=1)
                    ),
                ]
            },
            "materials": {"resolution": 16, "looks": 3, **materials},
        }
    )


@pytest.fixture(scope="module")
def three(tmp_path_factory: pytest.TempPathFactory) -> Usd.Stage:
    return compose(tmp_path_factory.mktemp("three"), room())


def seen(stage: Usd.Stage) -> dict[str, object]:
    """What each surface shows; every one must show something that reads without loss."""
    found: dict[str, object] = {}
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()):
        if prim.IsA(UsdGeom.Gprim):
            material = bound_material(prim)
            assert material is not None, prim.GetPath()
            surface, losses = read_preview_surface(material)
            assert losses == ()
            found[str(prim.GetPath())] = surface
    return found


def roots(stage: Usd.Stage) -> list[Usd.Prim]:
    furniture = stage.GetPrimAtPath(names.FURNITURE)
    return [stage.GetPrimAtPath(names.ROOM), *furniture.GetChildren()]


def points(stage: Usd.Stage) -> dict[str, object]:
    return {
        str(prim.GetPath()): UsdGeom.Mesh(prim).GetPointsAttr().Get()
        for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies())
        if prim.IsA(UsdGeom.Mesh)
    }


def test_every_root_offers_the_looks_and_shows_the_first(three: Usd.Stage) -> None:
    for root in roots(three):
        variants = root.GetVariantSet("look")
        assert variants.GetVariantNames() == ["default", "look_1", "look_2"], root
        assert variants.GetVariantSelection() == "default"


def test_another_look_is_another_room_on_the_same_geometry(three: Usd.Stage) -> None:
    stage = Usd.Stage.Open(three.GetRootLayer(), Sdf.Layer.CreateAnonymous(".usda"))
    stage.SetEditTarget(stage.GetSessionLayer())
    looks, geometry = [], points(stage)
    for name in ("default", "look_1", "look_2"):
        for root in roots(stage):
            root.GetVariantSet("look").SetVariantSelection(name)
        looks.append(seen(stage))
        assert points(stage) == geometry
    for first, second in ((0, 1), (1, 2), (0, 2)):
        changed = [path for path in looks[0] if looks[first][path] != looks[second][path]]
        assert len(changed) > len(looks[0]) / 2
        assert names.FLOOR in changed


def test_the_default_look_is_what_a_room_without_looks_has(
    tmp_path: Path, three: Usd.Stage
) -> None:
    def without_folders(found: dict[str, object], folder: str) -> dict[str, str]:
        return {path: repr(surface).replace(folder, "") for path, surface in found.items()}

    single = compose(tmp_path, room(looks=1))
    old = str(Path(three.GetRootLayer().realPath).parent)
    assert without_folders(seen(single), str(tmp_path)) == without_folders(seen(three), old)
    # No variants without need: bindings are plain opinions.
    assert not single.GetPrimAtPath(names.ROOM).GetVariantSets().GetNames()


def test_repeats_with_one_look_share_a_prototype(three: Usd.Stage) -> None:
    stage = Usd.Stage.Open(three.GetRootLayer(), Sdf.Layer.CreateAnonymous(".usda"))
    stage.SetEditTarget(stage.GetSessionLayer())
    chairs = [stage.GetPrimAtPath(path) for path in CHAIRS]
    assert len({chair.GetPrototype().GetPath() for chair in chairs}) == 1
    for chair in chairs[1:]:
        chair.GetVariantSet("look").SetVariantSelection("look_2")
    chairs = [stage.GetPrimAtPath(path) for path in CHAIRS]
    first, *others = (chair.GetPrototype().GetPath() for chair in chairs)
    assert len(set(others)) == 1 and first not in others


def test_a_choice_in_the_edits_survives_and_changes_what_is_seen(tmp_path: Path) -> None:
    before = seen(compose(tmp_path, room()))
    edits = Sdf.Layer.FindOrOpen(str(tmp_path / names.LAYERS / "edits.usda"))
    for path in (names.ROOM, CHAIRS[0]):
        Sdf.CreatePrimInLayer(edits, path).variantSelections["look"] = "look_1"
    edits.Save()
    # Something else changes, so that the step writes its layer again above these edits.
    for described in (room(), room(overrides={"sofa": {"all": "leather"}})):
        stage = compose(tmp_path, described)
        after = seen(stage)
        for root in roots(stage):
            chosen = root.GetVariantSet("look").GetVariantSelection()
            picked = str(root.GetPath()) in (names.ROOM, CHAIRS[0])
            assert chosen == ("look_1" if picked else "default")
        assert after[names.FLOOR] != before[names.FLOOR]
        seat = "Geometry/seat"
        assert after[f"{CHAIRS[0]}/{seat}"] != before[f"{CHAIRS[0]}/{seat}"]
        assert after[f"{CHAIRS[1]}/{seat}"] == before[f"{CHAIRS[1]}/{seat}"]


def test_a_binding_in_the_edits_beats_every_look(tmp_path: Path) -> None:
    compose(tmp_path, room())
    edits = Usd.Stage.Open(str(tmp_path / names.LAYERS / "edits.usda"))
    from pxr import UsdShade

    mine = UsdShade.Material.Define(edits, "/World/Mine")
    UsdShade.MaterialBindingAPI.Apply(edits.OverridePrim(names.FLOOR)).Bind(mine)
    edits.Save()
    stage = compose(tmp_path, room(look=2))
    for name in ("default", "look_1"):
        stage.GetPrimAtPath(names.ROOM).GetVariantSet("look").SetVariantSelection(name)
        material = bound_material(stage.GetPrimAtPath(names.FLOOR))
        assert material is not None and str(material.GetPath()) == "/World/Mine"


def test_the_description_chooses_the_look_that_is_shown(tmp_path: Path, three: Usd.Stage) -> None:
    stage = compose(tmp_path, room(look=2))
    assert {r.GetVariantSet("look").GetVariantSelection() for r in roots(stage)} == {"look_2"}
    shown = repr(seen(stage)[names.FLOOR]).replace(str(tmp_path), "")
    three.SetEditTarget(three.GetSessionLayer())
    three.GetPrimAtPath(names.ROOM).GetVariantSet("look").SetVariantSelection("look_2")
    folder = str(Path(three.GetRootLayer().realPath).parent)
    assert shown == repr(seen(three)[names.FLOOR]).replace(folder, "")
    three.GetSessionLayer().Clear()
