"""What is found in photographs by the path tracer, of which everything is known."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from pxr import Usd, UsdLux

import openrooms_usd as ou
from openrooms_usd.appearance.driver import PhotographOptions, write_appearance
from openrooms_usd.colorimetry import luminance
from openrooms_usd.errors import InputError, OutputError
from openrooms_usd.imagefile import write_png
from openrooms_usd.usd.shading.materials import bound_material
from tests.appearance import photographed as taken
from tests.appearance.photographed import Photographed

Array = NDArray[np.float64]
Report = dict[str, Any]
COLORS = np.array(list(taken.COLORS.values()))


def found_in(stage: Path, frames: Path, layer: Path, **how: Any) -> Report:
    """What is found by poses as they are given."""
    return write_appearance(stage, frames, layer, PhotographOptions(register=False, **how))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Photographed:
    return taken.photographed(tmp_path_factory.mktemp("photographed"))


@pytest.fixture(scope="module")
def found(made: Photographed) -> Report:
    return found_in(made.stage, made.frames, made.stage.with_name("looks.usda"))


def colors(report: Report, key: str = "base_color") -> Array:
    named = {part["path"].rpartition("/")[2]: part for part in report["parts"]}
    return np.array([named[name][key] for name in taken.COLORS])


def scaled(found: Array, true: Array) -> Array:
    """Colours with the luminance that the true ones have in the median."""
    return found * np.median(luminance(true) / luminance(found))


def stops(found: list[float], true: tuple[float, ...]) -> Array:
    """Errors after one factor."""
    off = np.log2(np.array(found) / np.array(true))
    return off - np.median(off)


def test_base_colors_are_found(found: Report) -> None:
    error = np.abs(scaled(colors(found), COLORS) - COLORS)
    assert error.mean() <= 0.03
    assert (error <= 3.0 * colors(found, "base_color_sd") + 0.01).all()
    assert np.array([part["metallic"] for part in found["parts"]]).max() == 0.0
    roughness = np.array([part["roughness"] for part in found["parts"]])
    assert np.abs(roughness - taken.ROUGHNESS).max() <= 0.2


def test_lamps_are_found(found: Report) -> None:
    radiance = np.array([lamp["radiance"] for lamp in found["lamps"]])
    assert [lamp["path"] for lamp in found["lamps"]] == ["/World/Warm", "/World/Cool"]
    true = np.array(list(taken.LAMPS.values()))
    ratio, expected = (np.log2(np.divide(*luminance(one))) for one in (radiance, true))
    assert ratio == pytest.approx(expected, abs=0.15)
    # Their hues differ by as much as they do, whatever white is taken for.
    hues, known = ((one / luminance(one)[:, None]) for one in (radiance, true))
    assert hues[0] / hues[1] == pytest.approx(known[0] / known[1], rel=0.1)


def test_cameras_are_found(found: Report) -> None:
    exposure = [photograph["exposure"] for photograph in found["photographs"]]
    assert np.abs(stops(exposure, taken.EXPOSURES)).max() <= 0.1
    balance = np.array([photograph["white_balance"] for photograph in found["photographs"]])
    assert np.ptp(balance, axis=0).max() < 0.03
    assert abs(found["curve"]) < 0.1
    assert abs(found["vignetting"]) < 0.1
    assert max(photograph["residual"] for photograph in found["photographs"]) < 0.01


def test_the_product_is_right_whatever_its_scale(found: Report) -> None:
    """Exposure, lamps and white balance share factors that photographs do not tell."""
    exposure = np.array([photograph["exposure"] for photograph in found["photographs"]])
    balance = np.array([photograph["white_balance"] for photograph in found["photographs"]])
    lamps = np.array([lamp["radiance"] for lamp in found["lamps"]])
    seen = exposure[:, None, None] * balance[:, None] * lamps
    true = np.array(taken.EXPOSURES)[:, None, None] * taken.BALANCE
    true = true * np.array(list(taken.LAMPS.values()))
    gain = luminance(COLORS).mean() / luminance(colors(found)).mean()
    assert seen / gain == pytest.approx(true, rel=0.15)


def test_a_closed_room_gets_no_sky(made: Photographed, found: Report) -> None:
    assert {tuple(row["radiance"]) for row in found["surroundings"]} == {(0.0, 0.0, 0.0)}
    layer = made.stage.with_name("looks.usda")
    assert not (layer.with_suffix("") / "sky.exr").exists()
    stage = Usd.Stage.Open(str(layer))
    assert not any(prim.IsA(UsdLux.DomeLight) for prim in stage.TraverseAll())


@pytest.fixture(scope="module")
def looking(made: Photographed, found: Report) -> Path:
    """The stage with its looks."""
    top = made.stage.with_name("top.usda")
    layers = "subLayers = [@./looks.usda@, @./room.usda@]"
    top.write_text(f'#usda 1.0\n({layers}\nupAxis = "Z"\nmetersPerUnit = 1)\n')
    return top


def test_the_layer_says_what_the_report_says(looking: Path, found: Report) -> None:
    stage = Usd.Stage.Open(str(looking))
    for part in found["parts"]:
        material = bound_material(stage.GetPrimAtPath(part["path"]))
        shader = material.ComputeSurfaceSource("")[0]
        color = shader.GetInput("diffuseColor")
        assert color.HasConnectedSource() or color.Get() == pytest.approx(part["base_color"], 1e-3)
        roughness = shader.GetInput("roughness").Get()
        assert (0.5 if roughness is None else roughness) == pytest.approx(part["roughness"], 1e-3)
    for lamp in found["lamps"]:
        light = UsdLux.LightAPI(stage.GetPrimAtPath(lamp["path"]))
        nits = light.GetIntensityAttr().Get() * 2.0 ** light.GetExposureAttr().Get()
        shown = nits * np.array(light.GetColorAttr().Get())
        assert shown == pytest.approx(np.array(lamp["radiance"]), rel=1e-3)
    assert json.loads((looking.parent / "looks/report.json").read_text()) == found


@pytest.mark.slow
def test_the_room_looks_as_photographed(looking: Path, found: Report) -> None:
    """The found room, by the path tracer and a camera that took no photograph."""
    camera = ou.Camera(taken.K, taken.pose((1.8, 1.4, 1.6), (3.3, 0.6, 0.4)), taken.SIZE)
    seen = []
    for stage in (looking, taken.room(looking.with_name("true.usda"), true=True)):
        asked = {"channels": ["radiance"], "samples": 64, "method": "reference"}
        with ou.open_renderer(stage, **asked) as renderer:
            seen.append(np.asarray(renderer.render(camera)["radiance"], float))
    balance = np.array(found["photographs"][0]["white_balance"]) / taken.BALANCE
    gain = found["photographs"][0]["exposure"] / taken.EXPOSURES[0]
    mine, true = seen[0] * gain * balance, seen[1]
    blocks = [one.reshape(9, 8, 12, 8, 3).mean(axis=(1, 3)) for one in (mine, true)]
    assert np.median(np.abs(blocks[0] / blocks[1] - 1.0)) < 0.04


@pytest.mark.slow
def test_the_same_again_gives_the_same_bytes(made: Photographed, tmp_path: Path) -> None:
    files = ("looks.usda", "looks/report.json")
    for folder in (tmp_path / "a", tmp_path / "b"):
        found_in(made.stage, made.frames, folder / "looks.usda")
    first, again = ([(tmp_path / one / file).read_bytes() for file in files] for one in "ab")
    assert first == again


def copied(made: Photographed, folder: Path) -> Photographed:
    """The photographs in a folder of their own, where pictures may change."""
    for file in made.frames.parent.glob("*.png"):
        (folder / file.name).write_bytes(file.read_bytes())
    (folder / "frames.json").write_bytes(made.frames.read_bytes())
    return Photographed(made.stage, folder / "frames.json")


def flat(folder: Path, value: int, names: str = "012345") -> None:
    """Pictures of one colour in place of photographs."""
    for name in names:
        write_png(folder / f"{name}.png", np.full((*taken.SIZE[::-1], 3), value, np.uint8))


@pytest.mark.slow
def test_one_photograph_says_less(made: Photographed, found: Report, tmp_path: Path) -> None:
    copied(made, tmp_path)
    frames = taken.write_frames(tmp_path / "one.json", taken.POSES[:1])
    report = found_in(made.stage, frames, tmp_path / "looks.usda")
    every = {part["path"]: np.array(part["base_color_sd"]) for part in found["parts"]}
    shown = [part for part in report["parts"] if part["places"]]
    assert 0 < len(shown) < len(every)
    for part in shown:
        assert (np.array(part["base_color_sd"]) > 1.5 * every[part["path"]]).all()


@pytest.mark.slow
def test_a_photograph_that_shows_nothing_is_left_out(made: Photographed, tmp_path: Path) -> None:
    copied(made, tmp_path)
    flat(tmp_path, 255, "1")
    beyond = taken.POSES[0].copy()
    beyond[:3, 3] = 8.0, 8.0, 1.0
    poses = [beyond, *taken.POSES[1:]]
    frames = taken.write_frames(tmp_path / "frames.json", poses)
    report = found_in(made.stage, frames, tmp_path / "looks.usda")
    assert [photograph["id"] for photograph in report["photographs"]] == list("2345")
    left = [note.partition(" is left out")[0] for note in report["notes"]]
    assert left == ["photograph 0", "photograph 1"]
    assert np.abs(scaled(colors(report), COLORS) - COLORS).mean() <= 0.03


@pytest.mark.parametrize("value", [0, 255])
def test_pictures_without_anything_are_refused(
    made: Photographed, tmp_path: Path, value: int
) -> None:
    copied(made, tmp_path)
    flat(tmp_path, value)
    with pytest.raises(InputError, match="neither dark nor saturated"):
        found_in(made.stage, tmp_path / "frames.json", tmp_path / "looks.usda")
    assert not (tmp_path / "looks.usda").exists()


def test_cameras_elsewhere_are_refused(made: Photographed, tmp_path: Path) -> None:
    copied(made, tmp_path)
    poses = [one.copy() for one in taken.POSES]
    for one in poses:
        one[:3, 3] += 50.0
    frames = taken.write_frames(tmp_path / "frames.json", poses)
    with pytest.raises(InputError, match="show nothing of this stage") as refused:
        found_in(made.stage, frames, tmp_path / "looks.usda")
    assert "poses" in str(refused.value)


def test_a_room_without_lamps_is_refused(made: Photographed, tmp_path: Path) -> None:
    stage = Usd.Stage.Open(str(made.stage))
    for name in taken.LAMPS:
        stage.RemovePrim(f"/World/{name}")
    stage.Export(str(tmp_path / "dark.usda"))
    with pytest.raises(InputError, match="no lamp and no opening"):
        found_in(tmp_path / "dark.usda", made.frames, tmp_path / "looks.usda")


def no_pictures(made: Photographed, folder: Path) -> Path:
    return taken.write_frames(folder / "frames.json", taken.POSES)


def other_size(made: Photographed, folder: Path) -> Path:
    frames = copied(made, folder).frames
    write_png(folder / "2.png", np.full((10, 10, 3), 90, np.uint8))
    return frames


def no_picture_at_all(made: Photographed, folder: Path) -> Path:
    frames = copied(made, folder).frames
    (folder / "3.png").write_text("text")
    return frames


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (no_pictures, "none of the photographs' pictures is there"),
        (other_size, "10 x 10 pixels"),
        (no_picture_at_all, "not a colour picture"),
    ],
)
def test_bad_pictures_are_named(
    made: Photographed, tmp_path: Path, spoil: Callable[[Photographed, Path], Path], said: str
) -> None:
    frames = spoil(made, tmp_path)
    with pytest.raises(InputError, match=said):
        found_in(made.stage, frames, tmp_path / "looks.usda")


def test_only_a_layer_of_ours_is_written(made: Photographed, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"USD layer"):
        found_in(made.stage, made.frames, tmp_path / "looks.txt")
    (tmp_path / "looks.usda").write_text("#usda 1.0\n")
    with pytest.raises(OutputError):
        found_in(made.stage, made.frames, tmp_path / "looks.usda")
    assert (tmp_path / "looks.usda").read_text() == "#usda 1.0\n"
    with pytest.raises(OutputError):
        found_in(made.stage, made.frames, made.stage)


@pytest.mark.slow
def test_right_poses_are_kept(made: Photographed, found: Report, tmp_path: Path) -> None:
    report = write_appearance(made.stage, made.frames, tmp_path / "looks.usda")
    assert report["registration"]["verdict"] == "fits"
    assert np.abs(scaled(colors(report), COLORS) - COLORS).mean() <= 0.03
    exposure = [photograph["exposure"] for photograph in report["photographs"]]
    assert np.abs(stops(exposure, taken.EXPOSURES)).max() <= 0.1


@pytest.mark.slow
def test_held_out_photographs_are_not_looked_at(made: Photographed, tmp_path: Path) -> None:
    copied(made, tmp_path)
    flat(tmp_path, 128, "25")  # would spoil it
    report = found_in(made.stage, tmp_path / "frames.json", tmp_path / "looks.usda", hold_out=3)
    assert report["held_out"] == ["2", "5"]
    assert np.abs(scaled(colors(report), COLORS) - COLORS).mean() <= 0.03
