"""A scene that stays open: pictures as arrays, by any camera, and the files of the command."""

from pathlib import Path

import numpy as np
import pytest

import openrooms_usd as ou
from openrooms_usd.errors import InputError, UnknownNameError
from openrooms_usd.rendering import opening

CHANNELS = ("radiance", "depth", "normal", "instance", "valid", "irradiance", "environment")
SIZE = (24, 18)


@pytest.fixture(scope="module")
def renderer(vectorized: str, scene: ou.Scene) -> ou.OpenRenderer:
    return ou.open_renderer(scene, samples=2, resolution=SIZE, grid=(3, 2), method="reference")


def test_arrays_are_those_that_the_files_hold(
    renderer: ou.OpenRenderer, scene: ou.Scene, tmp_path: Path
) -> None:
    name = renderer.cameras[0]
    picture = renderer.render(name, CHANNELS)
    assert set(picture) == set(CHANNELS)
    written = ou.render(
        scene,
        tmp_path / "out",
        cameras=name,
        channels=CHANNELS,
        samples=2,
        resolution=SIZE,
        grid=(3, 2),
        method="reference",
    )
    for channel in CHANNELS:
        kept, seen = written[name][channel], picture[channel]
        assert (kept.shape, kept.dtype.kind) == (seen.shape, seen.dtype.kind), channel
        # Files hold some channels in half floats.
        assert np.allclose(kept, seen, rtol=1e-3, atol=1e-3), channel
    assert np.array_equal(written[name]["radiance"], picture["radiance"])
    assert written.legend("instance") == renderer.legend("instance")
    assert picture.error("depth") == 0.0


def test_files_are_those_of_the_command(
    renderer: ou.OpenRenderer, scene: ou.Scene, tmp_path: Path
) -> None:
    channels = ["radiance", "depth"]
    renderer.write(tmp_path / "open", channels=channels)
    settings = ou.RenderSettings(
        channels=channels, samples=2, resolution=SIZE, grid=(3, 2), method="reference"
    )
    ou.render(scene, tmp_path / "command", settings=settings)
    files = [
        {path.relative_to(out): path.read_bytes() for path in out.rglob("*") if path.is_file()}
        for out in (tmp_path / "open", tmp_path / "command")
    ]
    for found in files:
        del found[Path("timing.json")]
    assert files[0] == files[1]


def test_cameras_of_ones_own_are_written_at_their_sizes(
    renderer: ou.OpenRenderer, tmp_path: Path
) -> None:
    cameras = {
        f"w{width}": ou.Camera.look_at((1, 1, 1.5), (2, 1, 1), resolution=(width, 6))
        for width in (8, 10)
    }
    written = renderer.write(tmp_path / "out", cameras, channels=["depth"])
    for name, camera in cameras.items():
        assert written[name]["depth"].shape == (6, camera.resolution[0])
        assert np.allclose(written[name].K, camera.K)
        assert np.allclose(written[name].world_from_camera, camera.world_from_camera)


def test_a_camera_of_ones_own_sees_what_the_stages_camera_sees(renderer: ou.OpenRenderer) -> None:
    name = renderer.cameras[0]
    own = renderer.render(name, "depth")
    same = ou.Camera(own.K, own.world_from_camera, SIZE)
    assert np.array_equal(renderer.render(same, "depth")["depth"], own["depth"])
    flip = np.diag([1.0, -1.0, -1.0, 1.0])
    opengl = ou.Camera.from_opengl(own.K, own.world_from_camera @ flip, SIZE)
    assert np.array_equal(renderer.render(opengl, "depth")["depth"], own["depth"])


def test_a_camera_of_the_scene_is_the_one_of_its_name(
    renderer: ou.OpenRenderer, scene: ou.Scene
) -> None:
    name = renderer.cameras[0]
    pictures = [renderer.render(one, "radiance") for one in (name, scene.cameras[name])]
    assert np.array_equal(*(picture["radiance"] for picture in pictures))


def test_depth_of_a_wall_by_hand(renderer: ou.OpenRenderer) -> None:
    """A camera that looks straight down: its planar depth is its height above the floor."""
    camera = ou.Camera.look_at((1.0, 1.0, 1.5), (1.0, 1.0 + 1e-6, 0.0), resolution=(8, 6))
    picture = renderer.render(camera, ["depth", "position"])
    eye = np.asarray(camera.world_from_camera)[:3, 3]
    forward = np.asarray(camera.world_from_camera)[:3, 2]
    assert np.allclose(picture["depth"], (picture["position"] - eye) @ forward, atol=1e-4)


def test_more_pictures_open_and_translate_nothing(
    renderer: ou.OpenRenderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("open_stage", "translate", "load_renderer"):
        monkeypatch.setattr(opening, name, None)
    cameras = [ou.Camera.look_at((1, 1, 1.5), (2, 1, z), resolution=(8, 6)) for z in (0.2, 1.0)]
    first, second = renderer.render_batch(cameras, ["radiance", "depth"], samples=1)
    assert first["radiance"].shape == (6, 8, 3)
    assert np.abs(first["depth"] - second["depth"]).max() > 0.01


def test_cameras_that_are_none_are_refused() -> None:
    K, pose = np.diag([50.0, 50.0, 1.0]), np.eye(4)
    for wrong in (np.eye(4), np.diag([0.0, 50.0, 1.0]), "K", [[1, 2], [3, 4, 5]], K * np.nan):
        with pytest.raises(InputError, match="K"):
            ou.Camera(wrong, pose, SIZE)  # type: ignore[arg-type]
    for wrong in (np.eye(3), np.diag([1.0, 1.0, -1.0, 1.0]), 2.0 * np.eye(4)):
        with pytest.raises(InputError, match="world_from_camera"):
            ou.Camera(K, wrong, SIZE)


def test_what_is_unknown_is_refused_by_name(renderer: ou.OpenRenderer) -> None:
    with pytest.raises(InputError, match="no camera is named 'nobody'"):
        renderer.render("nobody")
    with pytest.raises(InputError, match="did you mean 'depth'"):
        renderer.render(renderer.cameras[0], "dept")
    with pytest.raises(InputError, match="no argument 'renderer'"):
        renderer.render(renderer.cameras[0], renderer="preview")
    with pytest.raises(InputError, match="did you mean 'samples'"):
        renderer.render(renderer.cameras[0], sampels=3)
    with pytest.raises(UnknownNameError, match="no label channel is named 'depth'"):
        renderer.legend("depth")


def test_a_closed_renderer_says_so(scene: ou.Scene) -> None:
    with ou.open_renderer(scene, renderer="preview", samples=1, resolution=(8, 6)) as opened:
        assert opened.render(opened.cameras[0], "depth")["depth"].shape == (6, 8)
    with pytest.raises(InputError, match="this renderer is closed"):
        opened.render("view")


@pytest.mark.parametrize("name", ["../elsewhere", "a/b", "", ".hidden", "openings"])
def test_views_lie_in_their_folder(name: str, renderer: ou.OpenRenderer, tmp_path: Path) -> None:
    camera = ou.Camera.look_at((1, 1, 1.5), (2, 1, 1), resolution=(8, 6))
    with pytest.raises(ou.OrusdError, match="a view cannot be named"):
        renderer.write(tmp_path / "out" / "inner", {name: camera}, channels="depth")
    assert not list(tmp_path.iterdir())


def test_what_gives_way_is_said(
    renderer: ou.OpenRenderer, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    camera = ou.Camera.look_at((1, 1, 1.5), (2, 1, 1), resolution=(8, 6), name="mine")
    renderer.write(tmp_path / "out", [camera], channels="depth")
    renderer.write(tmp_path / "out", renderer.cameras[0], channels="depth", resolution=(8, 6))
    assert "replaces mine" in caplog.text
    with pytest.raises(InputError, match="no camera is given"):
        renderer.write(tmp_path / "none", {})


def test_wrong_things_are_refused_in_words(renderer: ou.OpenRenderer, scene: ou.Scene) -> None:
    K, pose = np.diag([50.0, 50.0, 1.0]), np.eye(4)
    for size in ((64,), (64.5, 48), (-64, 48), None):
        with pytest.raises(InputError):
            ou.Camera(K, pose, size)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="exposure"):
        ou.Camera(K, pose, SIZE, exposure=-1.0)
    with pytest.raises(InputError, match="intrinsics"):
        ou.Camera(K + np.diag([20.0, 0.0], 1), pose, SIZE)
    with pytest.raises(InputError, match="field of view"):
        ou.Camera.look_at((0, 0, 0), (1, 0, 0), fov_degrees=180.0)
    with pytest.raises(InputError, match="eye"):
        ou.Camera.look_at((1, 1), (1, 0, 0))
    camera = ou.Camera(K, pose, SIZE)
    with pytest.raises(InputError, match="already has a size"):
        renderer.render(camera, "depth", resolution=(8, 6))
    for wrong in (3, None, np.eye(3)):
        with pytest.raises(InputError, match="not a camera"):
            renderer.render(wrong, "depth")  # type: ignore[arg-type]
    for motions in ({"chair_0": pose}, {"/World/nope": pose}):
        with pytest.raises(InputError, match="no such prim"):
            renderer.move(motions)
    with pytest.raises(InputError, match="not a rotation"):
        renderer.move({"/World": 2.0 * pose})
    with pytest.raises(InputError, match=r"expected ou\.RenderSettings"):
        ou.open_renderer(scene, settings={})  # type: ignore[arg-type]
