"""Sound scans in the folders of ScanNet, SUN RGB-D and ARKitScenes."""

import json
import pickle
import struct
import zlib
from pathlib import Path

import numpy as np

from tests.fuzz.kinds import Kind, planting
from tests.fuzz.pictures import write_picture
from tests.scans.test_scan2cad import annotation

SCENE, VIDEO = "scene0000_00", "40000001"
SIZE = (32, 24)
K = np.array([[30.0, 0, 16], [0, 30.0, 12], [0, 0, 1]])
LEVEL = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
_HEAD = "ply\nformat binary_little_endian 1.0\nelement vertex {0}\n"
_HEAD += "property float x\nproperty float y\nproperty float z\n"


def floor_points(step: float = 0.2) -> np.ndarray:
    """(N, 3) points of a floor."""
    x, y = np.meshgrid(np.arange(0, 4, step), np.arange(0, 3, step), indexing="ij")
    return np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], -1)


def pose(i: int) -> np.ndarray:
    """world_from_camera of a photograph that looks along y."""
    M = np.eye(4)
    M[:3, :3], M[:3, 3] = LEVEL, [1 + 0.1 * i, 0.2 * i, 1.2]
    return M


def _sens(coding: int) -> bytes:
    square = np.eye(4, dtype="<f4")
    square[:3, :3] = K
    parts = [struct.pack("<IQ", 4, 3), b"lab", *[square.tobytes()] * 4]
    parts.append(struct.pack("<2i4IfQ", 2, coding, *SIZE, *SIZE, 1000.0, 3))
    for i in range(3):
        depth = np.full(SIZE[::-1], 2500 - 200 * i, "<u2").tobytes()
        blob = zlib.compress(depth) if coding == 1 else depth
        parts.append(pose(i).astype("<f4").tobytes())
        parts.append(struct.pack("<4Q", i, i, 6, len(blob)) + b"\xff\xd8jpeg"[:6] + blob)
    return b"".join(parts)


def _scannet(folder: Path) -> None:
    inner = folder / SCENE
    inner.mkdir(parents=True)
    points = floor_points()
    n = len(points)
    head = _HEAD.format(n)
    rows = points.astype("<f4")
    mesh = inner / f"{SCENE}_vh_clean_2"
    mesh.with_suffix(".ply").write_bytes(head.encode() + b"end_header\n" + rows.tobytes())
    labels = np.zeros(n, [("p", "<f4", 3), ("label", "<u2")])
    labels["p"], labels["label"] = rows, 2
    mesh.with_suffix(".labels.ply").write_bytes(
        head.encode() + b"property ushort label\nend_header\n" + labels.tobytes()
    )
    segments = np.where(points[:, 0] < 1, 100, 200)
    mesh.with_suffix(".0.010000.segs.json").write_text(
        json.dumps({"sceneId": SCENE, "segIndices": segments.tolist()})
    )
    groups = [{"id": 0, "objectId": 0, "segments": [100], "label": "office chair"}]
    (inner / f"{SCENE}.aggregation.json").write_text(json.dumps({"segGroups": groups}))
    numbers = " ".join(map(str, np.eye(4).ravel()))
    (inner / f"{SCENE}.txt").write_text(
        f"axisAlignment = {numbers} \ncolorHeight = 24\ncolorWidth = 32\nsceneType = Office\n"
    )
    (inner / f"{SCENE}.sens").write_bytes(_sens(1))
    (folder / "labels.tsv").write_text(
        "id\traw_category\tcategory\tnyu40id\tnyu40class\n1\toffice chair\tchair\t5\tchair\n"
    )
    (folder / "full_annotations.json").write_text(json.dumps([annotation(id_scan=SCENE)]))
    export = folder / "export"
    for name in ("pose", "intrinsic", "color"):
        (export / name).mkdir(parents=True)
    square = np.eye(4)
    square[:3, :3] = K
    np.savetxt(export / "intrinsic/intrinsic_color.txt", square)
    for i in range(2):
        np.savetxt(export / f"pose/{i}.txt", pose(i))
    (export / "export.txt").write_text("colorHeight = 24\ncolorWidth = 32\n")


def _streams(folder: Path) -> None:
    for coding, name in enumerate(("raw", "packed")):
        (folder / f"{name}").mkdir(parents=True)
        (folder / f"{name}/{name}.sens").write_bytes(_sens(coding))


def _wall() -> tuple[np.ndarray, np.ndarray]:
    v, u = np.mgrid[: SIZE[1], : SIZE[0]] + 0.5
    rays = np.stack([(u - 16) / 30, (v - 12) / 30, np.ones_like(u)], -1) @ LEVEL.T
    depth = 3.0 / rays[..., 1]
    return depth, (rays * depth[..., None]).reshape(-1, 3)


def _votenet(folder: Path) -> None:
    from scipy.io import savemat

    inner = folder
    for name in ("depth", "calib", "label", "image"):
        (inner / name).mkdir(parents=True)
    columns = [" ".join(map(str, M.T.ravel())) for M in (np.eye(3), K)]
    (inner / "calib/000017.txt").write_text("\n".join(columns) + "\n")
    points = _wall()[1][::3]
    rows = np.column_stack([points, np.tile([0.5, 1.0, 0.0], (len(points), 1))])
    savemat(inner / "depth/000017.mat", {"instance": rows})
    (inner / "label/000017.txt").write_text(
        "chair 1 2 30 40 0.4 2.5 -0.5 0.3 0.45 0.5 0.8 -0.5\n"
        "table 1 2 30 40 -0.4 2 -0.5 0.5 0.45 0.5 1 0\n"
    )


def _index(folder: Path) -> None:
    inner = folder
    points = _wall()[1][::3]
    rows = np.column_stack([points, np.tile([0.5, 1.0, 0.0], (len(points), 1))])
    rows.astype("<f4").tofile(inner / "000017.bin")
    box = {"bbox_3d": [0.4, 2.5, -0.5, 0.9, 0.6, 1.1, -0.5], "bbox_label_3d": 3}
    camera = {"depth2img": (K @ LEVEL.T).tolist(), "img_path": "000017.jpg"}
    entry = {
        "images": {"CAM0": camera | {"width": SIZE[0], "height": np.int32(SIZE[1])}},
        "instances": [box],
        "lidar_points": {"lidar_path": "000017.bin", "num_pts_feats": 6},
    }
    data = {"metainfo": {"DATASET": "SUNRGBD"}, "data_list": [entry]}
    (inner / "infos.pkl").write_bytes(pickle.dumps(data, 2))


def _raw(folder: Path) -> None:
    inner = folder / "frame"
    for name in ("depth_bfx", "extrinsics", "annotation3Dfinal"):
        (inner / name).mkdir(parents=True)
    (inner / "intrinsics.txt").write_text(" ".join(map(str, K.ravel())))
    np.savetxt(inner / "extrinsics/2014.txt", np.column_stack([np.eye(3), np.zeros(3)]))
    stored = np.round(1000 * _wall()[0]).astype(np.uint16)
    write_picture(inner / "depth_bfx/1.png", ((stored << 3) | (stored >> 13))[..., None])
    polygon = {"X": [0, 1, 1, 0], "Z": [2, 2, 2.5, 2.5], "Ymin": 0.2, "Ymax": 1.2}
    objects = [None, {"name": "chair", "polygon": [polygon]}]
    (inner / "annotation3Dfinal/index.json").write_text(json.dumps({"objects": objects}))


def _arkitscenes(folder: Path) -> None:
    from scipy.spatial.transform import Rotation

    scan = folder / VIDEO
    inner = scan / f"{VIDEO}_frames"
    (inner / "lowres_wide_intrinsics").mkdir(parents=True)
    lines = []
    for i in range(4):
        M = np.linalg.inv(pose(i))
        numbers = [100 + i / 5, *Rotation.from_matrix(M[:3, :3]).as_rotvec(), *M[:3, 3]]
        lines.append(" ".join(f"{number:.9f}" for number in numbers))
    (inner / "lowres_wide.traj").write_text("\n".join(lines) + "\n")
    for i in range(3):
        name = f"{VIDEO}_{100 + i / 5:.3f}"
        (inner / f"lowres_wide_intrinsics/{name}.pincam").write_text("32 24 30 30 16 12\n")
        write_picture(
            inner / f"lowres_depth/{name}.png", (np.full(SIZE[::-1], 2500, np.uint16))[..., None]
        )
        write_picture(
            inner / f"confidence/{name}.png", (np.full(SIZE[::-1], 2, np.uint8))[..., None]
        )
    rows = floor_points().astype("<f4")
    head = _HEAD.format(len(rows)) + "end_header\n"
    (scan / f"{VIDEO}_3dod_mesh.ply").write_bytes(head.encode() + rows.tobytes())
    drawn = {"centroid": [1, 2, 0.5], "axesLengths": [0.6, 1.0, 0.4]}
    drawn["normalizedAxes"] = [1, 0, 0, 0, 0, 1, 0, -1, 0]
    box = {"uid": "u1", "label": "chair", "segments": {"obbAligned": drawn}}
    (scan / f"{VIDEO}_3dod_annotation.json").write_text(json.dumps({"data": [box]}))


_NET = f"import scannet {{in}}/{SCENE} -o {{out}}"
_ARKIT = f"import arkitscenes {{in}}/{VIDEO} -o {{out}}"
KINDS = (
    Kind(
        "capture.scannet",
        planting(_scannet),
        (
            (1, _NET),
            (2, f"{_NET} --labels {{in}}/labels.tsv"),
            (1, f"{_NET} --annotation {{in}}/full_annotations.json"),
            (1, f"{_NET} --frames {{in}}/export"),
        ),
        share=4,
    ),
    Kind(
        "capture.sens",
        planting(_streams),
        (
            (1, "import scannet {in}/raw -o {out} --fuse 1"),
            (1, "import scannet {in}/packed -o {out} --fuse 1"),
        ),
        share=3,
    ),
    Kind(
        "capture.sunrgbd-folder",
        planting(_votenet),
        ((1, "import sunrgbd {in} -o {out}"),),
        share=3,
    ),
    Kind(
        "capture.sunrgbd-index",
        planting(_index),
        ((1, "import sunrgbd {in}/infos.pkl -o {out}"),),
        share=3,
    ),
    Kind(
        "capture.sunrgbd-raw", planting(_raw), ((1, "import sunrgbd {in}/frame -o {out}"),), share=2
    ),
    Kind(
        "capture.arkitscenes",
        planting(_arkitscenes),
        ((1, _ARKIT), (2, f"{_ARKIT} --fuse 1")),
        share=4,
    ),
)
