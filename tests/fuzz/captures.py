"""Sound captures and scans: RoomPlan, Scan2CAD, boxes, ScanNet, SUN RGB-D and ARKitScenes."""

import json
from functools import partial
from pathlib import Path

import numpy as np

from tests.fuzz.kinds import Kind, planting
from tests.scans import test_arkitscenes, test_scannet_frames, test_scannet_scene, test_sunrgbd
from tests.scans.conftest import Scanner
from tests.scans.roomplan_usdz import full_room, layers_of, pack
from tests.scans.test_scan2cad import annotation

CORNERS = [[0, 0], [4, 0], [4, 3], [0, 3]]
COMPOSED = "name: c\nroom: office\nmaterials: {{resolution: 16}}\n{0}"


def write_frames(path: Path) -> None:
    """Where two photographs were taken from, which look along y."""
    frames = [
        {
            "id": str(i),
            "picture": f"color/{i}.jpg",
            "resolution": [32, 24],
            "K": [[30, 0, 16], [0, 30, 12], [0, 0, 1]],
            "world_from_camera": [
                [1, 0, 0, 1 + 0.1 * i],
                [0, 0, 1, 0.2 * i],
                [0, -1, 0, 1.2],
                [0, 0, 0, 1],
            ],
        }
        for i in range(2)
    ]
    path.write_text(json.dumps(frames))


def _roomplan(folder: Path) -> None:
    scanner = Scanner(folder)
    scanner.write(full_room(scanner))
    sections = "layout: {from: roomplan, file: Room.json}\n"
    sections += "furniture: {from: roomplan, file: Room.json}\n"
    (folder / "room.yaml").write_text(COMPOSED.format(sections))


def _roomplan_usdz(folder: Path) -> None:
    pack(folder / "Room.usdz", layers_of(full_room(Scanner(folder))))


def _scan2cad(folder: Path) -> None:
    (folder / "full_annotations.json").write_text(json.dumps([annotation()]))
    door = {"kind": "door", "center": [2, 0, 1.05], "width": 0.9, "height": 2.0, "open": True}
    floor = {"floor": CORNERS, "level": 0.0, "height": 2.5, "openings": [door]}
    (folder / "floor.json").write_text(json.dumps(floor))
    (folder / "floor.csv").write_text("x,y\n" + "".join(f"{x},{y}\n" for x, y in CORNERS))
    models = folder / "models/03001627/chairone/models"
    models.mkdir(parents=True)
    (models / "model_normalized.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\nf 2 3 4\n"
    )


def _boxes(folder: Path) -> None:
    (folder / "boxes.csv").write_text(
        "id,label,x,y,z,width,depth,height,yaw\na,chair,1,2,0,0.5,0.6,0.9,30\n"
        "b,desk,3,1,0,1.6,0.8,0.75,\n"
    )
    boxes = [
        {"id": "a", "label": "chair", "center": [1, 2, 0.45], "size": [0.5, 0.6, 0.9], "yaw": 30},
        {"id": "b", "label": "desk", "center": [3, 1, 0.375], "size": [1.6, 0.8, 0.75]},
    ]
    (folder / "boxes.json").write_text(json.dumps({"objects": boxes, "floor": CORNERS}))
    (folder / "floor.csv").write_text("x,y\n" + "".join(f"{x},{y}\n" for x, y in CORNERS))
    (folder / "floor.json").write_text(json.dumps({"floor": CORNERS, "height": 2.5}))
    write_frames(folder / "frames.json")


_CAD = "import scan2cad {in}/full_annotations.json -o {out} --polygon {in}/floor"
_BOXES = "import boxes {in}/boxes"
SCENE, VIDEO = test_scannet_scene.NAME, test_arkitscenes.ID
# One in so many points of a wall.
_EVERY = 42


def floor_points(step: float = 0.2) -> np.ndarray:
    """(N, 3) points of a floor."""
    x, y = np.meshgrid(np.arange(0, 4, step), np.arange(0, 3, step), indexing="ij")
    return np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], -1)


def _scannet(folder: Path) -> None:
    inner = test_scannet_scene.scene(folder / SCENE, floor_points())
    with (inner / f"{SCENE}.txt").open("a") as text:
        text.write("colorHeight = 96\ncolorWidth = 128\n")
    test_scannet_scene.sens(inner / f"{SCENE}.sens", count=2)
    (folder / "labels.tsv").write_text(
        "id\traw_category\tcategory\tnyu40id\tnyu40class\n1\toffice chair\tchair\t5\tchair\n"
    )
    (folder / "full_annotations.json").write_text(json.dumps([annotation(id_scan=SCENE)]))
    test_scannet_frames.export(folder / "export")


def _streams(folder: Path) -> None:
    for coding, name in enumerate(("raw", "packed")):
        (folder / name).mkdir()
        test_scannet_scene.sens(folder / f"{name}/{name}.sens", coding, count=2)


def _raw(folder: Path) -> None:
    test_sunrgbd.raw(folder / "frame")


def _arkitscenes(folder: Path) -> None:
    (folder / VIDEO).mkdir()
    test_arkitscenes.scan(folder / VIDEO, moments=3, points=floor_points())


_NET = f"import scannet {{in}}/{SCENE} -o {{out}}"
_ARKIT = f"import arkitscenes {{in}}/{VIDEO} -o {{out}}"
KINDS = (
    Kind(
        "capture.roomplan",
        planting(_roomplan),
        ((30, "import roomplan {in}/Room.json -o {out}"), (1, "compose {in}/room.yaml -o {out}")),
        ("in/Room.json",),
        share=4,
    ),
    Kind(
        "capture.roomplan-usdz",
        planting(_roomplan_usdz),
        ((1, "import roomplan {in}/Room.usdz -o {out}"),),
        share=4,
    ),
    Kind(
        "capture.scan2cad",
        planting(_scan2cad),
        ((2, f"{_CAD}.json"), (1, f"{_CAD}.csv"), (2, f"{_CAD}.json --models {{in}}/models")),
        share=3,
    ),
    Kind(
        "capture.boxes-csv",
        planting(_boxes),
        (
            (2, f"{_BOXES}.csv -o {{out}}"),
            (2, f"{_BOXES}.csv -o {{out}} --polygon {{in}}/floor.csv"),
        ),
        ("in/*.csv",),
        share=3,
    ),
    Kind(
        "capture.boxes-json",
        planting(_boxes),
        (
            (2, f"{_BOXES}.json -o {{out}} --frames {{in}}/frames.json"),
            (2, f"{_BOXES}.json -o {{out}} --polygon {{in}}/floor.json"),
        ),
        ("in/*.json",),
        share=3,
    ),
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
        planting(partial(test_sunrgbd.votenet, frames=("000017",), every=_EVERY)),
        ((1, "import sunrgbd {in} -o {out}"),),
        share=3,
    ),
    Kind(
        "capture.sunrgbd-index",
        planting(partial(test_sunrgbd.index, every=_EVERY)),
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
