"""The readers refuse what is no such file, with its name; and read what other tools write."""

import struct
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.render.datasets import DatasetOptions
from openrooms_usd.render.reading import RenderedScene
from orusd_openrooms import OpenRoomsDataset, readers
from orusd_openrooms.pickles import pickled

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
        readers.read_depth, readers.read_parts, readers.read_mask, readers.read_light,
        readers.read_labels, readers.read_lobes, readers.read_light_box, readers.read_cameras,
        readers.read_environments,
    ],
)  # fmt: skip
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
        huge, outside,
        lambda file: file.create_group("data"),
        lambda file: file.create_dataset("data", data="text"),
        lambda file: file.create_dataset("data", data=h5py.Empty("f4")),
        lambda file: file.create_dataset("data", (1, 1, 12, 6), "i4"),
        lambda file: file.create_dataset("data", (0, 1, 12, 6), "f4"),
        lambda file: file.__setitem__("data", h5py.ExternalLink("other.h5", "/data")),
        lambda file: file.__setitem__("data", h5py.SoftLink("/data")),
    ],
)  # fmt: skip
def test_lobes_are_an_array_in_the_file_itself(
    fill: Callable[[h5py.File], object], tmp_path: Path
) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        fill(file)
    with pytest.raises(InputError, match=r"a\.h5: (not what is expected|no data set|its data set)"):
        readers.read_lobes(tmp_path / "a.h5")


@pytest.mark.parametrize(
    "text",
    ["", "x", "-1\n", "1\n0 0 0\n", "1\n" + "0 0 nan\n" * 3, "99999999999999999999\n0 0 0\n",
     "1\n0 0\n0 0 0\n0 0 0\n", "1\n0 0 \u00e9\n"],
)  # fmt: skip
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
