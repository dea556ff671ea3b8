"""A real Scan2CAD annotation goes the whole way, and its CADs lie on the real scan."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from tests.commands import output_of

FLOOR = {"floor": [[-0.1, -0.1], [3.6, -0.1], [3.6, 3.0], [-0.1, 3.0]], "height": 2.5}

pytestmark = pytest.mark.slow


@dataclass(frozen=True)
class Sample:
    """The files of Scan2CAD's sample."""

    root: Path

    @property
    def annotation(self) -> Path:
        return self.root / "Routines/Script/example_annotation.json"

    @property
    def models(self) -> Path:
        return self.root / "Assets/shapenet-sample"

    @property
    def mesh(self) -> Path:
        return self.root / "Assets/scannet-sample/scene0470_00/scene0470_00_vh_clean_2.ply"


@pytest.fixture(scope="module")
def sample(real: Callable[[str], Path]) -> Sample:
    return Sample(real("scan2cad_scene0470_00"))


@pytest.fixture(scope="module")
def composed(sample: Sample, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scan2cad")
    (folder / "floor.json").write_text(json.dumps(FLOOR))
    options = (
        "--scan",
        "scene0470_00",
        "--models",
        sample.models,
        "--polygon",
        folder / "floor.json",
    )
    output_of("import", "scan2cad", sample.annotation, *options, "-o", folder / "room")
    output_of("compose", folder / "room/room.yaml", "-o", folder / "out")
    return folder / "out/scene.usda"


def scan(sample: Sample) -> np.ndarray:
    """The scan's vertices, read by its header's words alone."""
    data = sample.mesh.read_bytes()
    header, _, body = data.partition(b"end_header\n")
    count = int(header.split(b"element vertex ")[1].split()[0])
    row = np.dtype([("p", "<f4", 3), ("rgba", "u1", 4)])
    return np.frombuffer(body, row, count)["p"].astype(float)


def expected(sample: Sample) -> dict[str, np.ndarray]:
    """Points of every CAD's faces in the scan, from the annotation and the OBJ files alone."""
    (entry,) = json.loads(sample.annotation.read_text())
    found = {}
    for model in entry["aligned_models"]:
        path = sample.models / model["catid_cad"] / model["id_cad"] / "models/model_normalized.obj"
        lines = [line.split() for line in path.read_text().splitlines()]
        points = np.array([[float(x) for x in words[1:4]] for words in lines if words[:1] == ["v"]])
        faces = [word for words in lines if words[:1] == ["f"] for word in words[1:]]
        points = points[np.unique([int(word.partition("/")[0]) - 1 for word in faces])]
        M = np.linalg.inv(_matrix(entry["trs"])) @ _matrix(model["trs"])
        # Which of the equal CADs it is, whatever else stands in the list.
        again = sum(key.endswith(model["id_cad"]) for key in found)
        found[f"{again}_{model['id_cad']}"] = points @ M[:3, :3].T + M[:3, 3]
    return found


def _matrix(trs: dict) -> np.ndarray:
    w, x, y, z = trs["rotation"]
    M = np.eye(4)
    M[:3, :3] = Rotation.from_quat([x, y, z, w]).as_matrix() @ np.diag(trs["scale"])
    M[:3, 3] = trs["translation"]
    return M


def in_scan(stage: Usd.Stage, prim: Usd.Prim) -> np.ndarray:
    """All composed points below a prim, in the frame of the scan (row vectors)."""
    source_from_world = np.array(
        stage.GetPrimAtPath("/World/Room").GetAttribute("openrooms:source:fromWorld").Get()
    )
    found = []
    for mesh in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()):
        if mesh.IsA(UsdGeom.Mesh):
            M = np.array(UsdGeom.Xformable(mesh).ComputeLocalToWorldTransform(0))
            points = np.array(UsdGeom.Mesh(mesh).GetPointsAttr().Get(), dtype=float)
            found.append(np.column_stack([points, np.ones(len(points))]) @ M @ source_from_world)
    return np.concatenate(found)[:, :3]


def furniture(stage: Usd.Stage) -> dict[str, Usd.Prim]:
    """Captured objects by their identifiers."""
    children = stage.GetPrimAtPath("/World/Furniture").GetChildren()
    rows = {prim.GetAttribute("openrooms:source:id").Get(): prim for prim in children}
    return {key: prim for key, prim in rows.items() if key}


def test_the_cads_lie_on_the_scan(composed: Path, sample: Sample) -> None:
    stage = Usd.Stage.Open(str(composed))
    objects, scanned = furniture(stage), cKDTree(scan(sample))
    wanted = expected(sample)
    assert objects.keys() == wanted.keys()
    for key, points in wanted.items():
        found = in_scan(stage, objects[key])
        # The same points, to a tenth of a millimetre, from numbers that our code never touched.
        assert cKDTree(points).query(found)[0].max() < 1e-4, key
        assert cKDTree(found).query(points)[0].max() < 1e-4, key
        assert np.median(scanned.query(points)[0]) < 0.07, key


def test_repeats_share_an_asset_and_tilts_are_kept(composed: Path) -> None:
    stage = Usd.Stage.Open(str(composed))
    objects = furniture(stage)
    asset = {
        key: str(prim.GetMetadata("references").prependedItems[0].assetPath)
        for key, prim in objects.items()
    }
    twins = [key for key in objects if key.endswith("2c03bcb2a133ce28bb6caad47eee6580")]
    assert len({asset[key] for key in twins}) == 1
    assert len(set(asset.values())) == 6
    chair = objects[twins[0]]
    names = [op.GetOpName() for op in UsdGeom.Xformable(chair).GetOrderedXformOps()]
    assert names == ["xformOp:translate", "xformOp:rotateXYZ", "xformOp:scale"]
    roll, pitch, _ = chair.GetAttribute("xformOp:rotateXYZ").Get()
    assert 0.5 < np.hypot(roll, pitch) < 5.0


def test_it_is_valid(composed: Path) -> None:
    assert "clean" in output_of("validate", "--strict", composed)


def test_boxes_take_the_place_of_cads_that_are_missing(
    composed: Path, sample: Sample, tmp_path: Path
) -> None:
    floor = tmp_path / "floor.json"
    floor.write_text(json.dumps(FLOOR))
    output_of("import", "scan2cad", sample.annotation, "--polygon", floor, "-o", tmp_path / "room")
    output_of("compose", tmp_path / "room/room.yaml", "-o", tmp_path / "out")
    stages = [Usd.Stage.Open(str(path)) for path in (composed, tmp_path / "out/scene.usda")]
    real, boxes = map(furniture, stages)
    assert {key: prim.GetName() for key, prim in boxes.items()} == {
        key: prim.GetName() for key, prim in real.items()
    }
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default", "render"])
    for key in real:
        bounds = [cache.ComputeWorldBound(found[key]) for found in (real, boxes)]
        ranges = [bound.ComputeAlignedRange() for bound in bounds]
        middles = [np.array(found.GetMidpoint()) for found in ranges]
        assert np.linalg.norm(middles[0][:2] - middles[1][:2]) < 0.08, key
        assert ranges[0].GetSize()[2] == pytest.approx(ranges[1].GetSize()[2], abs=0.1), key
