"""Pictures that claim what they do not hold, and headers that are no text, are refused by name."""

import struct
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
from pxr import Sdf, Usd, UsdShade, UsdUtils

from openrooms_usd import untrusted
from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.errors import InputError
from openrooms_usd.imagefile import write_png
from openrooms_usd.rendering.scene.pictures import evaluate, load
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.rendering.scene.unseen import is_alarming
from openrooms_usd.usd.shading import textures
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import Texture, define_preview_surface
from openrooms_usd.usd.shading.surfaces import PreviewSurface
from openrooms_usd.usd.shading.textures import picture_facts, read_codes, read_texture
from orusd_scans.formats.depthpicture import picture_size
from tests import small


def png(path: Path, width: int, height: int) -> Path:
    """A header of this size, with sums that agree, over the pixels of one row."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    data = zlib.compress(bytes(1 + 3 * 16))
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")
    )
    return path


@pytest.mark.parametrize("size", [(12_000, 12_000), (1 << 20, 60), (60_000, 60_000)])
def test_pixels_that_the_bytes_cannot_hold_take_no_memory(
    tmp_path: Path, size: tuple[int, int]
) -> None:
    path = png(tmp_path / "a.png", *size)
    with pytest.raises(InputError, match=r"are not supported|not a readable picture"):
        read_texture(str(path))
    assert read_codes(str(path)) is None


@pytest.mark.slow
def test_a_large_picture_of_one_colour_is_read(tmp_path: Path) -> None:
    import OpenImageIO

    path = tmp_path / "a.png"
    image = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(4096, 4096, 3, "uint8"))
    image.write(str(path))
    assert path.stat().st_size * 500 < 4096 * 4096 * 3
    assert read_texture(str(path)).shape == (4096, 4096, 3)


@pytest.mark.parametrize("ending", ["exr", "hdr", "png", "tif"])
def test_no_byte_of_a_header_gives_more_than_a_refusal(tmp_path: Path, ending: str) -> None:
    import OpenImageIO

    sound = tmp_path / f"sound.{ending}"
    image = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(8, 4, 3, "float"))
    image.write(str(sound))
    data = sound.read_bytes()
    path = tmp_path / f"spoilt.{ending}"
    rng = np.random.default_rng(3)
    for _ in range(300):
        spoilt = bytearray(data)
        for at in rng.integers(0, min(len(data), 400), 3):
            spoilt[at] = rng.integers(128, 256)
        path.write_bytes(bytes(spoilt))
        for read in (picture_facts, read_texture, lambda file: picture_size(Path(file))):
            try:
                read(str(path))
            except InputError as error:
                assert str(path) in str(error)


# Columns and rows of tiles, with what they hold; (1, 1) is missing.
TILES = {(0, 0): (10, 20, 30), (1, 0): (250, 100, 0), (0, 1): (0, 200, 90), (2, 1): (70, 70, 70)}


def write(folder: Path, kind: str = "uint8", ending: str = "png") -> None:
    for (column, row), color in TILES.items():
        side = 4 if column else 8
        path = str(folder / f"skin.{1001 + column + 10 * row}.{ending}")
        file = OpenImageIO.ImageOutput.create(path)
        assert file.open(path, OpenImageIO.ImageSpec(side, side, 3, kind))
        pixels = np.full((side, side, 3), np.array(color) / 255.0, np.float32)
        assert file.write_image(pixels) and file.close()


def authored(folder: Path, given: Texture) -> Usd.Stage:
    stage = Usd.Stage.CreateNew(str(folder / "a.usda"))
    made = define_preview_surface(stage, "/M", PreviewSurface(base_color=given))
    stage.SetDefaultPrim(made.GetPrim())
    stage.Save()
    return stage


def read(stage: Usd.Stage) -> tuple[PreviewSurface, tuple[str, ...]]:
    return read_preview_surface(UsdShade.Material(stage.GetPrimAtPath("/M")))


def seen(texture: Texture, st: list[tuple[float, float]]) -> np.ndarray:
    picture = load(texture, 3, (0.0, 1.0), texture.uv_matrix)
    return picture.lookup(np.array(st))


@pytest.mark.parametrize("kind", ["uint8", "uint16", "half"])
def test_each_tile_is_where_its_number_says(tmp_path: Path, kind: str) -> None:
    ending = "exr" if kind == "half" else "png"
    write(tmp_path, kind, ending)
    stage = authored(tmp_path, Texture(f"./skin.<UDIM>.{ending}", color_space="sRGB"))
    found, losses = read(stage)
    texture = found.base_color
    assert losses == () and isinstance(texture, Texture)
    assert textures.grid(texture.file) == (3, 2)
    middles = [(column + 0.5, row + 0.5) for column, row in (*TILES, (1, 1))]
    expected = [linear_from_srgb(np.array(color) / 255.0) for color in TILES.values()]
    assert seen(texture, middles) == pytest.approx(np.array([*expected, [0.0] * 3]), abs=1e-3)
    # Corners too, but for a texel at the seams.
    assert seen(texture, [(0.06, 0.06), (0.94, 0.06)])[0] == pytest.approx(expected[0], abs=1e-3)


def test_transforms_come_before_the_tiles(tmp_path: Path) -> None:
    write(tmp_path)
    stage = authored(tmp_path, Texture("./skin.<UDIM>.png", uv_translation=(1.0, 0.0)))
    texture = read(stage)[0].base_color
    assert isinstance(texture, Texture)
    expected = np.array(TILES[1, 0]) / 255.0
    assert seen(texture, [(0.5, 0.5)])[0] == pytest.approx(expected, abs=1e-3)


def test_tiles_inside_packages_and_the_automatic_color_space(tmp_path: Path) -> None:
    write(tmp_path)
    stage = authored(tmp_path, Texture("./skin.<UDIM>.png"))
    node = UsdShade.Shader(stage.GetPrimAtPath("/M/base_color_texture"))
    node.GetInput("sourceColorSpace").Set("auto")
    stage.Save()
    package = str(tmp_path / "a.usdz")
    assert UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(tmp_path / "a.usda")), package)
    for tile in tmp_path.glob("*.png"):
        tile.unlink()
    found, losses = read(Usd.Stage.Open(package))
    texture = found.base_color
    assert losses == () and isinstance(texture, Texture) and texture.color_space == "sRGB"
    assert read_texture(texture.file).shape == (16, 24, 3)


def test_tiles_that_are_not_there(tmp_path: Path) -> None:
    stage = authored(tmp_path, Texture("./none.<UDIM>.png", fallback=(0.5, 0.25, 0.125, 1.0)))
    found, losses = read(stage)
    assert found.base_color == (0.5, 0.25, 0.125) and "none.<UDIM>.png is missing" in losses[0]


# Files that are no pictures.


def spoilt(path: Path, how: str) -> Path:
    """What stands in place of a picture."""
    write_png(path, np.random.default_rng(1).integers(0, 255, (64, 64, 3), dtype=np.uint8))
    data = {
        "empty": b"",
        "pointer": b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n",
        "page": b"\n<!DOCTYPE html><html></html>",
        "noise": b"nothing",
        "cut": path.read_bytes()[:4000],
    }
    path.unlink()
    if how == "folder":
        path.mkdir()
    elif how != "missing":
        path.write_bytes(data[how])
    return path


HOW = {
    "missing": "is missing",
    "empty": "the file is empty",
    "pointer": "git lfs pull",
    "page": "a web page",
    "noise": "not a readable picture",
    "cut": "unreadable picture",
    "folder": "a folder",
}


@pytest.mark.parametrize("how", HOW)
def test_what_cannot_be_read_is_as_if_it_was_missing(tmp_path: Path, how: str) -> None:
    texture = Texture(str(spoilt(tmp_path / "skin.png", how)))
    made = small.Stage()
    inputs = {"base_color": texture, "roughness": texture, "opacity": replace(texture, channel="r")}
    made.quad("/Q", small.square((0, 0, 0), 1.0, "+Z"), material=made.material("/M", **inputs))
    scene = translate(made.stage)
    surface, st = scene.patches[0].surface, np.array([[0.5, 0.5]])
    assert evaluate(surface.base_color, st, 3) == pytest.approx(np.full((1, 3), 0.18), abs=1e-3)
    assert evaluate(surface.roughness, st, 1) == pytest.approx(0.5, abs=1e-3)
    assert evaluate(surface.opacity, st, 1) == 1.0
    told = [why for prim, _, why in scene.report.losses() if prim == "/M"]
    assert HOW[how] in told[0] and any(map(is_alarming, told[0].split("; ")))
    # Once for each node, or for all of them.
    assert told[0].count(HOW[how]) == (1 if how == "cut" else 3)


def test_a_fallback_that_is_authored_counts(tmp_path: Path) -> None:
    for how in ("missing", "cut"):
        file = str(spoilt(tmp_path / f"{how}.png", how))
        made = small.Stage()
        texture = Texture(file, fallback=(0.5, 0.25, 0.125, 1.0))
        material = made.material("/M", base_color=texture)
        made.quad("/Q", small.square((0, 0, 0), 1.0, "+Z"), material=material)
        surface = translate(made.stage).patches[0].surface
        found = evaluate(surface.base_color, np.array([[0.5, 0.5]]), 3)
        assert found[0] == pytest.approx((0.5, 0.25, 0.125), abs=1e-3)


def test_pointers_of_git_lfs_are_named_at_the_door(tmp_path: Path) -> None:
    file = spoilt(tmp_path / "any.png", "pointer")
    with pytest.raises(InputError) as error:
        untrusted.read_bytes(file, "usd")
    assert "Git LFS" in error.value.message and "git lfs pull" in str(error.value.remedy)


# Paths of other systems.

STRAYED = {
    ".\\textures\\Wood Oak.png": "textures/Wood Oak.png",
    "textures/Wood%20Oak.png": "textures/Wood Oak.png",
    "Textures/wood oak.PNG": "textures/Wood Oak.png",
    "C:\\shot\\textures\\Wood Oak.png": "textures/Wood Oak.png",
    "file:///shot/beside.png": "beside.png",
    "/shot/Beside.PNG": "beside.png",
    "textures/none.png": "",
    "..\\outside.png": "",
    "textures\\..\\..\\outside.png": "",
}


@pytest.mark.parametrize("said", STRAYED)
def test_paths_of_other_systems_are_found_beside_their_layer(tmp_path: Path, said: str) -> None:
    home = tmp_path / "scene"
    (home / "textures").mkdir(parents=True)
    for file in ("scene/textures/Wood Oak.png", "scene/beside.png", "outside.png"):
        write_png(tmp_path / file, np.zeros((2, 2, 3), np.uint8))
    found, losses = read(authored(home, Texture(said)))
    assert f"{said} is missing" in losses[0] and len(losses) == 1
    if not STRAYED[said]:
        assert found.base_color == (0.18, 0.18, 0.18)
    else:
        assert isinstance(found.base_color, Texture)
        assert Path(found.base_color.file) == home / STRAYED[said]
        assert Path(STRAYED[said]).name in losses[0]


def test_a_folder_above_the_layer_counts_within_the_scene(tmp_path: Path) -> None:
    for folder in ("parts", "textures"):
        (tmp_path / folder).mkdir()
    write_png(tmp_path / "textures/a.png", np.zeros((2, 2, 3), np.uint8))
    authored(tmp_path / "parts", Texture("..\\textures\\a.png"))
    stage = Usd.Stage.CreateNew(str(tmp_path / "scene.usda"))
    stage.DefinePrim("/M").GetReferences().AddReference("./parts/a.usda")
    texture = read(stage)[0].base_color
    assert isinstance(texture, Texture)
    assert Path(texture.file) == tmp_path / "textures/a.png"
