"""One command gives a view with every channel and the files of the OpenRooms release."""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.channels import CHANNELS, FLOWS
from tests.commands import output_of

GRID = (8, 8)

pytestmark = pytest.mark.slow


def picture(path: Path) -> np.ndarray:
    """As the file has it, without our own reader."""
    return OpenImageIO.ImageBuf(str(path)).get_pixels()


@pytest.fixture(scope="module")
def home(vectorized: str, demo: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("light")
    call = [
        "render",
        str(demo),
        "-o",
        str(folder / "render"),
        *"--camera dining --resolution 32x32 --grid 8x8 --spp 32 --channels all".split(),
        *"--variant llvm --error-maps --dataset".split(),
        str(folder / "data"),
    ]
    output_of(*call)
    return folder


@pytest.fixture(scope="module")
def manifest(home: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((home / "render/manifest.json").read_text())
    return found


@pytest.fixture(scope="module")
def layers(home: Path) -> dict[str, np.ndarray]:
    """The images of all channels by name, of every light by number."""
    found = {}
    for file in ("channels", "lights"):
        buffer = OpenImageIO.ImageBuf(str(home / "render/dining" / f"{file}.exr"))
        pixels, names = buffer.get_pixels(), buffer.spec().channelnames
        for layer in dict.fromkeys(name.partition(".")[0] for name in names):
            at = [i for i, name in enumerate(names) if name.partition(".")[0] == layer]
            found[layer] = pixels[..., sorted(at, key=lambda i: "RGBXYZ".index(names[i][-1]))]
    return found


def test_every_channel_of_every_light_is_there(manifest: Any, layers: Any, home: Path) -> None:
    lights = range(len(manifest["lights"]))
    wanted = {
        name.removesuffix("_i") + f"_{light}" if row.scope == "light" else name
        for name, row in CHANNELS.items()
        if row.scope != "grid" and name not in ("denoised", *FLOWS)
        for light in lights
    }
    assert set(layers) == wanted
    listed = manifest["views"]["dining"]
    assert set(listed["channels"]) == wanted | {"environment", "environment_direct"}
    for name in ("environment", "environment_direct"):
        assert picture(home / "render" / listed["files"][name]).shape == (8 * 16, 8 * 32, 3)
    fits = listed["fits"]["files"]
    shading = picture(home / "render" / fits.pop("environment_shading"))
    assert shading.shape == (8, 8, 3)
    # The same light as irradiance, seen by pixels: their means over the grid's.
    whole = layers["irradiance"].reshape(8, 4, 8, 4, 3).mean(axis=(1, 3))
    assert shading.mean() == pytest.approx(whole.mean(), rel=0.2)
    sizes = {name: np.load(home / "render" / file).shape for name, file in fits.items()}
    assert sizes == {"environment_sg": (8, 8, 12, 6), "environment_sh": (8, 8, 9, 3)}


def test_the_parts_make_the_whole(manifest: Any, layers: Any) -> None:
    numbers = range(len(manifest["lights"]))
    radiance, received = layers["radiance"], layers["irradiance"]
    parts = layers["emission"] + layers["direct"] + layers["indirect"]
    np.testing.assert_allclose(parts, radiance, rtol=1e-5, atol=1e-3)
    lights = sum(layers[f"radiance_{n}"].astype(float) for n in numbers)
    np.testing.assert_allclose(lights, radiance, rtol=1e-4, atol=1e-2)
    lights = sum(layers[f"irradiance_{n}"].astype(float) for n in numbers)
    np.testing.assert_allclose(lights, received, rtol=1e-4, atol=1e-2)
    # Straight light has samples of its own: alike in the mean.
    straight = sum(layers[f"direct_{n}"].astype(float) for n in numbers)
    assert straight.mean() == pytest.approx(layers["irradiance_direct"].mean(), rel=0.1)


def test_errors_of_pixels_make_the_error_of_the_channel(home: Path, manifest: Any) -> None:
    listed = manifest["views"]["dining"]
    buffer = OpenImageIO.ImageBuf(str(home / "render" / listed["files"]["errors"]))
    pixels, names = buffer.get_pixels().astype(float), buffer.spec().channelnames
    for name in ("radiance", "irradiance_indirect", "diffuse", "specular", "radiance_0"):
        own = [names.index(f"{name}.{part}") for part in "RGB"]
        file = "lights" if name == "radiance_0" else "channels"
        image = OpenImageIO.ImageBuf(str(home / "render/dining" / f"{file}.exr"))
        at = [image.spec().channelnames.index(f"{name}.{part}") for part in "RGB"]
        mean = image.get_pixels()[..., at].astype(float)
        scale = mean**2 + 0.01 * mean.mean(axis=(0, 1)) ** 2
        made = np.mean(pixels[..., own] ** 2 / scale)
        # What is stated is by a scale that bright pixels do not raise, and rather too large.
        assert made < 1.5 * listed["channels"][name]["estimated_error"]
    tiles = picture(home / "render" / listed["files"]["environment_errors"])
    assert tiles.shape == (8 * 16, 8 * 32, 3)
    assert tiles.any()


def test_lights_say_where_they_are_and_masks_agree(manifest: Any, layers: Any, home: Path) -> None:
    kinds = [light["kind"] for light in manifest["lights"]]
    assert {"lamp", "opening"} <= set(kinds)
    assert kinds[-1] == "elsewhere"
    windows = [light for light in manifest["lights"] if light["kind"] == "opening"]
    assert all(window["gaussians"] and window["fit_error"] < 0.7 for window in windows)
    for window in windows:
        seen = picture(home / "render" / window["environment"])
        assert seen.shape == (128, 256, 3)
        outwards = np.array(window["world_from_box"])[:3, 2]
        # What falls in through the rectangle: the cosine's part of all pixels.
        theta, phi = (np.arange(128) + 0.5) / 128 * np.pi, (np.arange(256) + 0.5) / 128 * np.pi
        way = np.array(
            [
                np.outer(np.sin(theta), np.sin(phi)),
                np.outer(np.sin(theta), np.cos(phi)),
                np.outer(np.cos(theta), np.ones(256)),
            ]
        )
        weight = np.maximum(np.einsum("x,xrc->rc", outwards, way), 0) * np.sin(theta)[:, None]
        lux = np.einsum("rc,rck->k", weight, seen) * (np.pi / 128) ** 2
        np.testing.assert_allclose(lux / np.pi, window["radiance"], rtol=0.03)
    for light in manifest["views"]["dining"]["lights"]:
        rows, columns, _ = layers[f"mask_{light['number']}"].nonzero()
        seen = [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1] if len(rows) else []
        if "box2d" in light:
            assert light["box2d"] == seen


def test_the_files_of_the_release_hold_the_same(home: Path, layers: Any) -> None:
    scene = "main_xml/scene0000_00"
    with (home / "data/Geometry" / scene / "imdepth_1.dat").open("rb") as file:
        height, width = struct.unpack("<ii", file.read(8))
        depth = np.frombuffer(file.read(), "<f4").reshape(height, width)
    np.testing.assert_array_equal(depth, layers["depth"][..., 0])
    image = picture(home / "data/Image" / scene / "im_1.hdr")
    bound = layers["radiance"].max(axis=-1, keepdims=True) / 200
    assert (np.abs(image - layers["radiance"]) <= bound).all()
    stored = picture(home / "data/SVLighting" / scene / "imenv_1.hdr")
    ours = picture(home / "render/dining/environment.exr")
    # The release's readers take blue for red.
    bound = ours.max(axis=-1, keepdims=True) / 200
    assert (np.abs(stored[..., ::-1] - ours) <= bound).all()
    lights = home / "data/LightSource" / scene / "light_1"
    for number in range(len(list(lights.glob("box*.dat")))):
        mask = picture(lights / f"mask{number}.png")
        assert np.array_equal(mask[..., 0] > 0.5, layers[f"mask_{number}"][..., 0] > 0.5)
