"""Annotations of a real render, against projections of the raw meshes by other code."""

import json
import shutil
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
from click.testing import CliRunner
from pxr import Gf, Usd, UsdGeom, Vt

from openrooms_usd.cli.labelling import labels
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError
from openrooms_usd.rendering import render_stage
from openrooms_usd.rendering.boxes import _tightest, boxes
from openrooms_usd.rendering.coco import coco
from openrooms_usd.usd.semantics import label
from tests.commands import run

WIDTH, HEIGHT = 96, 72
CHANNELS = ["instance", "semantic", "semantic_nyu40", "semantic_ade20k", "semantic_coco"]


def _box(stage: Usd.Stage, path: str, size: tuple[float, float, float]) -> UsdGeom.Mesh:
    mesh = UsdGeom.Mesh.Define(stage, path)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy((corners * size).astype(np.float32)))
    faces = [0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3]
    mesh.CreateFaceVertexIndicesAttr(faces)
    mesh.CreateFaceVertexCountsAttr([4] * 6)
    mesh.CreateSubdivisionSchemeAttr("none")
    return mesh


THINGS = {
    # name: category, size, place, heading; the second stands partly behind the first.
    "near": ("armchair", (0.8, 0.7, 0.9), (-0.2, 0.0, 0.45), 30.0),
    "far": ("rug", (1.5, 0.4, 0.6), (0.5, 1.2, 0.3), -20.0),
    "through": ("wall", (0.1, 9.0, 1.0), (-1.4, -2.0, 0.5), 0.0),
    "strange": ("contraption", (0.3, 0.3, 0.3), (1.0, -0.4, 1.2), 10.0),
    "plain": ("", (0.2, 0.2, 0.2), (0.9, -0.5, 0.2), 0.0),
}


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("annotated") / "scene.usda"
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    for name, (category, size, place, heading) in THINGS.items():
        thing = UsdGeom.Xform.Define(stage, f"/World/{name}")
        thing.AddTranslateOp().Set(Gf.Vec3d(*place))
        thing.AddRotateZOp().Set(heading)
        _box(stage, f"/World/{name}/body", size)
        if category:
            label(thing.GetPrim(), category)
    for name, eye in (("front", (0.2, -3.2, 1.5)), ("side", (3.4, -0.6, 1.1))):
        camera = UsdGeom.Camera.Define(stage, f"/World/{name}")
        pose = Gf.Matrix4d().SetLookAt(Gf.Vec3d(*eye), Gf.Vec3d(0, 0.3, 0.5), Gf.Vec3d(0, 0, 1))
        camera.AddTransformOp().Set(pose.GetInverse())
        camera.CreateFocalLengthAttr(20.0)
    stage.Save()
    return path


@pytest.fixture(scope="module")
def shots(scene: Path, fastest: str) -> Path:
    out = scene.with_name("shots")
    render_stage(
        scene,
        out,
        RenderSettings(channels=CHANNELS, resolution=(WIDTH, HEIGHT), options={"variant": fastest}),
    )
    return out


def _name(row: dict) -> str:
    """An unlabelled mesh is an object of its own."""
    return row["prim"].split("/")[2]


def _ids(shots: Path, view: str, channel: str = "instance") -> np.ndarray:
    picture = OpenImageIO.ImageBuf(str(shots / view / "channels.exr"))
    plane = picture.spec().channelnames.index(f"{channel}.Y")
    return picture.get_pixels(OpenImageIO.FLOAT)[..., plane].astype(int)


def _decoded(segmentation: dict) -> np.ndarray:
    """A compressed mask, by arithmetic on whole numbers."""
    height, width = segmentation["size"]
    counts, value, shift = [], 0, 0
    for character in segmentation["counts"]:
        group = ord(character) - 48
        value += (group % 32) * 32**shift
        shift += 1
        if group < 32:
            value -= 32**shift if group >= 16 else 0
            counts.append(value + (counts[len(counts) - 2] if len(counts) > 2 else 0))
            value, shift = 0, 0
    runs = np.repeat(np.arange(len(counts)) % 2, counts)
    return runs.reshape(width, height).T.astype(bool)


def test_masks_areas_and_boxes_are_those_of_the_instance_channel(shots: Path) -> None:
    found = coco([shots])
    manifest = json.loads((shots / "manifest.json").read_text())
    names = {image["id"]: image["file_name"].split("/")[0] for image in found["images"]}
    assert sorted(names.values()) == ["front", "side"]
    classes = {row["id"]: row["name"] for row in found["categories"]}
    seen = set()
    for row in found["annotations"]:
        view = names[row["image_id"]]
        mask = _decoded(row["segmentation"])
        np.testing.assert_array_equal(mask, _ids(shots, view) == row["instance"])
        assert row["area"] == mask.sum() > 0
        y, x = np.nonzero(mask)
        assert row["bbox"] == [x.min(), y.min(), np.ptp(x) + 1, np.ptp(y) + 1]
        assert manifest["legend"]["instance"][str(row["instance"])] == row["prim"]
        assert classes[row["category_id"]] == THINGS[_name(row)][0]
        seen.add(row["prim"])
    assert seen == {f"/World/{name}" for name in THINGS if name != "plain"}
    assert len({row["id"] for row in found["annotations"]}) == len(found["annotations"])


# Numbers of the classes that a list has, and of those of them that are seen, by their things.
LISTS = {
    "nyu40": (set(range(1, 41)), {"near": 5, "far": 40, "through": 1}),
    "ade20k": (set(range(1, 151)), {"near": 31, "far": 29, "through": 1}),
    "coco": (set(range(1, 91)) - {12, 26, 29, 30, 45, 66, 68, 69, 71, 83}, {"near": 62}),
}


@pytest.mark.parametrize("taxonomy", LISTS)
def test_classes_of_another_taxonomy_are_those_of_its_channel(shots: Path, taxonomy: str) -> None:
    found = coco([shots], taxonomy)
    numbers, seen = LISTS[taxonomy]
    assert {row["id"] for row in found["categories"]} == numbers
    names = {image["id"]: image["file_name"].split("/")[0] for image in found["images"]}
    for row in found["annotations"]:
        view = names[row["image_id"]]
        here = _ids(shots, view) == row["instance"]
        assert set(_ids(shots, view, f"semantic_{taxonomy}")[here]) == {row["category_id"]}
    by_prim = {row["prim"]: row["category_id"] for row in found["annotations"]}
    assert by_prim == {f"/World/{name}": number for name, number in seen.items()}


@pytest.fixture(scope="module")
def house(shots: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Two rooms, each with a render."""
    folder = tmp_path_factory.mktemp("house")
    return [shutil.copytree(shots, folder / room / "day") for room in ("kitchen", "study")]


def test_many_renders_make_one_file(house: list[Path], tmp_path: Path) -> None:
    one, two = coco(house[:1], "coco"), coco(house, "coco")
    assert two["categories"] == one["categories"]
    assert {"id": 67, "name": "dining table", "supercategory": "furniture"} in two["categories"]
    for group in ("images", "annotations"):
        assert [row["id"] for row in two[group]] == list(range(1, 2 * len(one[group]) + 1))
    files = [image["file_name"] for image in two["images"]]
    assert len(set(files)) == len(files) == 4
    assert all((house[0].parents[1] / file).is_file() for file in files)
    seen = [row["image_id"] for row in two["annotations"]]
    assert seen == [1, 2, 3, 4]  # the armchair
    with pytest.raises(InputError, match="given twice"):
        coco([*house, house[0]])
    paths = [str(path) for path in house]
    run = CliRunner().invoke(labels, [*paths, "-o", str(tmp_path / "x.json"), "--format", "boxes"])
    assert isinstance(run.exception, InputError) and "separately" in str(run.exception.remedy)


def test_the_old_name_of_the_command_writes_the_same(house: list[Path], tmp_path: Path) -> None:
    for name in ("labels", "annotate"):
        words = [name, str(house[0]), "-o", str(tmp_path / name)]
        assert run(*words).exit_code == 0
    assert (tmp_path / "labels").read_bytes() == (tmp_path / "annotate").read_bytes()


# Its compiled part asks numpy for copies in the old way.
@pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")
def test_pycocotools_reads_it(house: list[Path], tmp_path: Path) -> None:
    client = pytest.importorskip("pycocotools.coco")
    evaluation = pytest.importorskip("pycocotools.cocoeval")
    file = tmp_path / "coco.json"
    paths = [str(path) for path in house]
    run = CliRunner().invoke(labels, [*paths, "-o", str(file), "--taxonomy", "coco"])
    assert run.exit_code == 0, run.output
    truth = client.COCO(str(file))
    (chair,) = truth.getCatIds(catNms=["chair"])
    assert chair == 62 and len(truth.getImgIds(catIds=[chair])) == 4
    for row in truth.loadAnns(truth.getAnnIds()):
        view = house[0].parents[1] / truth.loadImgs(row["image_id"])[0]["file_name"]
        mask = _ids(view.parents[1], view.parent.name) == row["instance"]
        np.testing.assert_array_equal(truth.annToMask(row), mask)
    # Who finds all that there is, and no more, has a precision and a recall of 1.
    keys = ("image_id", "category_id", "segmentation", "bbox")
    found = [
        {key: row[key] for key in keys} | {"score": 1.0} for row in truth.dataset["annotations"]
    ]
    score = evaluation.COCOeval(truth, truth.loadRes(found), "segm")
    score.evaluate()
    score.accumulate()
    score.summarize()
    assert score.stats[0] == 1.0


def test_projected_corners_enclose_the_masks(shots: Path, scene: Path) -> None:
    stage = Usd.Stage.Open(str(scene))
    found = boxes(shots, stage)
    manifest = json.loads((shots / "manifest.json").read_text())
    hidden = 0
    for view, entry in found["views"].items():
        K = np.array(manifest["views"][view]["K"])
        pose = np.array(manifest["views"][view]["world_from_camera"])
        for row in entry["objects"]:
            mesh = stage.GetPrimAtPath(f"/World/{_name(row)}/body")
            to_world = UsdGeom.XformCache().GetLocalToWorldTransform(mesh)
            corners = [
                to_world.Transform(Gf.Vec3d(p)) for p in UsdGeom.Mesh(mesh).GetPointsAttr().Get()
            ]
            local = (np.array(corners) - pose[:3, 3]) @ pose[:3, :3]
            y, x = np.nonzero(_ids(shots, view) == row["instance"])
            assert row["box2d"] == [x.min(), y.min(), x.max() + 1, y.max() + 1]
            left, top, right, bottom = row["box2d_projected"]
            assert left <= x.min() + 0.5 and x.max() + 0.5 <= right
            assert top <= y.min() + 0.5 and y.max() + 0.5 <= bottom
            if (local[:, 2] > 0.01).all():
                u, v = (K @ local.T)[:2] / local[:, 2]
                u, v = np.clip(u, 0, WIDTH), np.clip(v, 0, HEIGHT)
                np.testing.assert_allclose(
                    row["box2d_projected"], [u.min(), v.min(), u.max(), v.max()], atol=2e-3
                )
                hidden += np.abs(np.subtract(row["box2d_projected"], row["box2d"])).max() > 5
            else:
                assert row["prim"] == "/World/through"
    assert hidden, "something is partly behind something"


def test_boxes_in_space_are_the_things_themselves(shots: Path, scene: Path) -> None:
    found = boxes(shots, Usd.Stage.Open(str(scene)))
    assert any(view["objects"] for view in found["views"].values())
    for view in found["views"].values():
        camera_from_world = np.linalg.inv(view["world_from_camera"])
        for row in view["objects"]:
            _, size, place, heading = THINGS[_name(row)]
            world, seen = row["box3d_world"], row["box3d_camera"]
            np.testing.assert_allclose(world["center"], place, atol=1e-5)
            np.testing.assert_allclose(world["size"], size, atol=1e-5)
            c, s = np.cos(np.radians(heading)), np.sin(np.radians(heading))
            turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
            np.testing.assert_allclose(world["axes"], turn, atol=1e-5)
            center = camera_from_world @ [*place, 1.0]
            np.testing.assert_allclose(seen["center"], center[:3], atol=1e-5)
            np.testing.assert_allclose(seen["axes"], camera_from_world[:3, :3] @ turn, atol=1e-5)
            assert seen["center"][2] > -5 and seen["size"] == world["size"]


@pytest.mark.parametrize("degrees", [0.0, 20.0, 45.0, 110.0])
def test_a_wall_without_a_frame_of_its_own_has_the_box_that_fits(degrees: float) -> None:
    corners = np.array([[x, y, z] for x in (0, 4) for y in (0, 0.2) for z in (0, 2.5)])
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    axes = _tightest(corners @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]))
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert axes[0, 0] > 0.7
    lengths = np.abs(axes.T @ [c, s, 0.0])
    assert np.sort(lengths).tolist() == pytest.approx([0.0, 0.0, 1.0], abs=1e-9)


def test_the_command_writes_the_same_bytes_again(shots: Path, scene: Path, tmp_path: Path) -> None:
    for options in ([], ["--taxonomy", "ade20k"], ["--format", "boxes", "--stage", str(scene)]):
        for name in ("a.json", "b.json"):
            run = CliRunner().invoke(labels, [str(shots), "-o", str(tmp_path / name), *options])
            assert run.exit_code == 0, run.output
        assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()
        assert str(shots.parent) not in (tmp_path / "a.json").read_text()


def test_what_cannot_be_annotated_is_refused_with_a_remedy(
    shots: Path, scene: Path, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match="not a finished render"):
        coco([tmp_path])
    manifest = json.loads((shots / "manifest.json").read_text())
    view = tmp_path / "bare" / "front"
    view.mkdir(parents=True)
    del manifest["channels"]["instance"]
    manifest["views"] = {"front": manifest["views"]["front"]}
    (tmp_path / "bare" / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(InputError, match="no channel instance") as caught:
        coco([tmp_path / "bare"])
    assert "--channels all" in str(caught.value.remedy)
    moved = Usd.Stage.Open(Usd.Stage.Open(str(scene)).Flatten())
    moved.GetPrimAtPath("/World/near").GetAttribute("xformOp:translate").Set(Gf.Vec3d(0.6, 0, 0.45))
    with pytest.raises(InputError, match="/World/near, which this stage does not have"):
        boxes(shots, moved)
    moved.RemovePrim("/World/near")
    with pytest.raises(InputError, match="/World/near"):
        boxes(shots, moved)
    run = CliRunner().invoke(labels, [str(shots), "-o", "x.json", "--format", "boxes"])
    assert run.exit_code != 0 and isinstance(run.exception, InputError)
    assert "--stage" in str(run.exception.remedy)
