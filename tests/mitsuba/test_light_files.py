"""What the files and the manifest of a render say of its light, and what cannot be had."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd

from openrooms_usd.channels import CHANNELS, RENDERED
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import RenderError
from openrooms_usd.rendering import RenderRequest, exact, render_stage
from openrooms_usd.rendering.exr import read_channels
from orusd_mitsuba import session as mitsuba_session
from orusd_mitsuba.complete import integrator as complete_integrator
from orusd_mitsuba.transport import incident
from tests.mitsuba.passes import LIT, PASSES
from tests.mitsuba.rooms import half_hidden


@pytest.fixture(scope="module")
def file(lit: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("half_hidden") / "scene.usda"
    write(half_hidden(), path)
    return path


def write(stage: Usd.Stage, path: Path) -> None:
    stage.GetRootLayer().Export(str(path))


EXTRA = [name for name in RENDERED if CHANNELS[name].extra and CHANNELS[name].kind == "light"]


@pytest.mark.parametrize("name", [*EXTRA, "specular", "irradiance_unoccluded_i"])
def test_the_scalar_backend_says_before_it_starts_what_it_cannot(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    began: list[str] = []
    monkeypatch.setattr(mitsuba_session, "run_pass", lambda *args: began.append("light"))
    monkeypatch.setattr(exact, "first_hits", lambda *args: began.append("rays"))
    with pytest.raises(RenderError, match="scalar_rgb cannot give") as caught:
        render_stage(
            file,
            tmp_path / "out",
            RenderSettings(
                channels=["depth", name],
                options={"variant": "scalar"},
                resolution=(8, 6),
                samples=1,
            ),
        )
    assert "--variant llvm" in str(caught.value)
    assert not began
    assert not list(tmp_path.rglob("*.exr")) and not list(tmp_path.rglob("manifest.json"))


def rendered(file: Path, out: Path, **how: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """The channels of a view as its files have them, and what the manifest says of each."""
    asked: dict[str, Any] = {"resolution": (24, 18), "grid": (6, 4)} | how
    render_stage(file, out, RenderSettings(**asked))
    view = json.loads((out / "manifest.json").read_text())["views"]["Camera"]
    files = (view["files"].get(name) for name in ("channels", "lights"))
    stored = {n: p for file in files if file for n, p in read_channels(out / file).items()}
    return stored, view["channels"]


@pytest.mark.slow
def test_what_was_no_number_is_counted_in_every_channel(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def spoiled(real: Any, *where: Any) -> Any:
        def wrapped(self: Any, *args: Any) -> Any:
            found = np.array(real(self, *args))
            for at, bad in zip(where, (np.nan, np.inf, -np.inf), strict=True):
                found[at] = bad
            return found

        return wrapped

    # Two pixels, and two cells of hemispheres: a red and a green one share theirs.
    pixels = [np.s_[:, 1, 2, 0], np.s_[:, 1, 2, 1], np.s_[:, 3, 4, 2]]
    row = 6 * 32
    cells = [np.s_[:, 3 * row + 4, 0], np.s_[:, 3 * row + 4, 1], np.s_[:, 3 * row + 37, 2]]
    for owner, name, where in (
        (complete_integrator.CompleteIntegrator, "_band", pixels),
        (incident.IncidentRadiance, "__call__", cells),
    ):
        monkeypatch.setattr(owner, name, spoiled(getattr(owner, name), *where))
    made = ["residual", "irradiance_unoccluded_i"]
    stored, said = rendered(file, tmp_path / "out", channels=[*LIT, *made], samples=32)
    assert len(said) == 30
    counts = {name: row["nonfinite_pixels"] for name, row in said.items()}
    assert set(counts.values()) == {2}, counts
    assert all(np.isfinite(pixels).all() for pixels in stored.values())
    losses = json.loads((tmp_path / "out" / "manifest.json").read_text())["report"]["losses"]
    assert [row["reason"] for row in losses if row["prim"] == "/Camera"] == [
        f"{name} was not finite in 2 pixels; 0 is used" for name in PASSES
    ]


@pytest.mark.slow
def test_an_error_is_reached_by_each_kind_of_pass_alone(file: Path, tmp_path: Path) -> None:
    _, said = rendered(file, tmp_path / "out", channels=[*LIT], error=2e-2)
    for name in ("radiance", "environment"):
        assert 0.0 < said[name]["estimated_error"] <= 2e-2
    # What comes from the same samples has as many.
    assert said["direct_0"]["samples"] == said["radiance"]["samples"]


@pytest.mark.slow
def test_time_is_spread_over_the_kinds_of_passes(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shares: list[float] = []
    real = mitsuba_session.run_pass

    def recorded(render_pass: Any, integrator: Any, request: RenderRequest, *rest: Any) -> Any:
        assert request.samples is None and request.seconds is not None
        shares.append(request.seconds)
        return real(render_pass, integrator, request, *rest)

    monkeypatch.setattr(mitsuba_session, "run_pass", recorded)
    _, said = rendered(file, tmp_path / "out", channels=[*LIT], seconds=0.8)
    assert shares == [pytest.approx(0.8 / len(PASSES))] * len(PASSES)
    assert all(row["samples"] >= 2 for row in said.values())
    # Nothing is glossy, and nothing comes in from elsewhere.
    silent = {name for name, row in said.items() if row["estimated_robust_error"] is None}
    assert all(name == "specular" or name.endswith("_2") for name in silent)


def test_what_is_made_of_others_is_what_the_files_say(file: Path, tmp_path: Path) -> None:
    made = ["residual", "irradiance_unoccluded_i"]
    used = ["base_color", "metallic", *LIT[:-2]]
    found, _ = rendered(file, tmp_path / "out", channels=[*made, *used], samples=16)
    found = {name: pixels.astype(np.float64) for name, pixels in found.items()}
    whole = found["direct"] + found["indirect"]
    np.testing.assert_allclose(found["diffuse"] + found["specular"], whole, rtol=1e-5, atol=1e-5)
    residual = found["radiance"] - found["diffuse"]
    np.testing.assert_allclose(found["residual"], residual, rtol=1e-5, atol=1e-4)
    for light in range(2):
        straight = found[f"unoccluded_{light}"] - found[f"direct_{light}"]
        assert straight.sum() > 1.0
        np.testing.assert_allclose(
            found[f"irradiance_unoccluded_{light}"],
            found[f"irradiance_{light}"] + straight,
            rtol=1e-5,
            atol=1e-4,
        )


@pytest.mark.slow
def test_lambertian_surfaces_have_no_specular_part_and_glossy_ones_do(
    lit: Any, tmp_path: Path
) -> None:
    parts = {}
    for kind, looks in (("dull", {"ior": 1.0}), ("glossy", {"ior": 1.5, "roughness": 0.2})):
        path = tmp_path / f"{kind}.usda"
        write(half_hidden(**looks), path)
        channels = ["specular", "diffuse"]
        found, _ = rendered(path, tmp_path / kind, channels=channels, samples=256)
        parts[kind] = found["specular"].astype(np.float64), found["diffuse"].astype(np.float64)
    assert not parts["dull"][0].any() and parts["dull"][1].mean() > 1.0
    assert parts["glossy"][0].mean() > 0.03 * parts["glossy"][1].mean()
