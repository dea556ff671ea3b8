"""Relighting: the sum that it is, against numbers, and its refusals."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import UsdLux

from openrooms_usd.errors import InputError, OutputError
from openrooms_usd.rendering import exr
from openrooms_usd.rendering.exr import read_picture
from openrooms_usd.rendering.relight import Relighting, blackbody, relight

SHAPE: dict[str, Any] = {
    "world_from_box": np.eye(4).tolist(),
    "size": [1.0, 1.0, 1.0],
    "radiance": [1.0, 1.0, 1.0],
}
LIGHTS = [
    {"number": 0, "name": "lamp_1", "kind": "lamp", "kelvin": 4000.0, "on": True, **SHAPE},
    {"number": 1, "name": "lamp_2", "kind": "lamp", "kelvin": 3000.0, "on": False, **SHAPE},
    {"number": 2, "name": "window_0", "kind": "opening", "kelvin": None, "on": True, **SHAPE},
]


def parts() -> list[np.ndarray]:
    rng = np.random.default_rng(0)
    return [(rng.random((6, 8, 3)) * scale).astype(np.float32) for scale in (10.0, 0.0, 1e9)]


@pytest.fixture
def view(tmp_path: Path) -> Path:
    folder = tmp_path / "out" / "left"
    folder.mkdir(parents=True)
    images = {f"radiance_{number}": pixels for number, pixels in enumerate(parts())}
    exr.write_channels(folder / "lights.exr", images)
    exr.write_channels(folder / "channels.exr", {"radiance": sum(parts())})
    entry = {
        "resolution": [8, 6],
        "exposure": 1e-9,
        "camera": "/World/Cameras/left",
        "K": np.eye(3).tolist(),
        "world_from_camera": np.eye(4).tolist(),
    }
    manifest = {
        "views": {"left": entry},
        "lights": LIGHTS,
        "stage": "scene.usda",
        "legend": {},
        "generator": "openrooms_usd 0.2.0",
    }
    (tmp_path / "out/manifest.json").write_text(json.dumps(manifest))
    return folder


def picture(view: Path, *how: Any) -> np.ndarray:
    out = view.parent.parent / "relit"
    relight(view, out, Relighting(*how))
    return read_picture(out / "radiance.exr")


def test_nothing_turned_is_the_picture(view: Path) -> None:
    np.testing.assert_allclose(picture(view), sum(parts()), rtol=1e-6)


def test_a_light_that_is_off_leaves_no_trace_however_bright(view: Path) -> None:
    np.testing.assert_array_equal(picture(view, {"window_0": 0.0}), parts()[0])


def test_scales_multiply(view: Path) -> None:
    found = picture(view, {"lamp_1": 2.5, "window_0": 0.0})
    np.testing.assert_allclose(found, 2.5 * parts()[0], rtol=1e-6)


def test_a_temperature_changes_hue_and_not_luminance(view: Path) -> None:
    was, becomes = (np.array(UsdLux.BlackbodyTemperatureAsRgb(k)) for k in (4000.0, 2700.0))
    weights = [0.2126, 0.7152, 0.0722]
    ratio = (becomes / (becomes @ weights)) / (was / (was @ weights))
    found = picture(view, {"window_0": 0.0}, {"lamp_1": 2700.0})
    np.testing.assert_allclose(found, parts()[0] * ratio, rtol=1e-5)
    assert blackbody(4000.0) @ weights == pytest.approx(1.0)
    assert ratio[0] > 1.0 > ratio[2]


def test_files_say_what_was_done(view: Path) -> None:
    out = view.parent.parent / "relit"
    relight(view, out, Relighting({"window_0": 0.5}, {"lamp_1": 5000.0}))
    manifest = json.loads((out / "manifest.json").read_text())
    by_name = {light["name"]: light for light in manifest["lights"]}
    assert by_name["window_0"]["factor"] == [0.5] * 3
    assert (by_name["lamp_1"]["scale"], by_name["lamp_1"]["kelvin"]) == (1.0, 5000.0)
    assert manifest["view"] == "left"
    assert sorted(path.name for path in out.iterdir()) == [
        ".orusd.relight.sha256",
        "manifest.json",
        "radiance.exr",
        "radiance.png",
    ]
    before = [(out / name).read_bytes() for name in ("manifest.json", "radiance.exr")]
    relight(view, out, Relighting({"window_0": 0.5}, {"lamp_1": 5000.0}))
    assert [(out / name).read_bytes() for name in ("manifest.json", "radiance.exr")] == before


def test_a_render_with_one_view_stands_for_it(view: Path) -> None:
    np.testing.assert_array_equal(
        picture(view.parent, {"window_0": 0.0}), picture(view, {"window_0": 0.0})
    )


@pytest.mark.parametrize(
    ("how", "said"),
    [
        (({"lamp_3": 0.0},), "did you mean"),
        (({}, {"sun": 3000.0}), "lamp_1, lamp_2, window_0"),
        (({"lamp_2": 1.0},), "was off"),
        (({"lamp_1": -1.0},), "not negative"),
        (({"lamp_1": float("inf")},), "not negative"),
        (({"lamp_1": float("nan")},), "not negative"),
        (({}, {"lamp_1": float("nan")}), "1000"),
        (({}, {"lamp_2": 3000.0}), "was off"),
        (({}, {"window_0": 3000.0}), "no colour temperature"),
        (({}, {"lamp_1": 20.0}), "1000"),
    ],
)
def test_what_cannot_be_is_refused(view: Path, how: Any, said: str) -> None:
    with pytest.raises(InputError) as refused:
        relight(view, view.parent.parent / "relit", Relighting(*how))
    assert said in str(refused.value)
    assert not (view.parent.parent / "relit").exists()


def test_a_render_is_never_overwritten(view: Path) -> None:
    files = {p: p.read_bytes() for p in view.parent.rglob("*") if p.is_file()}
    with pytest.raises(OutputError, match="would be replaced"):
        relight(view, view.parent, Relighting({"lamp_1": 0.0}))
    assert {p: p.read_bytes() for p in view.parent.rglob("*") if p.is_file()} == files
    # An earlier relit picture is.
    for factor in (0.0, 1.0):
        found = picture(view, {"lamp_1": factor})
    np.testing.assert_allclose(found, sum(parts()), rtol=1e-6)


def test_light_from_elsewhere_is_a_light_too(view: Path) -> None:
    path = view.parent / "manifest.json"
    manifest = json.loads(path.read_text())
    manifest["lights"][2] |= {"name": "elsewhere", "kind": "elsewhere"}
    path.write_text(json.dumps(manifest))
    np.testing.assert_array_equal(picture(view, {"elsewhere": 0.0}), parts()[0])
    with pytest.raises(InputError, match="no colour temperature"):
        relight(view, view.parent.parent / "b", Relighting({}, {"elsewhere": 3000.0}))


def test_what_is_no_such_view_is_refused(view: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not a view"):
        relight(view.parent / "right", tmp_path / "relit", Relighting())
    with pytest.raises(InputError, match="not a finished render"):
        relight(tmp_path / "nowhere" / "left", tmp_path / "relit", Relighting())
    images = {"radiance_0": parts()[0], "radiance_1": parts()[1]}
    exr.write_channels(view / "lights.exr", images)
    with pytest.raises(InputError, match="contributions of window_0"):
        relight(view, tmp_path / "relit", Relighting())
    (view / "lights.exr").unlink()
    with pytest.raises(InputError, match="lamp_1"):
        relight(view, tmp_path / "relit", Relighting())
