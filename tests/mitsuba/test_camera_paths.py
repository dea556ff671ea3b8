"""Camera paths rendered: frames, cameras and a video that agree, the same bytes every time."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError, OutputError
from openrooms_usd.geometry.pinhole import pixel_directions
from openrooms_usd.geometry.rotations import inverse
from openrooms_usd.rendering.exr import read_channels
from openrooms_usd.rendering.paths.rendering import render_path
from tests.commands import output_of, run
from tests.mitsuba.rooms import half_hidden

pytestmark = pytest.mark.slow

SIZE = (32, 24)
KEYS = """{"fov": 70, "keys": [
 {"time": 0, "position": [-0.9, -0.9, 0.0], "target": [0.3, 0.4, -0.5]},
 {"time": 1, "position": [-0.6, -0.8, 0.1], "target": [0.3, 0.4, -0.5]}]}"""


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("av")
    folder = tmp_path_factory.mktemp("room")
    half_hidden().Export(str(folder / "room.usda"))
    (folder / "tour.json").write_text(KEYS, encoding="utf-8")
    return folder


def rendered(room: Path, out: Path, **how: Any) -> Any:
    settings = RenderSettings(
        resolution=how.pop("resolution", SIZE),
        samples=8,
        denoise=how.pop("denoise", False),
        method=how.pop("method", None),
    )
    wanted = {"rate": 4, "keep_frames": True} | how
    return render_path(room / "room.usda", out, str(room / "tour.json"), settings, **wanted)


@pytest.fixture(scope="module")
def made(room: Path, tmp_path_factory: pytest.TempPathFactory) -> Any:
    return rendered(room, tmp_path_factory.mktemp("out"))


def test_frames_cameras_and_video_agree(made: Any) -> None:
    import av

    told = json.loads(made.cameras.read_text(encoding="utf-8"))
    assert told == json.loads(json.dumps(made.manifest))
    with av.open(str(made.video)) as container:
        shown = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    assert len(shown) == len(told["frames"]) == 4
    assert {picture.shape for picture in shown} == {(SIZE[1], SIZE[0], 3)}
    rays = pixel_directions(np.array(told["K"]), *SIZE)
    for number, frame in enumerate(told["frames"]):
        pose = np.array(frame["world_from_camera"])
        images = read_channels(made.frames / f"frame_{number:04d}.exr")
        found = (rays * images["depth"]) @ pose[:3, :3].T + pose[:3, 3]
        np.testing.assert_allclose(found, images["position"], atol=1e-4)
    assert told["flicker"]["mean"] < told["flicker"]["stated"]


def test_flicker_is_what_positions_say(made: Any) -> None:
    """Measured once more by the nearest pixels of exact positions alone, without the package."""
    told = made.manifest["frames"]
    names = [made.frames / f"frame_{number:04d}.exr" for number in range(len(told))]
    images = [read_channels(name) for name in names]
    K, weights = np.array(made.manifest["K"]), np.array([0.2126, 0.7152, 0.0722])
    raw = []
    for before, now, pose in zip(images, images[1:], told, strict=False):
        world = inverse(np.array(pose["world_from_camera"]))
        local = now["position"].reshape(-1, 3) @ world[:3, :3].T + world[:3, 3]
        at = np.floor((local @ K.T)[:, :2] / local[:, 2:]).astype(int)
        inside = ((at >= 0) & (at < SIZE)).all(axis=1)
        row, column = np.where(inside, at[:, 1], 0), np.where(inside, at[:, 0], 0)
        apart = before["position"][row, column] - now["position"].reshape(-1, 3)
        same = inside & (np.linalg.norm(apart, axis=1) < 0.05)
        fresh, old = (
            now["radiance"].reshape(-1, 3) @ weights,
            before["radiance"][row, column] @ weights,
        )
        mean = 0.5 * (fresh + old)
        change = (fresh - old) ** 2 / (mean**2 + 0.01 * fresh.mean() ** 2)
        raw.append(np.sqrt(change[same].mean() / 2))
    # Frames by themselves flicker more than with what is known from those before.
    assert made.manifest["flicker"]["mean"] < 0.7 * np.mean(raw)


def test_a_path_gives_the_same_bytes_again(room: Path, made: Any, tmp_path: Path) -> None:
    again = rendered(room, tmp_path)
    for name in ("tour.webm", "tour.json", "tour_frames/frame_0003.exr"):
        assert (again.video.parent / name).read_bytes() == (made.video.parent / name).read_bytes()


def test_what_is_not_ours_is_not_replaced(room: Path, tmp_path: Path) -> None:
    (tmp_path / "tour.json").write_text("{}", encoding="utf-8")
    with pytest.raises(OutputError, match="would be replaced"):
        rendered(room, tmp_path)
    with pytest.raises(InputError, match="does not move"):
        render_path(room / "room.usda", tmp_path / "out", "Camera", RenderSettings(resolution=SIZE))
    with pytest.raises(InputError, match="frames per second"):
        rendered(room, tmp_path, rate=0)
    with pytest.raises(InputError, match="seconds"):
        rendered(room, tmp_path, seconds=float("nan"))
    assert not (tmp_path / "out").exists()


def test_one_command_writes_a_walk(room: Path, tmp_path: Path) -> None:
    command = ["render", str(room / "room.usda"), "-o", str(tmp_path), "--path", "walk"]
    more = ["--duration", "0.5", "--fps", "4", "--resolution", "16x12", "--spp", "2"]
    done = output_of(*command, *more)
    assert "2 frames of 16x12" in done
    assert (tmp_path / "walk.webm").stat().st_size > 100
    refused = run(*command, "--target-error", "0.1")
    assert refused.exit_code == 2 and "a video (--path) has no --target-error" in refused.output
    refused = run(*command[:4], "--fps", "4")
    assert refused.exit_code == 2 and "belong to --path" in refused.output
