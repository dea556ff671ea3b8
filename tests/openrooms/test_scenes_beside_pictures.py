"""A room's meshes and ``main.xml`` beside pictures of it, as the 3D loader asks for them."""

import shutil
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError
from openrooms_usd.rendering import render_stage
from openrooms_usd.rendering.datasets import DatasetOptions, write_dataset
from openrooms_usd.rendering.reading import read_render
from orusd_openrooms.readers import read_cameras
from tests.folders import contents

SPLITS = ("main_xml", "mainDiffMat_xml")
FOV_DEG = 57.95


@pytest.fixture(scope="module")
def rendered(composed_demo: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pictures") / "render"
    render_stage(
        composed_demo,
        folder,
        RenderSettings(
            channels=["radiance", "instance"],
            options={"variant": "scalar"},
            resolution=(16, 12),
            samples=1,
            field_of_view=FOV_DEG,
        ),
    )
    return folder


@pytest.fixture(scope="module")
def root(rendered: Path, composed_demo: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("both") / "data"
    options = DatasetOptions(splits=SPLITS, layout="merged", stages=(composed_demo,) * 2)
    write_dataset([rendered] * 2, root, options=options)
    return root


@pytest.mark.slow
@pytest.mark.parametrize("split", SPLITS)
def test_what_the_3d_loader_opens_is_there(root: Path, split: str) -> None:
    scene = root / "scenes/xml/scene0000_00"
    tree = ElementTree.parse(scene / f"{split.partition('_')[0]}.xml").getroot()
    names = [shape.find("string").get("value") for shape in tree.findall("shape")]
    assert names[0].endswith("uv_mapped.obj") and names[1].endswith("container.obj")
    pictures = [one.find("string").get("value") for one in tree.iter("texture")]
    (sky,) = tree.findall("emitter")
    for name in (*names, *pictures, sky.find("string").get("value")):
        assert (scene / name).is_file(), name
    assert (root / "layoutMesh/scene0000_00/uv_mapped.obj").is_file()
    folder = root / split / "scene0000_00"
    lights = sorted(folder.glob("light_3SG-SkyGrd_*.dat"))
    assert len(lights) == len([*folder.glob("box*.dat")]) > 0
    windows = sum("window" in name for name in names)
    lamps = sum(name.endswith("aligned_light.obj") for name in names)
    assert len(lights) == windows + lamps
    assert (root / "scenes/intrinsic.txt").is_file()


@pytest.mark.slow
def test_the_scene_has_the_cameras_of_the_pictures(root: Path, rendered: Path) -> None:
    tree = ElementTree.parse(root / "scenes/xml/scene0000_00/main.xml").getroot()
    sensor = tree.find("sensor")
    assert float(sensor.find("float").get("value")) == pytest.approx(FOV_DEG, abs=1e-3)
    film = {one.get("name"): int(one.get("value")) for one in sensor.iter("integer")}
    assert (film["width"], film["height"]) == (16, 12)
    views = read_render(rendered).views
    cameras = read_cameras(root / "scenes/xml/scene0000_00/cam.txt")
    assert len(cameras) == len(views)
    K = np.loadtxt(root / "scenes/intrinsic.txt")
    np.testing.assert_allclose(K[:3, :3], next(iter(views.values())).K, atol=1e-4)


@pytest.mark.slow
def test_another_room_leaves_those_that_are_there(
    root: Path, rendered: Path, composed_demo: Path, tmp_path: Path
) -> None:
    """Things of two rooms have the same names, and other shapes."""
    shutil.copytree(root, tmp_path / "data")
    before = contents(tmp_path / "data")
    options = DatasetOptions(scene="scene0001_00", layout="merged", stages=(composed_demo,))
    write_dataset([rendered], tmp_path / "data", options=options)
    after = contents(tmp_path / "data")
    changed = {name for name in before if after[name] != before[name]}
    assert changed == {"train.txt"}
    assert "scenes/xml/scene0001_00/main.xml" in after
    # Maps are named by what they hold, and are there once.
    maps = {name for name in after if name.startswith("BRDFOriginDataset")}
    assert maps and maps <= before.keys()


@pytest.mark.slow
def test_a_second_time_the_bytes_are_the_same(
    root: Path, rendered: Path, composed_demo: Path
) -> None:
    before = contents(root)
    options = DatasetOptions(splits=SPLITS, layout="merged", stages=(composed_demo,) * 2)
    write_dataset([rendered] * 2, root, options=options)
    assert contents(root) == before


@pytest.mark.slow
def test_each_render_has_its_stage(rendered: Path, composed_demo: Path, tmp_path: Path) -> None:
    options = DatasetOptions(splits=SPLITS, stages=(composed_demo,))
    with pytest.raises(InputError, match="2 renders and 1 stages"):
        write_dataset([rendered] * 2, tmp_path / "data", options=options)
    assert not (tmp_path / "data").exists()
    options = DatasetOptions(stages=(tmp_path / "none.usda",))
    with pytest.raises(InputError, match=r"none\.usda"):
        write_dataset([rendered], tmp_path / "data", options=options)
    assert not (tmp_path / "data").exists()
