"""Adopting loses nothing that it does not name: other layers, broken ones, and their times."""

from typing import Any

import pytest
from pxr import Sdf

from openrooms_usd.edits.adopting import adopt
from openrooms_usd.errors import InputError, StageError

SOFA = "/World/Furniture/sofa"


def switch_off(place: Any) -> None:
    with place.saving(place.scene) as stage:
        stage.GetPrimAtPath(SOFA).SetActive(False)


def on_top(place: Any, name: str, offset: Sdf.LayerOffset | None = None) -> None:
    root = Sdf.Layer.FindOrOpen(str(place.scene))
    root.Reload()
    root.subLayerPaths.insert(0, f"./{name}")
    root.subLayerOffsets[0] = offset or Sdf.LayerOffset()
    root.Save()


def test_another_file_beside_the_scene_is_not_taken_for_it(place: Any) -> None:
    switch_off(place)
    other = Sdf.Layer.CreateNew(str(place.out / "other.usda"))
    Sdf.CreatePrimInLayer(other, SOFA).instanceable = False
    other.Save()
    before = place.tree()
    with pytest.raises(InputError, match=r"--from .*other\.usda"):
        adopt(place.out / "other.usda")
    assert place.tree() == before


@pytest.mark.parametrize("data", [None, b"", b"\xff\x00broken"])
def test_a_layer_that_cannot_be_opened_is_not_dropped(place: Any, data: bytes | None) -> None:
    on_top(place, "mine.usda")
    if data is not None:
        (place.out / "mine.usda").write_bytes(data)
    before = place.tree()
    with pytest.raises((StageError, InputError), match=r"mine\.usda"):
        adopt(place.scene)
    assert place.tree() == before


@pytest.mark.parametrize("data", [b"", b"\xff\x00broken", b"PXR-USDC"])
def test_edits_that_cannot_be_read_are_named_and_stay(place: Any, data: bytes) -> None:
    switch_off(place)
    place.edits.write_bytes(data)
    before = place.tree()
    with pytest.raises(InputError, match=r"edits\.usda"):
        adopt(place.scene)
    assert place.tree() == before


@pytest.mark.slow
def test_layers_on_top_keep_their_times_and_define_nothing_twice(place: Any) -> None:
    extra = Sdf.Layer.CreateNew(str(place.out / "mine.usda"))
    spec = Sdf.CreatePrimInLayer(extra, SOFA)
    spec.specifier, spec.typeName = Sdf.SpecifierDef, "Xform"
    place_of = Sdf.AttributeSpec(spec, "xformOp:translate", Sdf.ValueTypeNames.Double3)
    extra.SetTimeSample(place_of.path, 10.0, (1, 0, 0))
    extra.Save()
    on_top(place, "mine.usda", Sdf.LayerOffset(100.0, 2.0))
    (change,) = adopt(place.scene).changes
    assert (change.path, change.new) == (SOFA, False)
    edits = Sdf.Layer.OpenAsAnonymous(str(place.edits))
    assert edits.ListTimeSamplesForPath(place_of.path) == [120.0]
    assert edits.GetPrimAtPath(SOFA).specifier == Sdf.SpecifierOver


def test_animated_values_keep_their_seconds(place: Any) -> None:
    path = f"{SOFA}.xformOp:translate"
    edits = Sdf.Layer.FindOrOpen(str(place.edits))
    edits.Reload()
    edits.timeCodesPerSecond = 48
    for layer_path in (path, path.replace("sofa", "table")):
        spec = Sdf.CreatePrimInLayer(edits, Sdf.Path(layer_path).GetPrimPath())
        Sdf.AttributeSpec(spec, "xformOp:translate", Sdf.ValueTypeNames.Double3)
        edits.SetTimeSample(layer_path, 48.0, (1, 0, 0))
    edits.Save()
    scene = Sdf.Layer.FindOrOpen(str(place.scene))
    scene.Reload()
    scene.timeCodesPerSecond = 30
    spec = Sdf.CreatePrimInLayer(scene, SOFA)
    Sdf.AttributeSpec(spec, "xformOp:translate", Sdf.ValueTypeNames.Double3)
    scene.SetTimeSample(path, 30.0, (2, 0, 0))
    scene.Save()
    adopt(place.scene)
    written = Sdf.Layer.OpenAsAnonymous(str(place.edits))
    assert written.timeCodesPerSecond == 48
    # One second, all of them.
    assert written.ListTimeSamplesForPath(path) == [48.0]
    assert written.QueryTimeSample(path, 48.0) == (2, 0, 0)
    assert written.ListTimeSamplesForPath(path.replace("sofa", "table")) == [48.0]


def test_layers_below_the_edits_keep_their_times(place: Any) -> None:
    Sdf.Layer.CreateNew(str(place.edits.with_name("below.usda"))).Save()
    edits = Sdf.Layer.FindOrOpen(str(place.edits))
    edits.Reload()
    edits.subLayerPaths.append("./below.usda")
    edits.subLayerOffsets[0] = Sdf.LayerOffset(5.0)
    edits.Save()
    switch_off(place)
    assert adopt(place.scene).written
    written = Sdf.Layer.OpenAsAnonymous(str(place.edits))
    assert list(written.subLayerOffsets) == [Sdf.LayerOffset(5.0)]
