"""The readers refuse what is no such file, with its name; and read what other tools write."""

import shutil
import struct
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.loading.opening import open_source
from openrooms_usd.loading.transforms import flipped
from openrooms_usd.rendering.datasets import DatasetOptions, Layout
from openrooms_usd.rendering.reading import RenderedScene
from orusd_openrooms import OpenRoomsDataset, readers
from orusd_openrooms.pickles import pickled

CHANNELS = tuple(
    (
        "radiance base_color roughness normal normal_camera depth distance position semantic valid"
        " emission_mask"
    ).split()
)
SIZE = struct.pack("<ii", 2, 3)


def stored(path: Path, array: np.ndarray) -> bytes:
    np.save(path, array)
    return path.read_bytes()


DAMAGED: list[tuple[Callable[[Path], object], str, bytes]] = [
    (readers.read_depth, "dat", b"\x01"),
    (readers.read_depth, "dat", SIZE + b"\0" * 20),
    (readers.read_depth, "dat", SIZE + b"\0" * 28),
    (readers.read_depth, "dat", struct.pack("<ii", -2, -3) + b"\0" * 24),
    (readers.read_depth, "dat", struct.pack("<ii", 2**30, 2**30)),
    (readers.read_depth, "dat", struct.pack("<ii", 0, 5)),
    (readers.read_parts, "dat", SIZE + b"\0" * 24),
    (readers.read_mask, "png", b"\x89PNG nothing"),
    (readers.read_light, "hdr", b"#?RADIANCE\n\n-Y 2 +X 2\n"),
    (readers.read_labels, "npy", b"nothing"),
    (readers.read_lobes, "h5", b"nothing"),
    (readers.read_light_box, "dat", pickled({"isWindow": True})),
    (readers.read_light_box, "dat", pickled([1, 2])),
]


@pytest.mark.parametrize(("read", "suffix", "data"), DAMAGED)
def test_damaged_files_are_refused_by_name(
    read: Callable[[Path], object], suffix: str, data: bytes, tmp_path: Path
) -> None:
    path = tmp_path / f"file.{suffix}"
    path.write_bytes(data)
    with pytest.raises(InputError) as caught:
        read(path)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    "read",
    [
        readers.read_depth,
        readers.read_parts,
        readers.read_mask,
        readers.read_light,
        readers.read_labels,
        readers.read_lobes,
        readers.read_light_box,
        readers.read_cameras,
        readers.read_environments,
    ],
)
def test_missing_files_are_refused_by_name(read: Callable[[Path], object], tmp_path: Path) -> None:
    with pytest.raises(InputError, match="none"):
        read(tmp_path / "none")


def test_labels_that_are_objects_are_not_loaded(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.array([[None]]), allow_pickle=True)
    with pytest.raises(InputError, match="not a readable array"):
        readers.read_labels(tmp_path / "a.npy")
    for odd in (np.zeros(3, int), np.zeros((2, 2))):
        np.save(tmp_path / "a.npy", odd)
        with pytest.raises(InputError, match=r"not a readable array: [12] dim"):
            readers.read_labels(tmp_path / "a.npy")


def test_an_array_of_other_sizes_is_no_fit(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["data"] = np.zeros((3, 4, 12, 5))
    with pytest.raises(InputError, match="not what is expected"):
        readers.read_lobes(tmp_path / "a.h5")


def huge(file: h5py.File) -> None:
    file.create_dataset("data", (2**20, 2**20, 12, 6), "f4", chunks=(1, 1, 12, 6))


def outside(file: h5py.File) -> None:
    raw = Path(file.filename).parent / "raw"
    raw.write_bytes(b"\0" * 288)
    file.create_dataset("data", (1, 1, 12, 6), "f4", external=[(str(raw), 0, 288)])


@pytest.mark.parametrize(
    "fill",
    [
        huge,
        outside,
        lambda file: file.create_group("data"),
        lambda file: file.create_dataset("data", data="text"),
        lambda file: file.create_dataset("data", data=h5py.Empty("f4")),
        lambda file: file.create_dataset("data", (1, 1, 12, 6), "i4"),
        lambda file: file.create_dataset("data", (0, 1, 12, 6), "f4"),
        lambda file: file.__setitem__("data", h5py.ExternalLink("other.h5", "/data")),
        lambda file: file.__setitem__("data", h5py.SoftLink("/data")),
    ],
)
def test_lobes_are_an_array_in_the_file_itself(
    fill: Callable[[h5py.File], object], tmp_path: Path
) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        fill(file)
    with pytest.raises(InputError, match=r"a\.h5: (not what is expected|no data set|its data set)"):
        readers.read_lobes(tmp_path / "a.h5")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "x",
        "-1\n",
        "1\n0 0 0\n",
        "1\n" + "0 0 nan\n" * 3,
        "99999999999999999999\n0 0 0\n",
        "1\n0 0\n0 0 0\n0 0 0\n",
        "1\n0 0 \u00e9\n",
    ],
)
def test_what_is_no_list_of_cameras(text: str, tmp_path: Path) -> None:
    (tmp_path / "cam.txt").write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError, match=r"cam\.txt: not a list of cameras"):
        readers.read_cameras(tmp_path / "cam.txt")


@pytest.mark.parametrize("text", ["", "[]", "3", '{"views": 3}', '{"views": [1]}', "[" * 10**5])
def test_what_is_no_list_of_views(text: str, tmp_path: Path) -> None:
    (tmp_path / "views.json").write_text(text)
    with pytest.raises(InputError, match=r"views\.json: not a list of views"):
        readers.read_view_names(tmp_path / "views.json")


def test_a_grey_picture_is_refused(tmp_path: Path) -> None:
    grey = OpenImageIO.ImageBuf(np.zeros((4, 4, 1), np.uint8))
    assert grey.write(str(tmp_path / "a.png"), "uint8")
    with pytest.raises(InputError, match="not 3 of 8 bits"):
        readers.read_mask(tmp_path / "a.png")


def test_every_file_of_a_view_reads_back(render: RenderedScene, tmp_path: Path) -> None:
    """One look at all of them; the encodings have tests of their own."""
    OpenRoomsDataset().write([render], tmp_path, DatasetOptions(layout="merged"))
    folder, view = tmp_path / "main_xml/scene0000_00", render.views["view_1"]
    seen = view.pixels["valid"][..., 0] > 0
    base = readers.read_base_color(folder / "imbaseColor_2.png")
    np.testing.assert_allclose(base, view.pixels["base_color"], atol=6e-3)
    rough = readers.read_roughness(folder / "imroughness_2.png")
    np.testing.assert_allclose(rough, view.pixels["roughness"][..., 0], atol=2.1e-3)
    normals = readers.read_normal(folder / "imnormal_2.png")
    assert (normals[~seen] == 0).all()
    assert ((normals * view.pixels["normal_camera"]).sum(-1)[seen] > 0.9999).all()
    mask = readers.read_mask(folder / "immask_2.png")
    np.testing.assert_array_equal(mask["sky"], ~seen)
    np.testing.assert_array_equal(sum(mask.values()), 1)
    depth = readers.read_depth(folder / "imdepth_2.dat")
    np.testing.assert_array_equal(depth, view.pixels["depth"][..., 0])
    labels = readers.read_labels(folder / "imsemLabel_2.npy")
    np.testing.assert_array_equal(labels, view.pixels["semantic"][..., 0])
    lobes = readers.read_lobes(folder / "imsgEnv_2.h5")
    np.testing.assert_array_equal(lobes, view.fit("environment_sg"))
    parts = readers.read_parts(folder / "imcadmatobj_2.dat")
    emits = view.pixels["emission_mask"][..., 0] > 0
    np.testing.assert_array_equal(parts[~emits][:, 2], view.pixels["instance"][~emits][:, 0])
    assert (parts[emits][:, 2] == 0).all() and (parts[emits][:, 0] > 2).all()
    assert (parts[seen][:, 1] == view.pixels["material"][seen][:, 0] + 1).all()


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
    with pytest.raises(InputError, match="there is no view"):
        open_source(tmp_path, form="openrooms")
    with pytest.raises(InputError, match="has no option 'ordre'"):
        open_source(written, form="openrooms", options={"ordre": "rgb"})
    with pytest.raises(InputError, match="is not an order of channels"):
        open_source(written, form="openrooms", options={"order": "bgr"})
    with pytest.raises(InputError, match=r"do not have 'radiance_i'"):
        open_source(written, form="openrooms").read(0, ["radiance_i"])
