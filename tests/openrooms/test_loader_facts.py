"""What the published loaders do with the files, as facts: shapes, orders, thresholds, assertions.

The loaders are those of InverseRenderingOfIndoorScene, IndoorLightEditing and rui-indoorinv-data;
they read pictures with OpenCV, which gives blue, green, red.
"""

import pickle
import struct
from pathlib import Path

import h5py
import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.rendering.datasets import DatasetOptions
from openrooms_usd.rendering.reading import RenderedScene, RenderedView
from orusd_openrooms import OpenRoomsDataset

SPLITS = ("main_xml", "mainDiffMat_xml", "mainDiffLight_xml")
SCENE = "scene0000_00"


@pytest.fixture(scope="module")
def root(render: RenderedScene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A merged dataset, which is what these loaders read; a path without the words they replace."""
    root = tmp_path_factory.mktemp("legacy") / "data"
    options = DatasetOptions(SCENE, SPLITS, layout="merged")
    OpenRoomsDataset().write([render] * 3, root, options)
    return root


@pytest.fixture(scope="module")
def view(render: RenderedScene) -> RenderedView:
    return render.views["view_0"]


def imread(path: str) -> np.ndarray:
    """As OpenCV reads: blue, green, red."""
    return OpenImageIO.ImageBuf(path).get_pixels()[..., ::-1]


def images(root: Path, split: str = "main_xml") -> list[str]:
    """The pictures that a loader finds: by its lists, from 1."""
    scenes = (root / "train.txt").read_text().splitlines()
    return [
        name for s in scenes for name in sorted(map(str, (root / split / s.strip()).glob("im_*")))
    ]


def test_lists_and_numbers(root: Path) -> None:
    assert [Path(name).name for name in images(root)] == ["im_1.hdr", "im_2.hdr"]
    assert (root / "test.txt").read_text() == ""


@pytest.mark.parametrize("split", SPLITS)
def test_paths_made_by_replacing_words_lead_to_files(root: Path, split: str) -> None:
    for name in images(root, split):
        found = {
            name.replace("im_", f"{stem}_").replace("hdr", "png")
            for stem in ("imbaseColor", "imroughness", "imnormal", "immask")
        }
        found |= {name.replace("im_", f"{stem}_") for stem in ("imenv", "imshading")}
        found |= {name.replace("im_", "imdepth_").replace("hdr", "dat")}
        found |= {name.replace("im_", "imsemLabel_").replace(".hdr", ".npy")}
        found |= {name.replace("im_", "imshadingDirect_").replace(".hdr", ".rgbe")}
        shared = {path.replace("DiffLight", "").replace("DiffMat", "") for path in found}
        variants = {path.replace("main_", "mainDiffLight_") for path in shared}
        for path in found | shared | variants:
            assert Path(path).is_file(), path


def test_an_image_is_flipped_by_the_loader_and_is_red_first(root: Path, view: RenderedView) -> None:
    image = np.transpose(imread(images(root)[0]), [2, 0, 1])[::-1]
    expected = view.pixels["radiance"]
    assert image.shape == (3, 48, 64)
    bound = expected.max(axis=-1) / 200
    assert (np.abs(image.transpose(1, 2, 0) - expected) <= bound[..., None]).all()


def test_environment_maps_reshape_without_a_flip(root: Path, view: RenderedView) -> None:
    rows, columns = 12, 16
    picture = imread(images(root)[0].replace("im_", "imenv_"))
    assert picture.shape == (rows * 16, columns * 32, 3)
    loaded = picture.reshape(rows, 16, columns, 32, 3).transpose([4, 0, 2, 1, 3])
    expected = view.grid("environment")
    assert expected is not None
    assert loaded.shape == (3, rows, columns, 16, 32)
    # The loaders multiply it with images that are red first.
    np.testing.assert_allclose(loaded, expected.transpose(4, 0, 1, 2, 3), atol=500 / 200)
    direct = imread(images(root)[0].replace("im_", "imenvDirect_"))
    assert direct.shape == (rows // 4 * 16, columns // 4 * 32, 3)


def test_the_loaders_own_integral_is_the_shading(root: Path) -> None:
    """Weights sin(theta) pi^2 / 512 and cos(theta) at the middle of every cell."""
    env = imread(images(root)[0].replace("im_", "imenv_"))
    env = env.reshape(12, 16, 16, 32, 3).transpose([0, 2, 1, 3, 4])
    theta = (np.arange(16) + 0.5) / 16 * np.pi / 2
    weight = np.sin(theta) * np.cos(theta) * np.pi * np.pi / 32 / 16
    summed = np.einsum("rceak,e->rck", env, weight)
    shading = imread(images(root)[0].replace("im_", "imshading_"))[..., ::-1]
    np.testing.assert_allclose(shading, summed, rtol=0.01)


def test_depth_has_its_size_first(root: Path, view: RenderedView) -> None:
    path = Path(images(root)[0].replace("im_", "imdepth_").replace("hdr", "dat"))
    with path.open("rb") as file:
        height = struct.unpack("i", file.read(4))[0]
        width = struct.unpack("i", file.read(4))[0]
        data = file.read(4 * width * height)
        assert file.read() == b""
    depth = np.asarray(struct.unpack("f" * height * width, data), np.float32)
    np.testing.assert_array_equal(depth.reshape(height, width), view.pixels["depth"][..., 0])


def test_masks_meet_the_thresholds(root: Path, view: RenderedView) -> None:
    path = images(root)[0].replace("im_", "immask_").replace("hdr", "png")
    seg = imread(path)
    assert seg.shape == (48, 64, 3)  # a picture of one channel breaks the loaders' transposition
    seg = 0.5 * ((np.round(seg[..., 0] * 255) - 127.5) / 127.5 + 1)
    valid, emits = (view.pixels[name][..., 0] > 0 for name in ("valid", "emission_mask"))
    np.testing.assert_array_equal(np.logical_and(seg > 0.49, seg < 0.51), emits)
    np.testing.assert_array_equal(seg < 0.1, ~valid)
    np.testing.assert_array_equal(seg > 0.9, valid & ~emits)
    np.testing.assert_array_equal(np.logical_and(seg > 0.05, seg < 0.95), emits)
    np.testing.assert_array_equal(seg > 0.99, valid & ~emits)


def test_base_color_by_the_power_of_2_2(root: Path, view: RenderedView) -> None:
    path = images(root)[0].replace("im_", "imbaseColor_").replace("hdr", "png")
    stored = (np.round(imread(path)[..., ::-1] * 255) - 127.5) / 127.5
    albedo = (0.5 * (stored + 1)) ** 2.2
    np.testing.assert_allclose(albedo, view.pixels["base_color"], atol=2.2 * 0.5 / 255 + 1e-3)


def test_roughness_and_normals(root: Path, view: RenderedView) -> None:
    path = images(root)[0].replace("im_", "imroughness_").replace("hdr", "png")
    rough = imread(path)
    assert (rough[..., 0] == rough[..., 2]).all()
    np.testing.assert_allclose(rough[..., 0:1], view.pixels["roughness"], atol=0.51 / 255)
    path = images(root)[0].replace("im_", "imnormal_").replace("hdr", "png")
    normal = imread(path)[..., ::-1] * 2 - 1
    normal = normal / np.sqrt(np.maximum((normal**2).sum(-1, keepdims=True), 1e-5))
    seen = view.pixels["valid"][..., 0] > 0
    np.testing.assert_allclose(normal[seen], view.pixels["normal_camera"][seen], atol=0.01)
    assert (imread(path)[~seen] == 0).all()


def test_labels_are_the_45_classes(root: Path, view: RenderedView) -> None:
    labels = np.load(images(root)[0].replace("im_", "imsemLabel_").replace(".hdr", ".npy"))
    assert labels.shape == (48, 64) and set(np.unique(labels)) == {0, 43, 44}
    assert (1 - (labels == 43)).astype(np.float32).dtype == np.float32


def test_parts_aggregate_into_materials(root: Path, view: RenderedView) -> None:
    """rui-indoorinv-data: one number for each (model, material), 0 for sky and lights."""
    path = images(root)[0].replace("im_", "imcadmatobj_").replace("hdr", "dat")
    data = Path(path).read_bytes()
    parts = np.frombuffer(data, "<i4", offset=8).reshape(48, 64, 3)
    assert struct.unpack_from("ii", data) == (48, 64)
    emits, valid = (view.pixels[name][..., 0] > 0 for name in ("emission_mask", "valid"))
    aggregate, count = np.zeros((48, 64), np.int64), 0
    for model in np.unique(parts[..., 0]):
        inside = parts[..., 0] == model
        if list(np.unique(parts[inside][:, 2])) == [0]:
            continue
        single = np.zeros_like(aggregate)
        single[inside] = parts[inside][:, 1]
        for material in np.unique(parts[inside][:, 1]):
            count += 1
            aggregate[single == material] = count
    np.testing.assert_array_equal(aggregate > 0, valid & ~emits)
    assert count == 2  # a floor and a wall


def test_lobes_have_six_numbers(root: Path, view: RenderedView) -> None:
    path = images(root)[0].replace("im_", "imsgEnv_").replace("hdr", "h5")
    with h5py.File(path, "r") as file:
        assert file["data"].compression == "lzf"
        lobes = np.array(file.get("data"))
    assert lobes.shape == (12, 16, 12, 6)
    np.testing.assert_array_equal(lobes, view.fit("environment_sg"))


def test_shading_divides_by_channels_of_the_grid(root: Path) -> None:
    for name in ("imshading_1.hdr", "imshadingDirect_1.rgbe"):
        assert imread(str(root / "main_xml" / SCENE / name)).shape == (12, 16, 3)


def test_visibility_says_which_kind_is_seen(root: Path) -> None:
    info = pickle.loads((root / "main_xml" / SCENE / "light_1/visibility.dat").read_bytes())
    assert info == {"isVisLamp": True, "isVisWindow": True}
