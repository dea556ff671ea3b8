"""Renders read like mappings, and say the same as the files."""

from pathlib import Path

import numpy as np
import pytest

import openrooms_usd as ou
from openrooms_usd.errors import InputError, UnknownNameError
from openrooms_usd.rendering import driver
from openrooms_usd.rendering.exr import read_channels
from tests.api.tiny import CHANNELS


def test_a_render_is_a_mapping_of_mappings(rendered: ou.Render, scene: ou.Scene) -> None:
    assert rendered.folder == scene.folder / "render"
    assert list(rendered) == ["left", "right"] and len(rendered) == 2
    assert rendered.lights == ("ceiling_lamp_0", "window_0", "elsewhere")
    for name, view in rendered.items():
        assert view.name == name and (view.width, view.height) == (16, 12)
        assert {"depth", "radiance_0", "mask_2", "environment_sg"} <= set(view)
        assert all(isinstance(view[channel], np.ndarray) for channel in view)
        assert view.get("friction") is None and "friction" not in view
    assert "left" in repr(rendered) and "depth" in repr(rendered["left"])


def test_arrays_have_the_form_of_their_meaning(rendered: ou.Render) -> None:
    view = rendered["left"]
    pixels = read_channels(view.folder / "channels.exr", (16, 12))
    assert np.array_equal(view["depth"], pixels["depth"][..., 0])
    assert np.array_equal(view["radiance"], pixels["radiance"])
    assert view["depth"].shape == (12, 16) and view["radiance"].shape == (12, 16, 3)
    assert view["valid"].dtype == bool and view["mask_0"].dtype == bool
    assert view["valid"].all() and view["mask_0"].shape == (12, 16)
    assert np.issubdtype(view["semantic"].dtype, np.integer)
    assert {rendered.legend("semantic")[n] for n in np.unique(view["semantic"])} >= {"wall"}
    assert view["environment"].shape == (3, 4, 16, 32, 3)
    assert view["environment_sg"].shape == (3, 4, 12, 6)


def test_depth_goes_back_to_positions(rendered: ou.Render) -> None:
    for view in rendered.values():
        columns, rows = np.meshgrid(np.arange(16) + 0.5, np.arange(12) + 0.5)
        rays = np.stack([columns, rows, np.ones_like(rows)], -1) @ np.linalg.inv(view.K).T
        camera = view.world_from_camera
        points = (rays * view["depth"][..., None]) @ camera[:3, :3].T + camera[:3, 3]
        assert np.abs(points - view["position"]).max() < 1e-5


def test_lights_sum_to_the_picture(rendered: ou.Render) -> None:
    view = rendered["right"]
    parts = sum(view[f"radiance_{number}"] for number in range(len(rendered.lights)))
    assert np.allclose(parts, view["radiance"], rtol=1e-4, atol=1e-3)
    relit = ou.relight(view, {"window_0": 0, "elsewhere": 0.0})
    assert np.allclose(relit.radiance, view["radiance_0"], rtol=1e-5)
    assert relit.factors["ceiling_lamp_0"].tolist() == [1, 1, 1]


def test_what_is_relit_is_written_where_it_is_wanted(rendered: ou.Render, here: Path) -> None:
    ou.relight(rendered["left"], {"window_0": 0.5})
    assert list(here.iterdir()) == []
    ou.relight(str(rendered["left"].folder), {"window_0": 0.5}, out="relit")
    assert {path.name for path in Path("relit").iterdir()} == {
        ".orusd.relight.sha256",
        "manifest.json",
        "radiance.exr",
        "radiance.png",
    }


def test_a_name_that_is_not_there_is_a_key_error_with_a_remedy(rendered: ou.Render) -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'left'") as refused:
        rendered["lefft"]
    assert "right" in (refused.value.remedy or "")
    view = rendered["left"]
    with pytest.raises(KeyError, match="did you mean 'depth'"):
        view["depht"]
    for name, asked in (("friction", "friction"), ("direct_1", "direct_i")):
        with pytest.raises(UnknownNameError) as refused:
            view[name]
        assert f"{asked!r} among the channels" in (refused.value.remedy or "")
    with pytest.raises(UnknownNameError) as refused:
        view["nonsense"]
    assert "render again" not in (refused.value.remedy or "")


def test_the_same_render_is_read_back(rendered: ou.Render) -> None:
    again = ou.open_render(rendered.folder)
    assert list(again) == list(rendered)
    assert np.array_equal(again["left"]["radiance"], rendered["left"]["radiance"])
    with pytest.raises(InputError, match="not a finished render"):
        ou.open_render(rendered.folder.parent)


def test_compact_files_are_read_alike(scene: ou.Scene, rendered: ou.Render, here: Path) -> None:
    found = ou.render(
        scene, here / "compact", channels=CHANNELS, samples=1, grid=(4, 3), storage="compact"
    )
    assert found.rendered.manifest.storage == "compact"
    assert not (found.folder / "left/environment_sh.npy").exists()
    for name, view in rendered.items():
        assert list(found[name]) == list(view)
        for channel, pixels in view.items():
            other = found[name][channel]
            assert (other.shape, other.dtype) == (pixels.shape, pixels.dtype), channel
        for channel in ("depth", "semantic", "valid", "mask_0"):
            assert np.array_equal(found[name][channel], view[channel])
        off = np.abs(found[name]["radiance"] - view["radiance"]).mean()
        assert off < 0.05 * view["radiance"].mean()
    with pytest.raises(InputError, match="storage"):
        ou.render(scene, storage="tiny")


def test_what_stays_is_logged(
    scene: ou.Scene,
    rendered: ou.Render,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    told = driver.RenderSummary(rendered.folder, {}, {}, (Path("old"),))
    monkeypatch.setattr(driver, "render_stage", lambda *_, **__: told)
    ou.render(scene, rendered.folder)
    assert [record.name for record in caplog.records] == ["openrooms_usd"]
    assert "old is kept" in caplog.text


def test_numbers_that_are_none_are_refused_by_name(scene: ou.Scene) -> None:
    for wrong in (320, (1, 2, 3), "640x480", (1.5, 2)):
        with pytest.raises(InputError, match=r"is not (two whole numbers|a whole number)"):
            ou.render(scene, resolution=wrong)  # type: ignore[arg-type]
    for points in ((1, 2, 3), [(1, 2)], 3):
        with pytest.raises(InputError, match="are not points"):
            ou.probe(scene, at=points)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="one of: static, dynamic"):
        ou.simulate(scene, friction="sticky")  # type: ignore[arg-type]
    for wrong in ({"order": "bgr"}, {"layout": "flat"}, {"crowded": "no"}):
        with pytest.raises(InputError, match="cannot be chosen"):
            ou.write_dataset(scene, "set", **wrong)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="no channel is named 'dept'"):
        ou.render(scene, channels=["dept"])


def test_what_a_renderer_can_be_asked_for_reaches_it(scene: ou.Scene, here: Path) -> None:
    how = {"samples": 1, "resolution": (16, 12)}
    shown = ou.render(
        scene,
        here / "out",
        channels="radiance",
        **how,  # type: ignore[arg-type]
        options={"variant": "scalar"},
    )
    assert "scalar_rgb" in shown.rendered.manifest.renderer["backend"]
    for ask in (ou.render, ou.probe):
        given = {"at": [(1, 1, 1)]} if ask is ou.probe else {}
        with pytest.raises(InputError, match="no option 'varant'"):
            ask(scene, here / "none", options={"varant": "llvm"}, **given)  # type: ignore[operator]


@pytest.mark.slow
def test_a_probe_is_read_like_a_render(scene: ou.Scene, here: Path) -> None:
    seen: list[float] = []
    probes = ou.probe(
        scene,
        here / "probes",
        at=[(2, 1.5, 1.2)],
        resolution=(16, 8),
        samples=1,
        progress=lambda what, done: seen.append(done),
    )
    assert list(probes) == ["probe_0"] and seen[-1] == 1.0
    probe = probes["probe_0"]
    assert probe.position == (2, 1.5, 1.2)
    assert probe.panorama.shape == (8, 16, 3) and probe.panorama.min() >= 0
    assert probe.radiance.shape == probe.irradiance.shape == (9, 3)
    # The constant term is the mean radiance; its irradiance is pi times that.
    assert np.allclose(probe.irradiance[0], np.pi * probe.radiance[0])
    with pytest.raises(UnknownNameError, match="probe_0"):
        probes["probe_1"]


def test_a_dataset_of_a_render(rendered: ou.Render, here: Path) -> None:
    seen: list[tuple[str, float]] = []
    summary = ou.write_dataset(rendered, "set", progress=lambda *done: seen.append(done))
    assert [what for what, _ in seen] == ["left", "right"] and seen[-1][1] == 1.0
    assert summary.frames == {"main_xml": [1, 2]}
    assert "2 views" in repr(summary)
