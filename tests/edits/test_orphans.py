"""Opinions of the edits that do nothing are found, with a hint; those that do something are not."""

import json
from typing import Any

import pytest
from pxr import Sdf

from openrooms_usd.edits.orphans import orphans_of
from openrooms_usd.errors import InputError
from openrooms_usd.rules import validate_stage
from tests.commands import run

LOST = """
over "World" {
    over "Furniture" {
        over "soffa" {
            double3 xformOp:translate = (1, 1, 0)
        }
        over "nothing" {
        }
        over "sofa" (variants = {
            string look = "chrome"
        }) {
            double xformOp:rotateZ = 30
            rel favourite = [</World/Furniture/lmap>, </World/Furniture/lamp>]
            over "Geometry" {
                over "seat" (active = false) {
                }
            }
        }
        over "lamp" {
            over "Geometry" {
                over "lamp_shde" (active = false) {
                }
            }
        }
    }
    over "Fruniture" {
        over "sofa" (active = false) {
        }
    }
}
"""


@pytest.mark.slow
def test_each_kind_is_found_with_the_nearest_path(place: Any) -> None:
    place.write_edits(LOST)
    summary = place.compose()
    furniture = "/World/Furniture"
    parts = f"{furniture}/lamp/Geometry"
    assert [(row.path, row.reason, row.hint) for row in summary.orphans] == [
        ("/World/Fruniture", "missing", furniture),
        (f"{parts}/lamp_shde", "missing", f"{parts}/lamp_shade"),
        (f"{furniture}/sofa", "variant", ""),
        (f"{furniture}/sofa.favourite", "target", f"{furniture}/lamp"),
        (f"{furniture}/sofa.xformOp:rotateZ", "operation", ""),
        (f"{furniture}/sofa/Geometry", "instance", ""),
        (f"{furniture}/soffa", "missing", f"{furniture}/sofa"),
    ]
    assert summary.as_dict()["orphans"][0]["path"] == "/World/Fruniture"
    # Nothing ran, and they are still there.
    assert place.compose().unchanged
    assert place.compose().orphans == summary.orphans


@pytest.mark.slow
def test_the_same_are_said_by_the_commands_and_by_validate(place: Any) -> None:
    place.write_edits(LOST)
    said = run("compose", place.description, "-o", place.out)
    assert "edits: /World/Fruniture: overrides a prim that does not exist" in said.output
    assert "edits: 2 more; orusd edit orphans" in said.output
    listed = run("edit", "orphans", place.out)
    assert "remedy: /World/Furniture/sofa is near: rename it to where the prim is now" in (
        listed.output
    )
    assert listed.output.endswith("edits.usda: 7 orphans\n")
    plain = run("edit", "orphans", place.out, "--json")
    rows = json.loads(plain.output)["orphans"]
    assert len(rows) == 7
    assert set(rows[0]) == {"path", "reason", "message", "hint", "remedy"}
    findings = {(f.code, f.place) for f in validate_stage(place.scene)}
    codes = {"instance": "below-instance"}
    wanted = {(codes.get(row.reason, "orphan"), row.path) for row in orphans_of(place.out)}
    assert wanted <= findings


@pytest.mark.slow
def test_what_does_something_is_no_orphan(place: Any) -> None:
    with place.saving(place.edits) as stage:
        sofa = stage.GetPrimAtPath("/World/Furniture/sofa")
        looks = sofa.GetVariantSet("look")
        looks.SetVariantSelection(looks.GetVariantNames()[0])
        sofa.SetInstanceable(False)
        sofa.GetAttribute("xformOp:translate").Set((1.0, 1.0, 0.0))
        stage.GetPrimAtPath("/World/Furniture/table").SetActive(False)
        cube = stage.DefinePrim("/World/Cube", "Cube")
        cube.CreateRelationship("near").SetTargets(["/World/Furniture/lamp", "/World.note"])
        stage.GetPrimAtPath("/World").CreateAttribute("note", Sdf.ValueTypeNames.Int).Set(1)
        stage.OverridePrim("/World/Furniture/sofa/Geometry").SetCustomDataByKey("mine", 1)
    assert place.compose().orphans == ()
    assert "no orphans" in run("edit", "orphans", place.out).output


@pytest.mark.slow
def test_layers_below_the_edits_are_looked_at_too(place: Any) -> None:
    below = Sdf.Layer.CreateNew(str(place.edits.with_name("more.usda")))
    Sdf.CreatePrimInLayer(below, "/World/Furniture/stool").active = False
    below.Save()
    edits = Sdf.Layer.FindOrOpen(str(place.edits))
    edits.subLayerPaths.append("./more.usda")
    edits.Save()
    assert [row.path for row in place.compose().orphans] == ["/World/Furniture/stool"]


@pytest.mark.slow
def test_a_renamed_object_leaves_an_orphan_and_a_new_one_does_not(place: Any) -> None:
    with place.saving(place.edits) as stage:
        stage.GetPrimAtPath("/World/Furniture/sofa").GetAttribute("xformOp:translate").Set(
            (1.0, 3.0, 0.0)
        )
    text = place.description.read_text()
    place.description.write_text(text.replace("name: sofa,", "name: couch,"))
    [orphan] = place.compose().orphans
    assert (orphan.path, orphan.reason) == ("/World/Furniture/sofa", "missing")
    place.description.write_text(
        text.replace("objects:\n", "objects:\n    - {category: sofa, at: [1, 1]}\n")
    )
    assert place.compose().orphans == ()
    stage = place.stage()
    sofa = stage.GetPrimAtPath("/World/Furniture/sofa")
    assert tuple(sofa.GetAttribute("xformOp:translate").Get()) == (1.0, 3.0, 0.0)


@pytest.mark.slow
def test_paths_are_stable_when_named_objects_come_and_go(place: Any) -> None:
    def named() -> set[str]:
        stage = place.stage()
        return {p.GetName() for p in stage.GetPrimAtPath("/World/Furniture").GetChildren()}

    before = named()
    text = place.description.read_text()
    rows = [line for line in text.splitlines() if line.startswith("    - ")]
    for order in (rows[::-1], [*rows[1:], rows[0]]):
        place.description.write_text(text.replace("\n".join(rows), "\n".join(order)))
        place.compose()
        assert named() == before
    place.description.write_text(text.replace(rows[2] + "\n", ""))
    place.compose()
    assert before - named() == {"chair_a"}


def test_a_folder_without_a_room_is_refused(tmp_path: Any) -> None:
    with pytest.raises(InputError, match="no such file"):
        orphans_of(tmp_path)


@pytest.mark.slow
def test_a_thousand_orphans_are_counted_and_only_some_have_hints(place: Any) -> None:
    layer = Sdf.Layer.FindOrOpen(str(place.edits))
    with Sdf.ChangeBlock():
        for number in range(1000):
            Sdf.CreatePrimInLayer(layer, f"/World/Furniture/sofa{number}").active = False
    layer.Save()
    found = orphans_of(place.out)
    assert len(found) == 1000
    assert 0 < sum(bool(orphan.hint) for orphan in found) <= 50
