"""A whole dataset: which files appear where, what stays, what goes, and what is refused."""

import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.errors import InputError, OrusdError, OutputError
from openrooms_usd.rendering.reading import RenderedScene, RenderedView, read_render
from orusd_openrooms.readers import read_cameras, read_view_names
from tests.commands import output_of
from tests.openrooms.synthetic import make_render, write_exr
from tests.openrooms.synthetic import write_dataset as write

IMAGE = "Image/main_xml/scene0000_00/im_1.hdr"
VARIANTS = ("main_xml", "mainDiffMat_xml", "mainDiffLight_xml")
# By folder: which variants are released with it, and the stems and suffixes of its files.
RELEASED = {
    "Image": ("main mainDiffMat mainDiffLight", "im.hdr"),
    "Material": (
        "main mainDiffMat",
        "imbaseColor.png imroughness.png immetallic.png imcadmatobj.dat",
    ),
    "Geometry": ("main mainDiffMat", "imnormal.png"),
    "Mask": ("main mainDiffLight", "immask.png"),
    "Friction": ("main mainDiffMat", "imfriction.dat"),
    "SemanticLabel": ("main", "imsemLabel.npy"),
    "SVLighting": ("main mainDiffMat mainDiffLight", "imenv.hdr"),
    "SVSG": ("main mainDiffMat mainDiffLight", "imsgEnv.h5"),
    "Shading": ("main mainDiffMat mainDiffLight", "imshading.hdr"),
    "SVLightingDirect": ("main mainDiffLight", "imenvDirect.hdr"),
    "ShadingDirect": ("main mainDiffLight", "imshadingDirect.rgbe"),
}
PER_LIGHT = tuple(
    (
        "box.dat mask.png imShadow.png imDS.rgbe imDSNoOcclu.rgbe light.dat lightSrc.dat"
        " lightSrcNoOcclu.dat depthShadow.npy"
    ).split()
)


def files(root: Path) -> set[str]:
    return {str(path.relative_to(root)) for path in root.rglob("*") if path.is_file()}


def numbered(file: str, number: int) -> str:
    stem, _, suffix = file.partition(".")
    return f"{stem}_{number}.{suffix}"


@pytest.fixture(scope="module")
def split(render: RenderedScene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("split") / "data"
    write([render] * 3, root, splits=VARIANTS)
    return root


def test_the_tree_of_the_release(split: Path) -> None:
    expected = {
        f"{folder}/{variant}_xml/scene0000_00/{numbered(file, number)}"
        for folder, (variants, stems) in RELEASED.items()
        for variant in variants.split()
        for file in stems.split()
        for number in (1, 2)
    }
    expected |= {f"Geometry/main_xml/scene0000_00/imdepth_{k}.dat" for k in (1, 2)}
    found = files(split)
    lights = {file for file in found if file.startswith("LightSource")}
    assert found - lights - expected == {
        ".orusd.scene0000_00.sha256",
        "train.txt",
        "val.txt",
        "test.txt",
        "scenes/intrinsic.txt",
        *(
            f"scenes/xml/scene0000_00/{name}"
            for name in (
                "cam.txt",
                "transform.dat",
                "views.json",
                "transform.json",
                "intrinsic.txt",
            )
        ),
    }
    assert expected <= found


def test_the_lights_of_the_release(split: Path) -> None:
    main = split / "LightSource/main_xml/scene0000_00/light_2"
    names = {path.name for path in main.iterdir() if path.suffix != ".json"}
    expected = {file.replace(".", f"{light}.", 1) for file in PER_LIGHT for light in (0, 1)}
    assert names == expected | {"imDSNoOccluApprox1.hdr", "visibility.dat"}
    other = split / "LightSource/mainDiffLight_xml/scene0000_00/light_2"
    shared = {path.name for path in other.iterdir()}
    assert not {"box0.dat", "mask0.png", "imShadow0.png"} & shared
    assert {"imDS0.rgbe", "imDSNoOcclu1.rgbe", "lightSrc1.dat"} <= shared
    assert not (split / "LightSource/mainDiffMat_xml").exists()


def test_everything_in_one_folder(render: RenderedScene, tmp_path: Path) -> None:
    write([render] * 3, tmp_path, splits=VARIANTS, layout="merged")
    for variant in VARIANTS:
        found = files(tmp_path / variant / "scene0000_00")
        for _, stems in RELEASED.values():
            assert {numbered(file, 1) for file in stems.split()} <= found
        assert {"light_1/box0.dat", "light_2/mask1.png"} <= found


def test_a_second_write_gives_the_same_bytes(render: RenderedScene, tmp_path: Path) -> None:
    for name in ("a", "b"):
        write([render], tmp_path / name)
    assert files(tmp_path / "a") == files(tmp_path / "b")
    for file in files(tmp_path / "a"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes(), file


@pytest.mark.slow
def test_frames_count_from_where_one_says(render: RenderedScene, tmp_path: Path) -> None:
    write([render], tmp_path, first=1)
    assert write([render], tmp_path, first=3).frames == {"main_xml": [3, 4]}
    assert len(list((tmp_path / "Image/main_xml/scene0000_00").iterdir())) == 4
    cameras = read_cameras(tmp_path / "scenes/xml/scene0000_00/cam.txt")
    assert len(cameras) == 4
    np.testing.assert_array_equal(cameras[0], cameras[2])
    names = read_view_names(tmp_path / "scenes/xml/scene0000_00/views.json")
    assert names == ["view_0", "view_1"] * 2
    write([render], tmp_path, first=1)
    assert len(read_cameras(tmp_path / "scenes/xml/scene0000_00/cam.txt")) == 4
    with pytest.raises(InputError, match="--first 5"):
        write([render], tmp_path, first=9)


def test_zero_is_the_first_of_sets_rendered_again(render: RenderedScene, tmp_path: Path) -> None:
    assert write([render], tmp_path, first=0).frames == {"main_xml": [0, 1]}
    assert len(read_cameras(tmp_path / "scenes/xml/scene0000_00/cam.txt")) == 2


@pytest.mark.slow
def test_scenes_gather_in_the_lists(render: RenderedScene, tmp_path: Path) -> None:
    write([render], tmp_path, scene="scene0001_00")
    write([render], tmp_path, scene="scene0000_00")
    write([render], tmp_path, scene="scene0002_00", subset="test")
    assert (tmp_path / "train.txt").read_text() == "scene0000_00\nscene0001_00\n"
    assert (tmp_path / "test.txt").read_text() == "scene0002_00\n"
    write([render], tmp_path, scene="scene0001_00", subset="test")
    assert (tmp_path / "train.txt").read_text() == "scene0000_00\n"
    write([render], tmp_path, scene="scene0001_00", subset="val")
    assert (tmp_path / "test.txt").read_text() == "scene0002_00\n"
    assert (tmp_path / "val.txt").read_text() == "scene0001_00\n"


def test_lights_that_are_gone_leave_no_files(
    render: RenderedScene, day: Path, tmp_path: Path
) -> None:
    write([render], tmp_path / "data")
    manifest = json.loads((day / "manifest.json").read_text())
    manifest["lights"] = [light for light in manifest["lights"] if light["number"] != 1]
    (day / "manifest.json").write_text(json.dumps(manifest))
    write([read_render(day)], tmp_path / "data")
    masks = (tmp_path / "data/LightSource/main_xml/scene0000_00/light_1").glob("mask*")
    assert [path.name for path in masks] == ["mask0.png"]


def test_a_render_without_light_channels_gives_what_it_can(
    render: RenderedScene, tmp_path: Path
) -> None:
    shutil.copytree(render.folder, tmp_path / "plain")
    for name in ("lights.exr", "environment.exr", "environment_direct.exr", "environment_sg.npy"):
        for path in (tmp_path / "plain").rglob(name):
            path.unlink()
    summary = write([read_render(tmp_path / "plain")], tmp_path / "data")
    assert set(summary.missing) == set(
        (
            "imenv imsgEnv imenvDirect box mask imShadow imDS imDSNoOcclu depthShadow visibility"
        ).split()
    )
    assert summary.missing["imenv"] == "the render has no environment"
    # From the irradiance, at a quarter of the resolution.
    assert (tmp_path / "data/Shading/main_xml/scene0000_00/imshading_2.hdr").is_file()


def test_channels_of_pixels_are_none_of_lights(
    render: RenderedScene, day: Path, tmp_path: Path
) -> None:
    """``direct`` is radiance; ``direct_0`` is what the first light brings."""
    for view in render.views.values():
        path = day / view.name
        (path / "lights.exr").unlink()
        write_exr(path / "channels.exr", {**view.pixels, "direct": view.pixels["radiance"]})
    summary = write([read_render(day)], tmp_path / "data")
    assert summary.missing["imDS"] == "the render has no direct_i"


def test_a_light_without_its_channel_is_named(
    render: RenderedScene, day: Path, tmp_path: Path
) -> None:
    lights = render.views["view_1"].lights
    layers = {
        f"{n}_{i}": p for n, of in lights.items() for i, p in of.items() if (n, i) != ("mask", 1)
    }
    write_exr(day / "view_1/lights.exr", layers)
    with pytest.raises(InputError, match="light 1 has no channel mask_1"):
        write([read_render(day)], tmp_path / "data")


def test_without_h5py_all_but_the_fits_is_written(
    render: RenderedScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "h5py", None)
    summary = write([render], tmp_path)
    assert "openrooms-usd[openrooms]" in summary.missing["imsgEnv"]
    assert (tmp_path / IMAGE).is_file() and not (tmp_path / "SVSG").exists()


@pytest.mark.parametrize("how", ["unlisted", "changed", "behind a link"])
def test_files_that_no_earlier_run_wrote_are_not_replaced(
    how: str, render: RenderedScene, tmp_path: Path
) -> None:
    """Such as those of the released dataset, whose first scene has the name that is ours too."""
    root = tmp_path / "root"
    write([render], root)
    picture = root / IMAGE
    if how == "unlisted":
        (root / ".orusd.scene0000_00.sha256").unlink()
    elif how == "changed":
        picture.write_bytes(b"mine")
    else:
        picture.parent.rename(tmp_path / "elsewhere")
        picture.parent.symlink_to(tmp_path / "elsewhere")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(OutputError, match="not as an earlier run wrote it"):
        write([make_render(tmp_path / "other", seed=7)], root)
    shutil.rmtree(tmp_path / "other")
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_nothing_appears_when_something_fails(
    render: RenderedScene, day: Path, tmp_path: Path
) -> None:
    (day / "view_1/lights.exr").write_bytes(b"damaged")
    with pytest.raises(OrusdError):
        write([read_render(day)], tmp_path / "data")
    assert not (tmp_path / "data").exists()


def test_variants_share_their_views(render: RenderedScene, tmp_path: Path) -> None:
    other = make_render(tmp_path / "other", views=1)
    with pytest.raises(InputError, match="its views differ from those"):
        write([render, other], tmp_path / "data", splits=VARIANTS[:2])
    # The views of xml1 are others.
    write([render, other], tmp_path / "data", splits=("main_xml", "main_xml1"))
    assert (tmp_path / "data/scenes/xml1/scene0000_00/cam.txt").is_file()


@pytest.mark.parametrize("key", ["K", "world_from_camera", "resolution"])
def test_variants_share_their_cameras(key: str, render: RenderedScene, tmp_path: Path) -> None:
    entries = {name: view.entry for name, view in render.views.items()}
    changed = np.array(getattr(entries["view_1"], key))
    changed.flat[0] += 1
    entries["view_1"] = entries["view_1"].model_copy(update={key: changed.tolist()})
    views = {name: RenderedView(name, render.folder / name, entries[name]) for name in entries}
    other = RenderedScene(render.folder, render.manifest, views)
    with pytest.raises(InputError, match="its views differ from those"):
        write([render, other], tmp_path / "data", splits=VARIANTS[:2])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"scene": "../scene0"}, "not the name of a scene"),
        ({"scene": "room"}, "not the name of a scene"),
        ({"splits": ("main",)}, "no split is named 'main'"),
        ({"splits": ("main_xml", "main_xml1")}, "1 renders and 2 splits"),
        ({"first": -1}, "cannot be number -1"),
    ],
)
def test_options_that_make_no_sense(
    options: dict[str, object], message: str, render: RenderedScene, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=message):
        write([render], tmp_path / "data", **options)
    assert not (tmp_path / "data").exists()


def test_a_damaged_light_is_named(render: RenderedScene, day: Path, tmp_path: Path) -> None:
    manifest = json.loads((day / "manifest.json").read_text())
    del manifest["lights"][1]["size"]
    (day / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(InputError, match=r"manifest.json: lights\[1\].size: it is missing"):
        write([read_render(day)], tmp_path / "data")


def test_the_command(render: RenderedScene, tmp_path: Path) -> None:
    out = tmp_path / "mask_data"
    words = ("dataset", "write", render.folder, "-o", out, "--dataset-layout", "merged")
    said = output_of(*words)
    assert "of 2 views" in said
    assert "note: the released loaders expect pictures of 640x480" in said
    assert "holds 'mask', which the released loaders replace" in said
    said = output_of(*words, "--json", "--scene", "scene0001_00")
    assert json.loads(said)["frames"] == {"main_xml": [1, 2]}


def test_a_folder_that_is_no_render(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not a finished render"):
        read_render(tmp_path)


def test_scenes_of_others_stay_in_the_lists_whatever_their_names(
    render: RenderedScene, tmp_path: Path
) -> None:
    (tmp_path / "train.txt").write_bytes(b"r\xe9sidence\n")
    write([render], tmp_path)
    assert (tmp_path / "train.txt").read_bytes() == b"r\xe9sidence\nscene0000_00\n"
    (tmp_path / "test.txt").write_text("To do: buy milk\n")
    with pytest.raises(OutputError, match="not a list of scenes"):
        write([render], tmp_path)
    assert (tmp_path / "test.txt").read_text() == "To do: buy milk\n"


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 3e38, -3e38])
def test_pixels_may_be_any_number(
    render: RenderedScene, day: Path, tmp_path: Path, value: float
) -> None:
    """All but labels: a renderer may find no number, and its manifest says where."""
    view = render.views["view_1"]
    kept = ("instance", "material", "semantic", "emission_mask")
    layers = {name: pixels.copy() for name, pixels in view.pixels.items()}
    for name in layers.keys() - {*kept}:
        layers[name][10:20, 30:40] = value
    write_exr(day / "view_1/channels.exr", layers)
    lights = {
        f"{name}_{n}": np.full_like(p, value)
        for name, of in view.lights.items()
        for n, p in of.items()
    }
    write_exr(day / "view_1/lights.exr", lights)
    write([read_render(day)], tmp_path / "data")
    layers["semantic"][3, 3] = value
    write_exr(day / "view_1/channels.exr", layers)
    with pytest.raises(InputError, match="'semantic' holds values that are not whole numbers"):
        write([read_render(day)], tmp_path / "data")
