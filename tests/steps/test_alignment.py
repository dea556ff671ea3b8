"""The alignment step: objects where they were asked for, repeats as instances, equal bytes."""

import hashlib
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import adapters, names
from openrooms_usd.capture import Capture, CapturedBox
from openrooms_usd.description.room import Room
from openrooms_usd.errors import DescriptionError
from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.geometry.solids import box
from openrooms_usd.steps.alignment.step import AlignmentStep
from openrooms_usd.steps.draft import drafting
from openrooms_usd.steps.layout.step import LayoutStep
from openrooms_usd.steps.runner import run
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shapes.meshes import define_mesh, read_meshes

HEIGHT = 2.4
# A model that is nothing but a reference.
WHOLE = """\
#usda 1.0
(
    defaultPrim = "A"
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "A" (
    references = @./part.usda@
) {}
"""


def _compose(
    folder: Path, objects: list[dict[str, Any]], *, seed: int = 0, workers: int = 1, **section: Any
) -> tuple[Usd.Stage, list[str]]:
    room = Room.model_validate(
        {"seed": seed, "layout": {"height": HEIGHT}, "furniture": {"objects": objects, **section}}
    )
    layers = folder / "layers"
    with drafting(folder) as draft:
        run(LayoutStep(), room, folder, draft, "", workers)
        notes = run(AlignmentStep(), room, folder, draft, "", workers)
    root = Sdf.Layer.CreateAnonymous(".usda")
    root.subLayerPaths = [str(layers / "alignment.usda"), str(layers / "layout.usda")]
    root.pseudoRoot.SetInfo("upAxis", "Z")
    root.pseudoRoot.SetInfo("metersPerUnit", 1.0)
    return Usd.Stage.Open(root), list(notes)


def _bound(stage: Usd.Stage, name: str) -> np.ndarray:
    """World bounding box from the meshes themselves."""
    path = f"{names.FURNITURE}/{name}/"
    points = [m.world_points() for m in read_meshes(stage) if m.path.startswith(path)]
    together = np.concatenate(points)
    return np.stack([together.min(axis=0), together.max(axis=0)])


def _digests(folder: Path) -> dict[str, str]:
    files = sorted((folder / "layers" / "alignment").rglob("*"))
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in [*files, folder / "layers" / "alignment.usda"]
        if path.is_file()
    }


def test_objects_stand_where_they_are_asked_for(tmp_path: Path) -> None:
    stage, notes = _compose(
        tmp_path,
        [
            {"category": "cabinet", "at": [2, 1], "size": [1.2, 0.4, 0.9], "yaw": 90},
            {"category": "ceiling_lamp", "at": [1, 2], "size": [0.4, 0.4, 0.3]},
            {"category": "table", "at": [3, 3], "size": [1.0, 0.8, 0.7], "name": "desk"},
            {"category": "table_lamp", "at": [3.2, 3.1]},
            {"category": "chair", "at": [1, 1, 0.25]},
        ],
    )
    assert notes == []
    np.testing.assert_allclose(
        _bound(stage, "cabinet_0"), [[1.8, 0.4, 0], [2.2, 1.6, 0.9]], atol=1e-6
    )
    np.testing.assert_allclose(
        _bound(stage, "ceiling_lamp_0"), [[0.8, 1.8, 2.1], [1.2, 2.2, HEIGHT]], atol=1e-6
    )
    assert _bound(stage, "table_lamp_0")[0, 2] == pytest.approx(0.7)
    assert _bound(stage, "chair_0")[0, 2] == pytest.approx(0.25)


def test_what_leans_is_authored_so(tmp_path: Path) -> None:
    stage, notes = _compose(
        tmp_path,
        [{"category": "box", "at": [1, 1], "size": [1.0, 1.0, 1.0], "tilt": [-90, 0], "yaw": 30}],
    )
    assert notes == []
    turn = stage.GetPrimAtPath(f"{names.FURNITURE}/box_0").GetAttribute("xformOp:rotateXYZ")
    assert tuple(turn.Get()) == (-90.0, 0.0, 30.0)
    # On its back: the base, of which the middle is given, now stands upright before it.
    low, high = _bound(stage, "box_0")
    assert low[2] == pytest.approx(0.0, abs=1e-6) and high[2] == pytest.approx(1.0, abs=1e-6)


def test_the_scene_contract(tmp_path: Path) -> None:
    stage, _ = _compose(
        tmp_path, [{"category": "chair", "at": [1, 1]}, {"category": "floor_lamp", "at": [2, 1]}]
    )
    assert Usd.ModelAPI(stage.GetPrimAtPath(names.FURNITURE)).GetKind() == "group"
    chair, lamp = (stage.GetPrimAtPath(f"{names.FURNITURE}/{n}_0") for n in ("chair", "floor_lamp"))
    for prim, category in ((chair, "chair"), (lamp, "floor_lamp")):
        assert Usd.ModelAPI(prim).GetKind() == "component"
        assert read_label(prim, names.CATEGORY) == category
    assert chair.IsInstance()
    # The lights step writes over the bulb.
    assert not lamp.IsInstance()
    assert stage.OverridePrim(f"{lamp.GetPath()}/Geometry/{names.LIGHT_BULB}")
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "layers" / "alignment.usda"))
    assert layer.GetPrimAtPath(names.WORLD).specifier == Sdf.SpecifierOver
    for reference in layer.GetCompositionAssetDependencies():
        assert reference.startswith("./alignment/")


def test_repeats_share_one_prototype_and_one_style(tmp_path: Path) -> None:
    chairs = [{"category": "chair", "at": [0.5 * i + 0.5, 1]} for i in range(6)]
    stage, _ = _compose(tmp_path, chairs)
    assert len(stage.GetPrototypes()) == 1
    assert len(list((tmp_path / "layers/alignment/assets").iterdir())) == 1


def test_another_object_changes_no_other(tmp_path: Path) -> None:
    some = [{"category": "chair", "at": [1, 1]}, {"category": "sofa", "at": [3, 3]}]
    _compose(tmp_path / "few", some)
    _compose(tmp_path / "more", [*some, {"category": "table", "at": [2, 2]}])
    few, more = _digests(tmp_path / "few"), _digests(tmp_path / "more")
    assets = {name for name in few if name.endswith((".usdc", "/chair", "/sofa"))}
    assert assets
    assert all(more[name] == few[name] for name in assets)


@pytest.mark.parametrize(
    "categories",
    [["chair", "clock"], pytest.param([*CATEGORIES], marks=pytest.mark.long)],
    ids=["few", "all"],
)
def test_equal_bytes_whatever_the_workers(categories: list[str], tmp_path: Path) -> None:
    objects = [
        {"category": name, "at": [1 + 0.3 * i, 2], "style": style}
        for name in categories
        for i, style in enumerate(CATEGORIES[name].styles)
    ]
    for workers in (1, 4):
        _compose(tmp_path / str(workers), objects, seed=5, workers=workers)
    assert _digests(tmp_path / "1") == _digests(tmp_path / "4")


def test_the_seed_chooses_styles(tmp_path: Path) -> None:
    found = set()
    for seed in range(6):
        _compose(tmp_path / str(seed), [{"category": "chair", "at": [1, 1]}], seed=seed)
        found |= {name for name in _digests(tmp_path / str(seed)) if name.endswith(".usdc")}
    assert len(found) == 6


@pytest.mark.parametrize(
    "categories",
    [[*CATEGORIES][::8], pytest.param([*CATEGORIES], marks=pytest.mark.slow)],
    ids=["few", "all"],
)
def test_valid_for_everybody(
    categories: list[str], tmp_path: Path, assert_valid: Callable[..., None]
) -> None:
    _compose(
        tmp_path, [{"category": name, "at": [1 + 0.5 * i, 2]} for i, name in enumerate(categories)]
    )
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "layers" / "layout.usda"))
    scene = Sdf.Layer.CreateNew(str(tmp_path / "scene.usda"))
    scene.TransferContent(layer)
    for prim in list(scene.rootPrims):
        del scene.rootPrims[prim.name]
    scene.customLayerData = {"creator": "openrooms_usd"}
    scene.subLayerPaths = ["./layers/alignment.usda", "./layers/layout.usda"]
    scene.Save()
    assert_valid(tmp_path / "scene.usda", without=("material",))


def test_the_users_own_mesh(tmp_path: Path) -> None:
    text = (
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\ng top\nf 1 2 3 4\ng side\nf 1 4 5\nf 1 5 2\n"
    )
    (tmp_path / "thing.obj").write_text(text)
    stage, _ = _compose(
        tmp_path,
        [
            {
                "from": "file",
                "category": "piano",
                "file": "thing.obj",
                "at": [1, 1],
                "size": [1.5, 0.6, 1.0],
                "name": "grand",
            },
            {
                "from": "file",
                "category": "piano",
                "file": "thing.obj",
                "at": [3, 1],
                "size": [1.5, 0.6, 1.0],
            },
        ],
    )
    np.testing.assert_allclose(
        _bound(stage, "grand"), [[0.25, 0.7, 0], [1.75, 1.3, 1.0]], atol=1e-6
    )
    assert len(stage.GetPrototypes()) == 1
    grand = stage.GetPrimAtPath(f"{names.FURNITURE}/grand")
    assert read_label(grand, names.CATEGORY) == "piano"
    assert read_label(grand, names.OPENROOMS45) == "piano"


def test_a_broken_mesh_leaves_the_layer_as_it_was(tmp_path: Path) -> None:
    _compose(tmp_path, [{"category": "chair", "at": [1, 1]}])
    before = _digests(tmp_path)
    (tmp_path / "thing.obj").write_text("v 0 0 0\nf 1 2 3\n")
    with pytest.raises(DescriptionError, match=r"objects\[0\]: piano_0: .*thing.obj:2"):
        _compose(
            tmp_path, [{"from": "file", "category": "piano", "file": "thing.obj", "at": [1, 1]}]
        )
    assert _digests(tmp_path) == before


def test_an_unknown_style_names_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError) as caught:
        _compose(tmp_path, [{"category": "chair", "at": [1, 1], "style": "throne"}])
    assert "slat" in str(caught.value)
    assert "chair_0" in str(caught.value)


def _box(label: str, center: Any, size: Any, yaw: float = 0.0, key: str = "id") -> CapturedBox:
    c, s = np.cos(np.radians(yaw)), np.sin(np.radians(yaw))
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return CapturedBox(key, label, np.array(center), rotation, np.array(size), "medium")


class _Importer:
    """Gives a capture without any file format."""

    options: Mapping[str, str] = {}

    def __init__(self, *boxes: CapturedBox) -> None:
        self.boxes = boxes

    def read(self, source: Path, options: Mapping[str, str]) -> Capture:
        return Capture(source.name, np.eye(4), boxes=self.boxes)


def _capture(monkeypatch: pytest.MonkeyPatch, folder: Path, *boxes: CapturedBox) -> dict[str, Any]:
    monkeypatch.setattr(adapters, "load", lambda group, name: _Importer(*boxes))
    folder.mkdir(exist_ok=True)
    (folder / "Room.json").write_text("{}")
    return {"from": "roomplan", "file": "Room.json"}


def test_captured_boxes_are_filled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    section = _capture(
        monkeypatch,
        tmp_path,
        _box("table", (2, 2, 0.37), (1.4, 0.8, 0.7), 30.0, "first"),
        _box("chair", (1, 1, 0.41), (0.5, 0.5, 0.8), key="c1"),
        _box("chair", (3, 1, 0.4), (0.5, 0.5, 0.8), 90.0, "c2"),
        _box("refrigerator", (0.5, 3, 0.9), (0.6, 0.6, 1.8), key="r"),
        _box("television", (4, 3.5, 1.4), (1.2, 0.08, 0.7), key="t"),
        _box("unheard_of", (4, 1, 0.5), (0.5, 0.5, 1.0), key="u"),
    )
    objects = [{"category": "table_lamp", "at": [2, 2]}, {"category": "chair", "at": [4, 2]}]
    stage, notes = _compose(tmp_path, objects, **section)
    children = stage.GetPrimAtPath(names.FURNITURE).GetChildren()
    assert [prim.GetName() for prim in children] == [
        "table_first",
        "chair_c1",
        "chair_c2",
        "refrigerator_r",
        "television_t",
        "unheard_of_u",
        "table_lamp_0",
        "chair_0",
    ]
    table = children[0]
    # What begins near the floor stands on it.
    translate, turn = UsdGeom.Xformable(table).GetOrderedXformOps()
    assert translate.Get() == (2, 2, 0)
    assert tuple(turn.Get()) == pytest.approx((0.0, 0.0, 30.0))
    assert table.GetAttribute("openrooms:source:id").Get() == "first"
    assert table.GetAttribute("openrooms:source:file").Get() == "Room.json"
    assert table.GetAttribute("openrooms:source:confidence").Get() == "medium"
    assert "OpenRoomsSourceAPI" in table.GetPrimTypeInfo().GetAppliedAPISchemas()
    assert _bound(stage, "television_t")[:, 2] == pytest.approx([1.05, 1.75])
    assert _bound(stage, "table_lamp_0")[0, 2] == pytest.approx(0.7)
    assert read_label(children[3], names.CATEGORY) == "refrigerator"
    # Equal boxes are the same asset.
    assert children[1].GetPrototype() == children[2].GetPrototype()
    assert any("unheard_of" in note for note in notes)
    assert not any("refrigerator" in note for note in notes)
    assert read_label(children[5], names.CATEGORY) == "unheard_of"


def test_a_captured_box_is_met_by_its_corners(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    box = _box("storage", (2, 2, 1.0), (1.2, 0.4, 1.0), 37.0)
    section = _capture(monkeypatch, tmp_path, box)
    stage, _ = _compose(tmp_path, [], **section)
    corners = np.stack(np.meshgrid(*[(-0.5, 0.5)] * 3), axis=-1).reshape(-1, 3) * box.size
    world = box.center + corners @ box.rotation.T
    found = np.concatenate(
        [m.world_points() for m in read_meshes(stage) if m.path.startswith(names.FURNITURE)]
    )
    # Every point lies in the box, and the object reaches all of its sides.
    local = (found - box.center) @ box.rotation / box.size
    np.testing.assert_allclose(
        [local.min(axis=0), local.max(axis=0)], [[-0.5] * 3, [0.5] * 3], atol=1e-5
    )
    assert found[:, 2].min() == pytest.approx(world[:, 2].min())


def test_names_stay_when_others_join(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    boxes = [
        _box("chair", (1, 1, 0.4), (0.5, 0.5, 0.8), key="a"),
        _box("chair", (2, 1, 0.4), (0.5, 0.5, 0.8), key="b"),
    ]
    section = _capture(monkeypatch, tmp_path, *boxes)
    further = [
        {"category": "chair", "at": [3, 3], "name": "chair_1"},
        {"category": "chair", "at": [4, 3]},
    ]
    stage, _ = _compose(tmp_path, further, **section)
    children = stage.GetPrimAtPath(names.FURNITURE).GetChildren()
    assert [prim.GetName() for prim in children] == ["chair_a", "chair_b", "chair_1", "chair_0"]


def test_a_change_in_what_a_model_refers_to_is_noticed(tmp_path: Path) -> None:
    _mesh_usd(tmp_path / "part.usda", 1.0)
    (tmp_path / "whole.usda").write_text(WHOLE)
    (tmp_path / "a.obj").write_text("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n")
    (tmp_path / "a.mtl").write_text("newmtl a\nKd 1 0 0\nmap_Kd a.png\n")
    (tmp_path / "a.png").write_bytes(b"")
    room = Room.model_validate(
        {"furniture": {"objects": [_own("whole.usda"), _own("a.obj"), _own("missing.usd")]}}
    )
    step = AlignmentStep()
    found = list(step.inputs(room, tmp_path))
    assert found == ["whole.usda", "a.obj", "missing.usd", "a.mtl", "a.png", "part.usda"]
    # What is missing refers to nothing; it is named when it is read.
    assert list(step.inputs(room, tmp_path / "absent")) == found[:3]


def test_the_geometry_of_referenced_files_is_part_of_the_key(tmp_path: Path) -> None:
    assets = set()
    for depth in (1.0, 2.0):
        folder = tmp_path / str(depth)
        _mesh_usd(folder / "part.usda", depth)
        (folder / "whole.usda").write_text(WHOLE)
        stage, _ = _compose(folder, [_own("whole.usda")])
        assert np.ptp(_bound(stage, "stool_0")[:, 1]) == pytest.approx(depth)
        assets |= {path.name for path in (folder / "layers/alignment/assets").iterdir()}
    assert len(assets) == 2


def test_the_licence_of_a_model_stays_with_it(tmp_path: Path) -> None:
    assets = set()
    for terms in ("CC-BY-4.0", "CC0"):
        folder = tmp_path / terms
        _mesh_usd(folder / "part.usda", 1.0, {"license": terms})
        (folder / "whole.usda").write_text(WHOLE)
        stage, _ = _compose(folder, [_own("whole.usda")])
        prim = stage.GetPrimAtPath(f"{names.FURNITURE}/stool_0")
        assert prim.GetAssetInfoByKey("license") == terms
        assets.add(prim.GetAssetInfoByKey("name"))
    assert len(assets) == 2


def _own(file: str) -> dict[str, Any]:
    return {"category": "stool", "at": [1, 1], "from": "file", "file": file}


def _mesh_usd(path: Path, depth: float, info: dict[str, str] | None = None) -> None:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, "/A").GetPrim()
    root.SetAssetInfo(info or {})
    stage.SetDefaultPrim(root)
    define_mesh(stage, "/A/body", box((1.0, depth, 1.0)))
    path.parent.mkdir(exist_ok=True)
    stage.GetRootLayer().Export(str(path))


def test_a_real_capture(tmp_path: Path, real: Callable[[str], Path]) -> None:
    source = real("roomplan_libroom/Room.json")
    (tmp_path / "Room.json").write_bytes(source.read_bytes())
    stage, _ = _compose(tmp_path, [], **{"from": "roomplan", "file": "Room.json"})
    wanted = json.loads(source.read_text())["objects"]
    assert len(stage.GetPrimAtPath(names.FURNITURE).GetChildren()) == len(wanted)
