"""A run writes what it says, whole, and the same every time."""

import dataclasses
import errno
import json
import re
import threading
from concurrent.futures import ThreadPoolExecutor, wait
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd import ledger
from openrooms_usd.channels import CHANNELS, DEFAULT, WRITTEN
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError, OutputError, RenderError
from openrooms_usd.rendering import driver, exr, folder, render_stage, run

VIEW_FILES = {"channels.exr", "radiance.exr", *(f"{name}.png" for name in WRITTEN)}


def manifest(out: Path) -> dict:
    return json.loads((out / "manifest.json").read_text())


def names(out: Path) -> set[str]:
    """What lies there, apart from the ledger of what was written."""
    return {path.name for path in out.iterdir()} - {ledger.RENDER_FILE}


def test_what_lies_there(renderer, scene, tmp_path):
    out = tmp_path / "deep" / "out"
    summary = render_stage(scene, out)
    assert names(out) == {"left", "right", "contact_sheet.png", "manifest.json", "timing.json"}
    for view in ("left", "right"):
        assert names(out / view) == VIEW_FILES
    assert summary.manifest["views"].keys() == {"left", "right"}
    assert json.loads(json.dumps(summary.as_dict()))["out"] == str(out)


def test_pixels_reach_the_files(renderer, scene, tmp_path, numbers):
    render_stage(scene, tmp_path / "out", RenderSettings(seed=5))
    back = exr.read_channels(tmp_path / "out" / "left" / "channels.exr")
    for name in DEFAULT:
        assert np.allclose(back[name], numbers(name, 30, 40, 5), rtol=1e-3, atol=1e-6), name

    import OpenImageIO

    plain = OpenImageIO.ImageBuf(str(tmp_path / "out" / "left" / "radiance.exr"))
    assert plain.spec().channelnames == ("R", "G", "B")
    assert np.array_equal(plain.get_pixels(), numbers("radiance", 30, 40, 5))


def test_manifest_says_everything(renderer, scene, tmp_path):
    def spoil(name, pixels):
        if name == "depth":
            pixels[3, 4] = np.nan
        return pixels

    renderer.spoil = spoil
    render_stage(
        scene, tmp_path / "out", RenderSettings(samples=9, seed=2, bounces=3), cameras=["right"]
    )
    said = manifest(tmp_path / "out")
    assert said["stage"] == "scene.usda"
    assert said["renderer"] == {"name": "mitsuba", "backend": "fake 1.0", "bsdf": "auto"}
    assert (said["seed"], said["bounces"], said["stop"]) == (2, 3, {"samples": 9})
    assert list(said["legend"]["instance"]) == ["1", "2", "10"]
    assert said["report"]["losses"] == [
        {"prim": "/World/Odd", "outcome": "skipped", "reason": "no such thing"}
    ]
    view = said["views"]["right"]
    assert view["camera"] == "/World/Cameras/right"
    assert view["resolution"] == [40, 30]
    assert view["K"][0] == [50.0, 0.0, 20.0]
    assert view["world_from_camera"] == np.eye(4).tolist()
    assert "OpenCV" in said["conventions"]["world_from_camera"]
    assert view["channels"]["radiance"]["estimated_error"] == 0.01
    assert view["channels"]["radiance"]["samples"] == 9
    assert view["channels"]["depth"]["nonfinite_pixels"] == 1
    assert view["channels"]["valid"]["nonfinite_pixels"] == 0
    for name, row in said["channels"].items():
        assert (row["unit"], row["meaning"]) == (CHANNELS[name].unit, CHANNELS[name].meaning)
    stored = exr.read_channels(tmp_path / "out" / view["files"]["channels"])
    assert stored.keys() == said["channels"].keys()
    for channel in view["channels"].values():
        assert (tmp_path / "out" / channel["preview"]).is_file()


def test_values_that_half_cannot_hold_are_counted(renderer, scene, tmp_path):
    renderer.spoil = lambda name, pixels: pixels * (1e6 if name == "roughness" else 1)
    render_stage(scene, tmp_path / "out", RenderSettings(channels=["roughness"]))
    view = manifest(tmp_path / "out")["views"]["left"]
    stored = exr.read_channels(tmp_path / "out" / "left" / "channels.exr")["roughness"]
    bad = view["channels"]["roughness"]["nonfinite_pixels"]
    assert bad == np.count_nonzero(~np.isfinite(stored)) > 0


@pytest.mark.slow
def test_two_runs_give_the_same_bytes(renderer, scene, tmp_path, snapshot):
    outs = [tmp_path / "here", tmp_path / "elsewhere" / "there"]
    for out in outs:
        render_stage(scene, out)
    first, second = map(snapshot, outs)
    assert first == second
    text = first["manifest.json"].decode()
    assert str(tmp_path) not in text
    assert not re.search(r"20\d\d-\d\d-\d\d|seconds|\d:\d\d:\d\d", text)


def test_timing_names_the_machine(renderer, scene, tmp_path):
    render_stage(scene, tmp_path / "out", RenderSettings(channels=["depth"]))
    said = json.loads((tmp_path / "out" / "timing.json").read_text())
    assert said["machine"]["backend"] == "fake 1.0"
    assert said["machine"]["cores"] >= 1
    assert said["machine"]["cpu"]
    assert said["views"]["left"]["channels"] == {"depth": 0.25}


def test_without_radiance_there_is_no_radiance_file(renderer, scene, tmp_path):
    render_stage(scene, tmp_path / "out", RenderSettings(channels=["depth", "valid"]))
    assert names(tmp_path / "out" / "left") == {"channels.exr", "depth.png", "valid.png"}
    assert manifest(tmp_path / "out")["views"]["left"]["files"] == {"channels": "left/channels.exr"}


def test_another_run_replaces_the_earlier_one(renderer, scene, tmp_path, snapshot):
    out, fresh = tmp_path / "out", tmp_path / "fresh"
    render_stage(scene, out)
    (out / "notes.txt").write_text("mine")
    render_stage(scene, out, RenderSettings(channels=["depth"], seed=1), cameras=["right"])
    render_stage(scene, fresh, RenderSettings(channels=["depth"], seed=1), cameras=["right"])
    assert snapshot(out) == {**snapshot(fresh), "notes.txt": b"mine"}


def test_what_is_no_render_is_not_replaced(renderer, scene, tmp_path):
    (tmp_path / "out" / "left").mkdir(parents=True)
    (tmp_path / "out" / "left" / "thesis.txt").write_text("irreplaceable")
    with pytest.raises(OutputError, match="this will not be replaced"):
        render_stage(scene, tmp_path / "out")
    assert renderer.requests == []
    assert names(tmp_path / "out") == {"left"}


@pytest.mark.parametrize("stop", [KeyboardInterrupt, RenderError("no more")])
def test_interrupted_in_the_second_view(renderer, scene, tmp_path, snapshot, stop):
    whole, out = tmp_path / "whole", tmp_path / "out"
    render_stage(scene, whole, cameras=["left"])

    def progress(view: str, fraction: float) -> None:
        if view == "right":
            raise stop

    with pytest.raises(stop if isinstance(stop, type) else type(stop)):
        render_stage(scene, out, progress=progress)
    assert snapshot(out) == snapshot(whole)
    assert list(manifest(out)["views"]) == ["left"]


def test_interrupted_while_writing(renderer, scene, tmp_path, snapshot, monkeypatch):
    out = tmp_path / "out"
    render_stage(scene, out)
    before = snapshot(out)

    def interrupted(path, images, *how):
        path.write_bytes(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr(exr, "write_channels", interrupted)
    with pytest.raises(KeyboardInterrupt):
        render_stage(scene, out, RenderSettings(seed=9))
    assert snapshot(out) == before


def test_a_view_is_written_while_the_next_is_rendered(renderer, scene, tmp_path, monkeypatch):
    """Its files wait for the next render to begin: if that waited for them, nothing would."""
    rendering, real = threading.Event(), exr.write_channels

    def write(path, images, *how):
        assert "right" in str(path) or rendering.wait(20.0)
        real(path, images, *how)

    def progress(view: str, fraction: float) -> None:
        if view == "right":
            rendering.set()

    monkeypatch.setattr(exr, "write_channels", write)
    out = tmp_path / "out"
    render_stage(scene, out, progress=progress)
    assert list(manifest(out)["views"]) == ["left", "right"]


def test_a_large_view_is_written_before_the_next_is_rendered(
    renderer, scene, tmp_path, monkeypatch
):
    monkeypatch.setattr(driver, "_MOST_BESIDE_BYTES", 0)
    out = tmp_path / "out"

    def progress(view: str, fraction: float) -> None:
        assert view == "left" or list(manifest(out)["views"]) == ["left"]

    render_stage(scene, out, progress=progress)
    assert list(manifest(out)["views"]) == ["left", "right"]


def test_what_cannot_be_written_stops_the_next_render(renderer, scene, tmp_path, monkeypatch):
    futures = []

    class Pool(ThreadPoolExecutor):
        def submit(self, *given):
            futures.append(super().submit(*given))
            return futures[-1]

    def write(path, images, *how):
        raise OutputError("no space", place=path)

    def progress(view: str, fraction: float) -> None:
        if view == "right":
            assert fraction <= 0.99, "the next view was rendered on"
            wait(futures)

    monkeypatch.setattr(driver, "ThreadPoolExecutor", Pool)
    monkeypatch.setattr(exr, "write_channels", write)
    with pytest.raises(OutputError, match="no space"):
        render_stage(scene, tmp_path / "out", progress=progress)
    assert not (tmp_path / "out").exists()


def test_interrupted_while_much_is_written(renderer, scene, tmp_path, monkeypatch):
    """The first view goes, after a moment: it is not waited for."""
    monkeypatch.setattr(driver, "_GRACE_SECONDS", 0.0)
    began, stopped = threading.Event(), threading.Event()
    real, stop = exr.write_channels, driver.ViewWriter.stop

    def write(path, images, *how):
        began.set()
        assert stopped.wait(20.0)
        real(path, images, *how)

    def stopping(self):
        stop(self)
        stopped.set()

    def progress(view: str, fraction: float) -> None:
        if view == "right":
            assert began.wait(20.0)
            raise KeyboardInterrupt

    monkeypatch.setattr(driver.ViewWriter, "stop", stopping)
    monkeypatch.setattr(exr, "write_channels", write)
    with pytest.raises(KeyboardInterrupt):
        render_stage(scene, tmp_path / "out", progress=progress)
    assert not (tmp_path / "out").exists()


def test_interrupted_before_anything(renderer, scene, tmp_path):
    def progress(view: str, fraction: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        render_stage(scene, tmp_path / "out", progress=progress)
    assert not (tmp_path / "out").exists()


def test_progress_rises_over_the_whole_run(renderer, scene, tmp_path):
    seen: list[tuple[str, float]] = []
    render_stage(scene, tmp_path / "out", progress=lambda *told: seen.append(told))
    assert seen == [("left", 0.25), ("left", 0.5), ("right", 0.75), ("right", 1.0)]


def test_full_disk_leaves_nothing_half(renderer, scene, tmp_path, snapshot, monkeypatch):
    out = tmp_path / "out"
    real, calls = run.write_png, []

    def write_png(path, pixels):
        calls.append(path)
        if "right" in str(path) and path.name == "depth.png":
            raise OSError(errno.ENOSPC, "No space left on device")
        real(path, pixels)

    monkeypatch.setattr(run, "write_png", write_png)
    with pytest.raises(OutputError, match="No space left"):
        render_stage(scene, out)
    assert names(out) == {"left", "contact_sheet.png", "manifest.json", "timing.json"}
    assert list(manifest(out)["views"]) == ["left"]


def test_too_little_space_is_known_before_the_render(renderer, scene, tmp_path, monkeypatch):
    usage = folder.shutil.disk_usage(tmp_path)._replace(free=1000)
    monkeypatch.setattr(folder.shutil, "disk_usage", lambda path: usage)
    with pytest.raises(OutputError, match="are free"):
        render_stage(scene, tmp_path / "out")
    assert renderer.requests == []
    assert not (tmp_path / "out").exists()


def test_output_that_cannot_be_is_refused_before_the_translation(renderer, scene, tmp_path):
    taken = tmp_path / "file"
    taken.write_text("")
    for out in (taken, taken / "below", Path("/proc/nowhere")):
        with pytest.raises(OutputError):
            render_stage(scene, out)
    assert renderer.opened == 0


def test_bad_input_leaves_nothing(renderer, scene, tmp_path):
    broken = tmp_path / "broken.usda"
    broken.write_text("no usd")
    with pytest.raises(InputError):
        render_stage(scene, tmp_path / "out", cameras=["lefd"])
    with pytest.raises(InputError):
        render_stage(scene, tmp_path / "out", RenderSettings(channels=["dept"]))
    for path in (tmp_path / "missing.usda", broken):
        with pytest.raises(InputError):
            render_stage(path, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_no_camera_frames_the_scene(renderer, scene, tmp_path):
    renderer.cameras = ()
    render_stage(scene, tmp_path / "out")
    assert renderer.requests[0].camera is None
    assert manifest(tmp_path / "out")["views"]["framing"]["camera"] is None


def test_a_renderer_that_breaks_its_promise(renderer, scene, tmp_path):
    renderer.spoil = lambda name, pixels: pixels[:-1]
    with pytest.raises(RenderError, match="shape"):
        render_stage(scene, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_an_earlier_manifest_that_is_broken_or_evil(renderer, scene, tmp_path):
    out, outside = tmp_path / "out", tmp_path / "outside"
    render_stage(scene, outside)
    for text in ("{", "[]", '{"views": {"../outside/left": {}, "..": {}, "": {}, ".": {}}}'):
        out.mkdir(exist_ok=True)
        (out / "manifest.json").write_text(text)
        with pytest.raises(OutputError, match="would be replaced"):
            render_stage(scene, out)
        assert names(out) == {"manifest.json"}
    assert (outside / "left" / "channels.exr").is_file()


def test_the_manifest_has_what_rendering_adds_to_the_report(renderer, scene, tmp_path):
    def spoil(name, pixels):
        renderer.report.add("/World/Cameras/left", "approximated", "told while rendering")
        return pixels

    renderer.spoil = spoil
    summary = render_stage(
        scene, tmp_path / "out", RenderSettings(channels=["depth"]), cameras=["left"]
    )
    said = manifest(tmp_path / "out")
    assert said == json.loads(json.dumps(summary.manifest))
    assert said["report"]["approximated"] == 1
    assert said["report"]["losses"][-1]["reason"] == "told while rendering"


def test_pixels_where_the_renderer_put_0_count_as_nonfinite(renderer, scene, tmp_path):
    given = renderer.render

    def render(request, progress):
        view = given(request, progress)
        image = dataclasses.replace(view.images["radiance"], replaced=3)
        return dataclasses.replace(view, images={**view.images, "radiance": image})

    renderer.render = render
    render_stage(scene, tmp_path / "out", RenderSettings(channels=["radiance", "depth"]))
    channels = manifest(tmp_path / "out")["views"]["left"]["channels"]
    counts = {name: row["nonfinite_pixels"] for name, row in channels.items()}
    assert counts == {"radiance": 3, "depth": 0}
