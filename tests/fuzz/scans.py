"""Sound scans in the folders of ScanNet, SUN RGB-D and ARKitScenes, as small as can be."""

import json
from functools import partial
from pathlib import Path

import numpy as np

from tests.fuzz.kinds import Kind, planting
from tests.scans import test_arkitscenes, test_scannet_frames, test_scannet_scene, test_sunrgbd
from tests.scans.test_scan2cad import annotation

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
