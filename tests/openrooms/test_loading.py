"""Views of OpenRooms' files: what was written comes out again, as far as files carry it."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.loading.mirroring import flipped
from openrooms_usd.loading.opening import open_source
from openrooms_usd.render.datasets import DatasetOptions, Layout
from openrooms_usd.render.reading import RenderedScene
from orusd_openrooms import OpenRoomsDataset

CHANNELS = (
    "radiance", "base_color", "roughness", "normal", "normal_camera", "depth", "distance",
    "position", "semantic", "valid", "emission_mask",
)  # fmt: skip


@pytest.fixture(scope="module", params=["split", "merged"])
def written(
    request: pytest.FixtureRequest, render: RenderedScene, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    layout: Layout = request.param
    root = tmp_path_factory.mktemp(layout) / "data"
    splits = ("main_xml", "mainDiffMat_xml", "mainDiffLight_xml")
    for scene, subset in (("scene0001_00", "train"), ("scene0002_00", "val")):
        options = DatasetOptions(scene, splits, subset, layout, crowded="keep")  # type: ignore[arg-type]
        OpenRoomsDataset().write([render] * 3, root, options)
    return root


def test_what_was_rendered_comes_out_again(written: Path, render: RenderedScene) -> None:
    source = open_source(written, form="openrooms", variants=["main_xml"], split="train")
    assert len(source) == len(render.views) == 2
    for index, view in enumerate(render.views.values()):
        found = source.read(index, CHANNELS)
        assert found.name == f"scene0001_00/main_xml/{index + 1}"
        assert found.about == {"room": "scene0001_00", "variant": "main_xml", "split": "train"}
        np.testing.assert_allclose(found.K, view.K, rtol=1e-8)
        np.testing.assert_allclose(found.world_from_camera, view.world_from_camera, atol=3e-6)
        stored = view.pixels
        whole = stored["radiance"].max(axis=-1, keepdims=True)
        # RGBE keeps eight bits of the largest component.
        assert (np.abs(found.images["radiance"] - stored["radiance"]) <= whole / 256 + 1e-6).all()
        np.testing.assert_array_equal(found.images["depth"], stored["depth"])
        np.testing.assert_array_equal(found.images["semantic"][..., 0], view.labels("semantic"))
        np.testing.assert_allclose(found.images["base_color"], stored["base_color"], atol=0.005)
        np.testing.assert_allclose(found.images["roughness"], stored["roughness"], atol=0.003)
        # Eight bits a component.
        np.testing.assert_allclose(
            found.images["normal_camera"], stored["normal_camera"], atol=0.01
        )
        np.testing.assert_array_equal(found.images["valid"] > 0, stored["valid"] > 0)
        # Positions again by the render's own camera.
        depth, (height, width) = stored["depth"], stored["depth"].shape[:2]
        u, v = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
        pixels = np.stack([u, v, np.ones_like(u)], axis=-1)
        camera = pixels @ np.linalg.inv(view.K).T * depth
        world = camera @ view.world_from_camera[:3, :3].T + view.world_from_camera[:3, 3]
        there = depth[..., 0] > 0
        np.testing.assert_allclose(found.images["position"][there], world[there], atol=5e-5)
        np.testing.assert_allclose(
            found.images["distance"][there, 0], np.linalg.norm(camera[there], axis=-1), rtol=1e-6
        )
        turn = view.world_from_camera[:3, :3] @ np.diag([1.0, -1.0, -1.0])
        normal = stored["normal_camera"] @ turn.T
        np.testing.assert_allclose(found.images["normal"], normal, atol=0.015)


def test_hemispheres_come_in_either_order(written: Path, render: RenderedScene) -> None:
    source = open_source(written, form="openrooms")
    # Two scenes, three variants, two frames; what a variant has not of its own is that of main.
    assert len(source) == 12
    stored = render.views[sorted(render.views)[0]].grid("environment")
    assert stored is not None
    found = source.read(0, ["environment", "depth"])
    grid = found.grids["environment"]
    whole = stored.max(axis=-1, keepdims=True)
    assert (np.abs(grid - stored) <= whole / 256 + 1e-6).all()
    assert flipped(found).grids["environment"].shape == grid.shape
    other = open_source(written, form="openrooms", options={"order": "rgb"})
    np.testing.assert_array_equal(
        other.read(0, ["environment"]).grids["environment"], grid[..., ::-1]
    )
    for index in range(12):
        assert source.read(index, ["depth", "base_color"]).size == (64, 48)


def test_what_a_variant_lacks_is_that_of_main(written: Path, tmp_path: Path) -> None:
    """In one folder for each variant, too, the release has what variants share only once."""
    shutil.copytree(written, tmp_path / "data")
    for kind in ("imbaseColor", "imdepth", "imsemLabel"):
        for path in (tmp_path / "data/mainDiffLight_xml").rglob(f"{kind}_*"):
            path.unlink()
    channels = ["radiance", "base_color", "depth", "semantic"]
    lit, main = (
        open_source(tmp_path / "data", form="openrooms", variants=[split]).read(0, channels)
        for split in ("mainDiffLight_xml", "main_xml")
    )
    for name in channels:
        np.testing.assert_array_equal(lit.images[name], main.images[name])


def test_the_field_of_view_is_that_of_the_scene_file(written: Path, tmp_path: Path) -> None:
    shutil.copytree(written, tmp_path / "data")
    folder = tmp_path / "data/scenes/xml/scene0001_00"
    (folder / "intrinsic.txt").unlink()
    shape = '<shape type="obj" id="a"><string name="filename" value="uv_mapped/a.obj"/></shape>'
    sensor = '<sensor type="perspective"><float name="fov" value="90"/></sensor>'
    (folder / "main.xml").write_text(f'<scene verion="0.5.0">{shape}{sensor}</scene>')
    source = open_source(tmp_path / "data", form="openrooms", rooms=["scene0001_00"])
    K = source.read(0, ["depth"]).K
    np.testing.assert_allclose(K, [[320, 0, 320], [0, 320, 240], [0, 0, 1]], rtol=1e-9)


def test_mistakes_are_told(written: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no view is there"):
        open_source(tmp_path, form="openrooms")
    with pytest.raises(InputError, match="has no option 'ordre'"):
        open_source(written, form="openrooms", options={"ordre": "rgb"})
    with pytest.raises(InputError, match="is no order of channels"):
        open_source(written, form="openrooms", options={"order": "bgr"})
    with pytest.raises(InputError, match=r"do not tell 'radiance_i'"):
        open_source(written, form="openrooms").read(0, ["radiance_i"])
