"""Real captures, where they are there: counts, extents, and what projects onto what."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.capture import read_capture
from openrooms_usd.steps.alignment.instances import instances_of

Real = Callable[[str], Path]


def test_a_scene_of_scannet_with_its_cads(real: Real) -> None:
    root = real("scan2cad_scene0470_00")
    options = {
        "annotation": str(root / "Routines/Script/example_annotation.json"),
        "models": str(root / "Assets/shapenet-sample"),
    }
    folder = root / "Assets/scannet-sample/scene0470_00"
    capture = read_capture("scannet", folder, options)
    assert len(capture.cloud) > 67_000
    assert np.ptp(capture.cloud.points, axis=0) == pytest.approx([3.49, 2.85, 1.37], abs=0.01)
    assert {1, 2, 5, 7} <= set(capture.cloud.label.tolist())
    assert len(capture.models) == 7
    from scipy.spatial import cKDTree

    tree = cKDTree(capture.cloud.points)
    middles = []
    for asked in (capture, read_capture("scannet", folder, options | {"official_centre": "yes"})):
        distances = []
        for model in asked.models:
            lines = model.file.read_text().splitlines()
            points = np.array([line.split()[1:4] for line in lines if line[:2] == "v "], float)
            M = model.world_from_model
            distances.append(np.median(tree.query(points @ M[:3, :3].T + M[:3, 3])[0]))
        middles.append(float(np.mean(distances)))
    # The annotation's own transforms fit the scan; the scorer's lie off by the CAD's centre.
    assert middles[0] < 0.035
    assert middles[1] > 1.3 * middles[0]


def test_a_sweep_of_a_laser_scanner(real: Real) -> None:
    capture = read_capture("scan", real("pcl_room_scan/room_scan1.pcd"), {"unit": "auto"})
    assert capture.settled == {}
    assert "56427 duplicated points were dropped" in capture.notes
    assert len(capture.cloud) == 112_586 - 56_427


def test_a_frame_of_sun_rgbd_projects_onto_its_picture(real: Real) -> None:
    import OpenImageIO

    root = real("sunrgbd_sample")
    capture = read_capture("sunrgbd", root / "sunrgbd_000017_infos.pkl")
    (frame,) = capture.frames
    pixels = capture.cloud.points @ frame.world_from_camera[:3, :3] @ frame.K.T
    # The centres of pixels stand at halves, so each point falls into the middle of its own.
    columns, rows = np.floor(pixels[:, :2] / pixels[:, 2:]).astype(int).T
    image = OpenImageIO.ImageBuf(str(root / "000017.jpg")).get_pixels(OpenImageIO.UINT8)
    assert image.shape[:2] == frame.resolution[::-1]
    assert (image[rows, columns, :3] == capture.cloud.colors).all()
    labels = {box.label: box for box in capture.boxes}
    inside = {
        name: int(
            (np.abs((capture.cloud.points - b.center) @ b.rotation) < b.size / 2).all(1).sum()
        )
        for name, b in labels.items()
    }
    assert inside["bed"] > 18_000
    assert inside["night_stand"] > 900


@pytest.mark.slow
def test_a_scene_of_scannet_keeps_its_words(real: Real) -> None:
    """The table of labels lies beside it, and trash cans are bins that stand on the floor."""
    cloud = read_capture("scannet", real("real_dev/data/scannet_0000_00")).cloud
    assert cloud is not None
    found = {one.number: one for one in instances_of(cloud) or ()}
    assert found[13].words[:2] == ("trashcan", "ashcan")
    said = {n: one.hint.choices for n, one in found.items() if one.meaning.kind == "thing"}
    assert [said[n][0][0] for n in (13, 46, 47, 50, 54)] == [
        "trash_bin",
        "microwave",
        "basket",
        "night_stand",
        "toaster",
    ]
    assert [said[n][0][0] for n in (5, 12, 19, 48, 49, 52)] == [
        "shower",
        "scales",
        "backpack",
        "guitar",
        "tissue_box",
        "dish_rack",
    ]


@pytest.mark.slow
def test_what_a_scan_calls_other_is_a_box(real: Real) -> None:
    cloud = read_capture("scan", real("real_dev/data/scannet_0002_00/scan.ply")).cloud
    assert cloud is not None
    found = instances_of(cloud) or []
    bins = [one for one in found if one.words[0].startswith("other")]
    assert len(bins) > 20
    assert all(not one.meaning.choices for one in bins)
