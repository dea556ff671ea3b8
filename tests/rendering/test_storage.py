"""Compact storage: the same channels of the same shapes, exact where that is promised."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.channels import definition
from openrooms_usd.description.rendering import COMPACT, COMPLETE, StorageName
from openrooms_usd.errors import InputError
from openrooms_usd.rendering.contract import Image, View
from openrooms_usd.rendering.manifest_schema import ViewEntry
from openrooms_usd.rendering.reading import RenderedView
from openrooms_usd.rendering.run import describe_view, write_view
from openrooms_usd.rendering.storage import storing

HEIGHT, WIDTH = 24, 40
K = np.array([[31.0, 0.0, 19.0], [0.0, 29.0, 12.5], [0.0, 0.0, 1.0]])
LIGHTS = 2


def turned(yaw: float, pitch: float, place: tuple[float, float, float]) -> np.ndarray:
    """A camera somewhere: two rotations, written out."""
    c, s, d, e = np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch)
    pose = np.eye(4)
    pose[:3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ [[1, 0, 0], [0, d, -e], [0, e, d]]
    pose[:3, 3] = place
    return pose


POSE = turned(0.7, 1.9, (3.0, -2.0, 1.5))


def seen() -> dict[str, np.ndarray]:
    """Channels that agree with each other; the geometry pixel by pixel, without our own rays."""
    rng = np.random.default_rng(3)
    light = rng.gamma(2.0, 40.0, (HEIGHT, WIDTH, 3))
    depth = rng.uniform(0.5, 6.0, (HEIGHT, WIDTH, 1))
    depth[:3] = 0.0
    normal = rng.standard_normal((HEIGHT, WIDTH, 3))
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    position, distance = np.zeros((HEIGHT, WIDTH, 3)), np.zeros((HEIGHT, WIDTH, 1))
    for row in range(HEIGHT):
        for column in range(WIDTH):
            ray = np.linalg.solve(K, [column + 0.5, row + 0.5, 1.0])
            point = ray * depth[row, column]
            distance[row, column] = np.sqrt((point**2).sum())
            if depth[row, column, 0] > 0.0:
                position[row, column] = (POSE @ [*point, 1.0])[:3]
    diffuse = 0.6 * light
    found = {
        "radiance": light,
        "diffuse": diffuse,
        "residual": light - diffuse,
        "depth": depth,
        "distance": distance,
        "position": position,
        "normal": normal,
        "normal_camera": normal @ POSE[:3, :3] * [1.0, -1.0, -1.0],
        "base_color": rng.random((HEIGHT, WIDTH, 3)).astype(np.float16),
        "instance": rng.integers(0, 2**24, (HEIGHT, WIDTH, 1)),
        "valid": depth > 0.0,
        "environment": rng.gamma(0.5, 90.0, (2 * 16, 3 * 32, 3)),
        "environment_direct": rng.gamma(0.5, 90.0, (2 * 16, 3 * 32, 3))
        * (rng.random((2 * 16, 3 * 32, 1)) < 0.05),
    }
    for light_number in range(LIGHTS):
        free, through = rng.gamma(2.0, 200.0, (2, HEIGHT, WIDTH, 3))
        direct = free * (rng.random((HEIGHT, WIDTH, 1)) < 0.7)
        found |= {
            f"direct_{light_number}": direct,
            f"unoccluded_{light_number}": free,
            f"irradiance_{light_number}": direct + through,
            f"irradiance_unoccluded_{light_number}": through + free,
            f"mask_{light_number}": rng.random((HEIGHT, WIDTH, 1)) < 0.2,
        }
    return {name: pixels.astype(np.float32) for name, pixels in found.items()}


def view_of(channels: dict[str, np.ndarray]) -> View:
    images = {name: Image(pixels, 4, 0.0, 0.1) for name, pixels in channels.items()}
    return View("/World/Cameras/a", WIDTH, HEIGHT, K, POSE, 1.0, images)


def written(folder: Path, view: View, storage: StorageName) -> RenderedView:
    (folder / "a").mkdir(parents=True)
    stored = storing(view, storage)
    previews = write_view(folder / "a", view, stored)
    entry = describe_view(folder / "a", "a", view, stored, previews)
    (folder / "entry.json").write_text(json.dumps(entry))
    return RenderedView("a", folder / "a", ViewEntry.model_validate_json(json.dumps(entry)))


@pytest.fixture(scope="module")
def truth() -> dict[str, np.ndarray]:
    return seen()


@pytest.fixture(scope="module")
def compact(truth: dict[str, np.ndarray], tmp_path_factory: pytest.TempPathFactory) -> RenderedView:
    return written(tmp_path_factory.mktemp("compact"), view_of(truth), COMPACT)


def read(view: RenderedView, name: str) -> np.ndarray:
    row = definition(name)
    if row.scope == "grid":
        grid = view.grid(name)
        assert grid is not None
        return grid.transpose(0, 2, 1, 3, 4).reshape(2 * 16, 3 * 32, 3)
    if row.scope == "light":
        base, _, number = name.rpartition("_")
        return view.lights[base][int(number)]
    return view.pixels[name]


def test_both_profiles_give_the_same_names_and_shapes(
    truth: dict[str, np.ndarray], compact: RenderedView, tmp_path: Path
) -> None:
    complete = written(tmp_path, view_of(truth), COMPLETE)
    assert {*complete.pixels} == {*compact.pixels}
    assert {n: {*found} for n, found in complete.lights.items()} == {
        n: {*found} for n, found in compact.lights.items()
    }
    for name in truth:
        one, other = read(complete, name), read(compact, name)
        assert (one.shape, one.dtype) == (other.shape, other.dtype)
        stored = truth[name].astype(np.float16) if definition(name).storage == "half" else one
        np.testing.assert_array_equal(one, stored)
    fits = [view.fit("environment_sh") for view in (complete, compact)]
    assert fits[0] is not None and fits[1] is not None and fits[0].shape == fits[1].shape


EXACT = ("depth", "base_color", "instance", "valid", "mask_0", "mask_1")
# The share of a number by which it may be off: of those that are sums, of all that is summed.
BOUND = {
    "radiance": 2**-7,
    "diffuse": 2**-7,
    "direct_0": 2**-6,
    "unoccluded_1": 2**-6,
    "irradiance_0": 2**-6,
    "environment": 2**-3,
    "environment_direct": 2**-3,
}


def test_what_is_no_light_is_exact(truth: dict[str, np.ndarray], compact: RenderedView) -> None:
    for name in EXACT:
        np.testing.assert_array_equal(read(compact, name), truth[name])
    normal = truth["normal"].astype(np.float16).astype(np.float32)
    np.testing.assert_array_equal(read(compact, "normal"), normal)
    # As many digits as floats of such lengths have, and as many as halves have.
    np.testing.assert_allclose(read(compact, "position"), truth["position"], rtol=0, atol=2e-6)
    np.testing.assert_allclose(read(compact, "distance"), truth["distance"], rtol=1e-6)
    np.testing.assert_allclose(
        read(compact, "normal_camera"), truth["normal_camera"], rtol=0, atol=2e-3
    )


@pytest.mark.parametrize("name", BOUND)
def test_light_is_within_its_bound(
    truth: dict[str, np.ndarray], compact: RenderedView, name: str
) -> None:
    found, t = read(compact, name).astype(np.float64), truth[name].astype(np.float64)
    assert (np.abs(found - t) <= BOUND[name] * t).all()
    assert (found[t == 0.0] == 0.0).all()
    # Rounded up as often as down.
    assert found.sum() == pytest.approx(t.sum(), rel=0.1 * BOUND[name])


def test_no_light_is_negative(tmp_path: Path) -> None:
    """Nor where the sun stands beside the dark, or where differences nearly cancel."""
    rng = np.random.default_rng(5)
    light = rng.choice([0.0, 1e-7, 1.0, 3e4], (HEIGHT, WIDTH, 3)) * rng.gamma(1.0, 1.0, (1, 1, 3))
    direct, tiles = 0.999 * light, np.tile(light, (2, 3, 1))[: 2 * 16, : 3 * 32]
    truth = {
        "radiance": light,
        "diffuse": 0.9999 * light,
        "residual": 0.0001 * light,
        "direct_0": direct,
        "irradiance_0": direct,
        "unoccluded_0": 0.001 * light,
        "irradiance_unoccluded_0": 0.001 * light,
        "environment": tiles,
    }
    view = view_of({name: pixels.astype(np.float32) for name, pixels in truth.items()})
    found = written(tmp_path, view, COMPACT)
    for name in truth:
        assert read(found, name).min() >= 0.0, name
    for file in {way.file for way in storing(view, COMPACT).channels.values() if way.file}:
        assert OpenImageIO.ImageBuf(str(tmp_path / "a" / file)).get_pixels().min() >= 0.0, file


def test_sums_of_lights_hold_to_the_bounds_of_the_manifest(tmp_path: Path) -> None:
    rng = np.random.default_rng(6)
    each = rng.gamma(0.3, 50.0, (5, HEIGHT, WIDTH, 3)) * [
        [[[1e-3]]],
        [[[1]]],
        [[[9]]],
        [[[1]]],
        [[[0]]],
    ]
    names = {f"radiance_{number}": pixels for number, pixels in enumerate(each)}
    channels = {**names, "radiance": each.sum(axis=0)}
    view = view_of({name: pixels.astype(np.float32) for name, pixels in channels.items()})
    found = written(tmp_path, view, COMPACT)
    rows = {name: found.entry.channels[name].stored for name in channels}
    bounds = {name: row.bound for name, row in rows.items() if row}
    assert bounds.keys() == channels.keys()
    total = sum(read(found, name).astype(np.float64) for name in names)
    off = np.abs(total - found.pixels["radiance"])
    # What is smaller than the least that halves hold with all digits is off by its share of that.
    least = sum(bounds[name] * 2**-13 / row.scale for name, row in rows.items() if row)
    most = max(bounds[name] for name in names) + bounds["radiance"]
    assert (off <= most * channels["radiance"] + least).all()
    assert off.max() > 0.0


def test_the_manifest_says_how_each_channel_is_stored(compact: RenderedView) -> None:
    entry = json.loads((compact.folder.parent / "entry.json").read_text())
    stored = {name: row["stored"] for name, row in entry["channels"].items()}
    assert stored["position"] == {"sources": ["depth"]}
    assert stored["irradiance_unoccluded_1"]["sources"] == [
        "irradiance_1",
        "unoccluded_1",
        "direct_1",
    ]
    assert stored["depth"] == {
        "file": "a/channels.exr",
        "sample": "float",
        "scale": 1.0,
        "bound": 0.0,
    }
    assert stored["radiance"]["bound"] == BOUND["radiance"]
    assert {*entry["files"].values()} == {
        f"a/{name}.exr"
        for name in ("channels", "light", "lights", "masks", "environment", "environment_direct")
    }
    # Anybody's reader gets nits by the scale.
    source = OpenImageIO.ImageInput.open(str(compact.folder / "light.exr"))
    names = list(source.spec().channelnames)
    pixels = source.read_image(OpenImageIO.FLOAT)[..., names.index("radiance.G")]
    source.close()
    np.testing.assert_array_equal(
        pixels / stored["radiance"]["scale"], compact.pixels["radiance"][..., 1]
    )


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_the_bound_is_the_same_in_any_unit(
    truth: dict[str, np.ndarray], factor: float, tmp_path: Path
) -> None:
    """Halves end at 65,504, and a sun in a cell is a thousand times as bright."""
    light = truth["radiance"] * np.float32(factor)
    found = written(tmp_path, view_of({"radiance": light}), COMPACT).pixels["radiance"]
    assert (np.abs(found - light) <= BOUND["radiance"] * light).all()


def test_what_is_no_number_harms_no_other_pixel(tmp_path: Path) -> None:
    light = np.full((HEIGHT, WIDTH, 3), 50.0, np.float32)
    light[0, 0], light[0, 1] = np.nan, np.inf
    found = written(tmp_path, view_of({"radiance": light}), COMPACT)
    assert np.isfinite(found.pixels["radiance"]).all()
    assert found.entry.channels["radiance"].nonfinite_pixels == 2
    np.testing.assert_array_equal(found.pixels["radiance"][1:], 50.0)


def test_what_does_not_follow_is_stored(truth: dict[str, np.ndarray], tmp_path: Path) -> None:
    """Such as the positions of a camera that is no pinhole."""
    bent = truth["position"] + np.float32(0.001)
    channels = {"depth": truth["depth"], "position": bent, "distance": truth["distance"]}
    found = written(tmp_path, view_of(channels), COMPACT)
    np.testing.assert_array_equal(found.pixels["position"], bent)
    stored = {name: row.stored for name, row in found.entry.channels.items()}
    assert stored["position"] and stored["position"].file and not stored["position"].sources
    assert stored["distance"] and stored["distance"].sources == ("depth",)


def test_a_source_that_nobody_asked_for_is_no_source(
    truth: dict[str, np.ndarray], tmp_path: Path
) -> None:
    found = written(tmp_path, view_of({"position": truth["position"]}), COMPACT)
    np.testing.assert_array_equal(found.pixels["position"], truth["position"])


@pytest.fixture
def threads() -> Callable[[int], None]:
    def use(count: int) -> None:
        OpenImageIO.attribute("threads", count)
        OpenImageIO.attribute("exr_threads", count)

    return use


def test_bytes_do_not_depend_on_threads(
    truth: dict[str, np.ndarray], threads: Callable[[int], None], tmp_path: Path
) -> None:
    before = [OpenImageIO.get_int_attribute(name) for name in ("threads", "exr_threads")]
    wide = {name: np.tile(truth[name], (8, 1, 1)) for name in ("radiance", "diffuse")}
    images = {name: Image(pixels, 4, 0.0, 0.1) for name, pixels in wide.items()}
    view = View("/a", WIDTH, 8 * HEIGHT, K, POSE, 1.0, images)
    try:
        for count in (1, 2):
            threads(count)
            written(tmp_path / str(count), view, COMPACT)
    finally:
        OpenImageIO.attribute("threads", before[0])
        OpenImageIO.attribute("exr_threads", before[1])
    one, two = ((tmp_path / str(n) / "a/light.exr").read_bytes() for n in (1, 2))
    assert one == two


@pytest.mark.parametrize(
    ("said", "about"),
    [
        ({"sources": ["valid"]}, "lists no file"),
        ({"sources": []}, "lists no file"),
        ({"file": "a/masks.exr"}, "missing|no such|does not exist|not there"),
        ({"file": "a/light.exr"}, "no channel 'depth'"),
    ],
)
def test_a_manifest_that_is_wrong_is_refused(
    compact: RenderedView, said: dict[str, object], about: str, tmp_path: Path
) -> None:
    entry = json.loads((compact.folder.parent / "entry.json").read_text())
    entry["channels"]["depth"]["stored"] = said
    (tmp_path / "a").mkdir()
    (tmp_path / "a/light.exr").write_bytes((compact.folder / "light.exr").read_bytes())
    view = RenderedView("a", tmp_path / "a", ViewEntry.model_validate_json(json.dumps(entry)))
    with pytest.raises(InputError, match=about):
        view.pixels["depth"]
