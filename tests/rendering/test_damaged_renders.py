"""Pictures and arrays of a render that are damaged, swapped or lie about their size."""

import json
import os
import random
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError, OrusdError
from openrooms_usd.rendering import Legend, exr, render_stage
from openrooms_usd.rendering.coco import coco
from openrooms_usd.rendering.reading import read_render
from openrooms_usd.rendering.relight import Relighting, relight
from openrooms_usd.unpickling.arrays import read_array
from tests.pictures import save_picture

SIZE = (8, 6)


@pytest.fixture
def render(renderer: Any, scene: Path, tmp_path: Path) -> Path:
    """One view with labels, and without lights."""
    renderer.cameras = ("/World/Cameras/left",)
    renderer.legend = Legend(instance={1: "/World/Floor"}, category={1: "floor"})
    renderer.spoil = lambda name, pixels: np.ones_like(pixels)
    channels = ("radiance", "instance", "semantic_nyu40")
    render_stage(
        scene, tmp_path / "out", RenderSettings(channels=channels, resolution=SIZE, samples=1)
    )
    return tmp_path / "out"


def write_exr(path: Path, names: list[str], size: tuple[int, int] = SIZE, value: float = 1) -> None:
    pixels = np.full((size[1], size[0], len(names)), value, np.float32)
    save_picture(path, pixels, names=names)


def labels(render: Path, value: float) -> None:
    images = {name: np.ones((6, 8, 1), np.float32) for name in ("instance", "semantic_nyu40")}
    for image in images.values():
        image[2, 3] = value
    exr.write_channels(render / "left/channels.exr", images)


def refused(render: Path, said: str, taxonomy: str = "category") -> None:
    with pytest.raises(InputError, match=said) as error:
        coco([render], taxonomy)
    assert str(render / "left/channels.exr") in str(error.value)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, -1.0, 0.5, 2.0**25])
def test_labels_are_whole_numbers(render: Path, value: float) -> None:
    labels(render, value)
    refused(render, "'instance' holds values that are not whole numbers")


def test_labels_have_names(render: Path) -> None:
    labels(render, 99.0)
    refused(render, "shows the object 99, which the manifest does not name")
    labels(render, 0.0)
    assert coco([render])["annotations"][0]["area"] == 47
    images = {"instance": np.ones((6, 8, 1)), "semantic_nyu40": np.full((6, 8, 1), 41.0)}
    exr.write_channels(render / "left/channels.exr", images)
    refused(render, "holds 41, which is not the number of a class", "nyu40")


@pytest.mark.parametrize(
    ("names", "size", "said"),
    [
        (["instance.Y"], (6, 8), "6x8 pixels, the manifest says 8x6"),
        (["instance.Y"], (9000, 1), "9000x1 pixels"),
        (["radiance.R", "radiance.G", "radiance.B"], SIZE, "no channel 'instance'"),
        (["instance.R"], SIZE, "'instance' has the parts R, not Y"),
        (["instance.Y", "instance.Z"], SIZE, "parts Y, Z, not Y"),
        (["instance.Y", "direct_3.R"], SIZE, "'direct_3' has the parts R, not R, G, B"),
    ],
)
def test_pictures_are_those_of_the_manifest(
    render: Path, names: list[str], size: tuple[int, int], said: str
) -> None:
    write_exr(render / "left/channels.exr", names, size)
    refused(render, said)


def test_layers_of_others_are_let_through(render: Path) -> None:
    write_exr(render / "left/channels.exr", ["instance.Y", "crypto00.R", "Z", "direct_i.x.y"])
    assert len(coco([render])["annotations"]) == 1


def test_a_light_that_no_manifest_names(render: Path, tmp_path: Path) -> None:
    parts = ["radiance_7.R", "radiance_7.G", "radiance_7.B"]
    write_exr(render / "left/lights.exr", [*parts, "radiance_99999999999999.R"][:3])
    with pytest.raises(
        InputError, match="the contribution of light 7, which is not in the manifest"
    ):
        relight(render, tmp_path / "relit", Relighting())


def test_a_header_that_is_no_text(render: Path) -> None:
    """The library's own messages quote it."""
    path = render / "left/channels.exr"
    write_exr(path, ["instance.Y"])
    path.write_bytes(path.read_bytes().replace(b"chlist", b"c\xfflist"))
    refused(render, "not a readable image: its header is not text")


def test_a_picture_that_claims_more_than_it_holds(render: Path) -> None:
    path = render / "left/channels.exr"
    write_exr(path, ["instance.Y"])
    window = struct.pack("<4i", 0, 0, SIZE[0] - 1, SIZE[1] - 1)
    claim = struct.pack("<4i", 0, 0, 2**15 - 1, 2**12 - 1)
    assert window in path.read_bytes()
    path.write_bytes(path.read_bytes().replace(window, claim))
    with pytest.raises(InputError, match=r"32768x4096 pixels of 1 numbers in [0-9,]+ bytes"):
        exr.read_channels(path)
    refused(render, "the manifest says 8x6")


def test_what_only_has_the_name_of_a_picture(render: Path, tmp_path: Path) -> None:
    path = render / "left/channels.exr"
    write_exr(tmp_path / "a.png", ["R", "G", "B"])
    for make in (
        lambda: os.mkfifo(path),
        lambda: path.symlink_to("/dev/zero"),
        lambda: path.symlink_to(tmp_path / "none"),
        path.mkdir,
        path.touch,
        lambda: path.write_bytes((tmp_path / "a.png").read_bytes()),
    ):
        path.rmdir() if path.is_dir() else path.unlink(missing_ok=True)
        make()
        refused(render, "a pipe|a device|a folder|no such file|not a readable|not a flat OpenEXR")


@pytest.mark.parametrize("seed", range(12))
def test_damaged_pictures_are_read_or_refused(render: Path, seed: int) -> None:
    rng, path = random.Random(seed), render / "left/channels.exr"
    whole = path.read_bytes()
    for case in range(20):
        data = bytearray(whole)
        place = rng.randrange(len(data) if case % 2 else 400)
        if case % 5 == 0:
            del data[place:]
        elif case % 5 == 1:
            data[place : place + 4] = b"\xff\xff\xff\x7f"
        elif case % 5 == 2:
            data[place:place] = bytes([rng.randrange(256)] * rng.choice((1, 4, 40)))
        else:
            data[place] = rng.randrange(256)
        path.write_bytes(bytes(data))
        try:
            json.dumps(coco([render], rng.choice(("category", "nyu40"))), allow_nan=False)
        except OrusdError as error:
            str(error).encode()


def npy(header: str, data: bytes = b"", version: bytes = b"\1\0") -> bytes:
    text = header.encode() + b"\n"
    return b"\x93NUMPY" + version + struct.pack("<H", len(text)) + text + data


FLOATS = "{'descr': '<f4', 'fortran_order': False, 'shape': %s}"
NO_ARRAYS = {
    "empty": b"",
    "text": b"nothing",
    "512 GiB": npy(FLOATS % "(8192, 4096, 4096)"),
    "too large for any machine": npy(FLOATS % f"({2**63}, {2**63}, 9)"),
    "cut off": npy(FLOATS % "(2, 3, 4)", b"\0" * 95),
    "too long": npy(FLOATS % "(2, 3, 4)", b"\0" * 97),
    "negative": npy(FLOATS % "(-2, -3, 4)", b"\0" * 96),
    "nothing in it": npy(FLOATS % "(0, 3, 4)"),
    "objects": npy(FLOATS.replace("<f4", "|O") % "(1, 1, 1)", b"\x80\x04N."),
    "texts": npy(FLOATS.replace("<f4", "<U1") % "(1, 1, 1)", b"\0" * 4),
    "other numbers": npy(FLOATS.replace("<f4", "<i4") % "(1, 1, 1)", b"\0" * 4),
    "fewer dimensions": npy(FLOATS % "(1, 1)", b"\0" * 4),
    "open bracket": npy("{'descr': '<f4', 'shape': ((("),
    "code": npy("__import__('os').system('true')"),
    "deep": npy("(" * 5000),
    "indented": npy("  \n  x\n y"),
    "another version": npy(FLOATS % "(1, 1, 1)", b"\0" * 4, b"\7\0"),
    "not text": npy(FLOATS % "(1, 1, 1)").replace(b"descr", b"d\xffscr"),
}


@pytest.mark.parametrize("data", NO_ARRAYS.values(), ids=NO_ARRAYS)
def test_what_is_no_array(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "a.npy").write_bytes(data)
    with pytest.raises(InputError, match="not a readable array"):
        read_array(tmp_path / "a.npy", 3, "f")


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("kind", ["<f4", ">f4", "<f8"])
def test_arrays_are_read_as_they_were_written(tmp_path: Path, order: Any, kind: str) -> None:
    values = np.asarray(np.random.default_rng(0).random((2, 3, 4)), kind, order=order)
    np.save(tmp_path / "a.npy", values)
    np.testing.assert_array_equal(read_array(tmp_path / "a.npy", 3, "f"), values)


def test_a_fit_has_the_numbers_of_its_kind(render: Path) -> None:
    view = read_render(render).views["left"]
    for name, depth in (("environment_sg", 6), ("environment_sh", 3)):
        np.save(render / "left" / f"{name}.npy", np.ones((3, 4, 9, depth), np.float32))
        found = view.fit(name)
        assert found is not None and found.shape == (3, 4, 9, depth)
        np.save(render / "left" / f"{name}.npy", np.ones((3, 4, 9, 5), np.float32))
        with pytest.raises(InputError, match=f"{name} has 5 numbers"):
            view.fit(name)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 3e38, -3e38])
def test_light_may_be_any_number(render: Path, tmp_path: Path, value: float) -> None:
    manifest = json.loads((render / "manifest.json").read_text())
    manifest["lights"] = [
        {
            "number": 0,
            "name": "lamp",
            "kind": "lamp",
            "on": True,
            "size": [1, 1, 1],
            "world_from_box": np.eye(4).tolist(),
            "radiance": [1, 1, 1],
        }
    ]
    manifest["views"]["left"]["exposure"] = 1e20
    (render / "manifest.json").write_text(json.dumps(manifest))
    write_exr(render / "left/lights.exr", [f"radiance_0.{part}" for part in "RGB"], value=value)
    relight(render / "left", tmp_path / "relit", Relighting({"lamp": 7.0}))
    found = exr.read_picture(tmp_path / "relit/radiance.exr")
    with np.errstate(over="ignore"):
        np.testing.assert_array_equal(found, np.full((6, 8, 3), np.float32(7.0 * value)))
