"""A second compose does nothing, layers stand alone, each prim has one author, edits stay."""

import shutil
from pathlib import Path

import pytest
from pxr import Sdf, Usd, UsdGeom

from openrooms_usd.composing import compose_room
from tests.commands import output_of


@pytest.fixture
def room(composed_demo: Path, tmp_path: Path) -> Path:
    """A folder with ``room.yaml`` and ``out``, to be changed."""
    return Path(shutil.copytree(composed_demo.parents[1], tmp_path / "room"))


def state(folder: Path) -> dict[Path, tuple[int, int, bytes]]:
    """Inode, time of the last change and bytes of every file, and of folders what is in them."""
    return {
        path: (path.stat().st_ino, path.stat().st_mtime_ns, path.read_bytes())
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_a_second_compose_touches_no_file_and_says_so(room: Path) -> None:
    before = state(room)
    words = ["compose", str(room / "room.yaml"), "-o", str(room / "out")]
    result = output_of(*words)
    assert "nothing to do" in result
    assert result.count("unchanged") == 6
    assert state(room) == before


def test_every_layer_opens_alone_with_equal_metadata(composed_demo: Path) -> None:
    files = [path for path in composed_demo.parent.rglob("*") if path.suffix in (".usda", ".usdc")]
    assert len(files) > 12
    facts = set()
    for path in files:
        layer = Sdf.Layer.OpenAsAnonymous(str(path))
        root = layer.pseudoRoot
        facts.add(
            tuple(root.GetInfo(key) for key in ("upAxis", "metersPerUnit", "kilogramsPerUnit"))
        )
        stage = Usd.Stage.Open(str(path))
        assert stage.GetCompositionErrors() == [], path
        assert path.name == "edits.usda" or stage.GetDefaultPrim(), path
        assert not layer.GetPrimAtPath("/World") or layer.defaultPrim == "World", path
    assert facts == {("Z", 1.0, 1.0)}


def test_one_layer_defines_a_prim_and_the_others_only_say_more(composed_demo: Path) -> None:
    stage = Usd.Stage.Open(str(composed_demo))
    stack = set(stage.GetLayerStack(includeSessionLayers=False))
    shared = 0
    for prim in stage.TraverseAll():
        own = [spec for spec in prim.GetPrimStack() if spec.layer in stack]
        definers = [spec for spec in own if spec.specifier != Sdf.SpecifierOver]
        # What an asset brings is defined there, and nobody in the stack defines it again.
        assert len(definers) <= 1, (prim.GetPath(), [spec.layer for spec in definers])
        assert prim.IsDefined()
        shared += len(own) > 1
    assert shared > 10, "several layers speak about some prims"
    assert [
        spec.layer.GetDisplayName()
        for spec in stage.GetPrimAtPath("/World").GetPrimStack()
        if spec.specifier == Sdf.SpecifierDef
    ] == ["layout.usda"]


@pytest.mark.slow
def test_edits_reach_the_pictures_and_survive(room: Path, show, paint, fastest: str) -> None:
    scene, edits = room / "out" / "scene.usda", room / "out" / "layers" / "edits.usda"
    how = {
        "options": {"variant": fastest},
        "resolution": (24, 18),
        "samples": 1,
        "channels": ["instance", "material", "base_color", "roughness", "metallic"],
    }
    before = show(scene, "before", **how)
    stage = Usd.Stage.Open(str(scene))
    color = (0.125, 0.375, 0.75)
    paint(stage, edits, "/World/Room/Floor", diffuseColor=color, roughness=0.25, metallic=0.5)
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/Furniture/desk")).MakeInvisible()
    stage.GetEditTarget().GetLayer().Save()
    written = edits.read_bytes()
    del stage

    description = room / "room.yaml"
    description.write_text(description.read_text().replace("seed: 3", "seed: 4"))
    summary = compose_room(description, room / "out")
    assert {row.state for row in summary.stages} == {"written"}
    assert edits.read_bytes() == written
    after = show(scene, "after", **how)

    def named(shown, channel: str) -> set[str]:
        return set(shown.manifest["legend"][channel].values())

    assert named(before, "instance") - named(after, "instance") == {"/World/Furniture/desk"}
    assert "/World/Materials/by_hand" in named(after, "material") - named(before, "material")
    floors = 0
    for view in after.views:
        image = after[view]
        floor = after.names(view, "instance") == "/World/Room/Floor"
        floors += floor.sum()
        assert (after.names(view, "material") == "/World/Materials/by_hand")[floor].all()
        # These numbers are exact in half precision.
        assert (image["base_color"][floor] == color).all()
        assert (image["roughness"][floor] == 0.25).all()
        assert (image["metallic"][floor] == 0.5).all()
    assert floors > 50
