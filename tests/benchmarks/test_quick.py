"""The benchmarks run, and measure what they say."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]

ROOM = """#usda 1.0
(
    defaultPrim = "World"
    upAxis = "Z"
    metersPerUnit = 1
)
def Xform "World"
{
    def Cube "Box"
    {
        double size = 4
    }
    def SphereLight "Lamp"
    {
        float inputs:intensity = 500
        float inputs:radius = 0.3
    }
    def Camera "eye"
    {
        double3 xformOp:translate = (0, 0, 1.5)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
"""


def run(name: str, target: Path, *words: object, packages: str = "") -> tuple[str, dict]:
    command = [sys.executable, "-m", f"benchmarks.{name}", "--quick", "--json", target, *words]
    env = {**os.environ, "PYTHONPATH": packages}
    done = subprocess.run([*map(str, command)], cwd=ROOT, capture_output=True, text=True, env=env)
    assert done.returncode == 0, done.stderr
    return done.stdout, json.loads(target.read_text())


@pytest.fixture
def room(tmp_path: Path) -> Path:
    path = tmp_path / "room.usda"
    path.write_text(ROOM)
    return path


@pytest.mark.slow
def test_radiance(room, tmp_path):
    _, data = run("radiance", tmp_path / "r.json", "--stage", room)
    few, more, reference = data["rows"]
    assert (few["samples"], more["samples"], reference["samples"]) == (2, 8, 64)
    assert few["relative_mse"] > more["relative_mse"] > 0
    assert reference["relative_mse"] is None
    assert data["backends"][0]["share"] > 0


@pytest.mark.long
def test_radiance_with_denoising(room, tmp_path):
    said, data = run("radiance", tmp_path / "r.json", "--stage", room, "--denoise")
    few, more, reference = data["rows"]
    assert few["denoised_mse"] < few["relative_mse"]
    assert few["seconds_with_denoising"] > few["seconds"]
    assert reference["denoised_mse"] is None
    bias = data["denoiser"]
    assert all(np.isfinite(value) for value in bias.values()) and "mean signed" in said
    # Two references of 64 samples are alike; a denoiser leaves their mean nearly alone.
    assert 0 < bias["raw reference, relative MSE"] < more["relative_mse"]
    assert abs(bias["denoised, mean signed difference"]) < 0.05
    assert 20 < data["backends"][0]["memory_MB"] < 4000
    assert "| scalar | 8 |" in said


@pytest.mark.slow
def test_first_picture(room, tmp_path):
    said, data = run("first_picture", tmp_path / "f.json", "--stage", room)
    assert data["rows"][0]["first_s"] > 0
    assert "| scalar |" in said


@pytest.mark.slow
def test_compose(tmp_path):
    said, data = run("compose", tmp_path / "c.json")
    assert data["rows"][0]["objects"] == 10
    assert data["rows"][0]["cold_s"] > 0
    assert "| 10 |" in said


@pytest.mark.long
def test_generate(tmp_path):
    pytest.importorskip("fcl")
    said, data = run("generate", tmp_path / "g.json")
    assert data["rooms"] == 2 and data["violations"] == []
    assert data["rooms_per_minute"] > 0 and data["objects_per_asset"] >= 1
    assert "| apartment | 1 |" in said


@pytest.mark.long
def test_materials(vectorized, tmp_path):
    said, data = run(
        "materials", tmp_path / "m.json", "--section", "sampling", "--section", "albedo"
    )
    assert all(row["principled"] > 0 and row["uniform"] > 0 for row in data["sampling"])
    assert data["albedo"]["largest_error"] < 0.05
    first = data["albedo"]["rows"][0]
    assert first["ours"] == pytest.approx(0.55, abs=0.003)
    assert "## albedo" in said


def test_relative_mse_of_a_known_error(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT))
    from benchmarks.radiance import relative_mse

    reference = np.full((5, 6, 3), [1.0, 2.0, 4.0])
    for factor in (0.5, 1.1, 3.0):
        expected = (factor - 1) ** 2 / 1.01
        assert relative_mse(factor * reference, reference) == pytest.approx(expected)


def test_the_hall_has_as_many_objects_as_asked_for(monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(str(ROOT))
    from benchmarks.scenes import hall
    from openrooms_usd.description import load_room

    (tmp_path / "room.yaml").write_text(hall(37))
    room = load_room(tmp_path / "room.yaml")
    places = {item.at for item in room.alignment.objects}
    assert len(places) == 37


@pytest.mark.long
def test_light(vectorized, tmp_path):
    asked = ("radiance", "environment", "hard", "honesty")
    sections = [word for name in asked for word in ("--section", name)]
    said, data = run("light", tmp_path / "l.json", *sections)
    errors = {row["estimator"]: row["relative MSE"] for row in data["radiance"]}
    assert errors.keys() == {"path", "path, tuned", "ours"}
    assert all(0 < error < 1 for error in errors.values())
    both, _, alone, _ = (row["relative MSE"] for row in data["environment"])
    assert both < alone
    assert all(row["finite"] == "yes" and not row["replaced pixels"] for row in data["hard"])
    assert "to path" in said
    whole, *parts = data["honesty"]
    assert whole["pictures"] == sum(row["pictures"] for row in parts if row["by"] == "channel") > 9
    assert 0.5 < whole["robust: estimate / truth"] < 3.0


@pytest.mark.long
def test_light_of_every_method(vectorized, tmp_path):
    sections = ("--section", "pictures", "--section", "grids", "--section", "channels")
    rooms = ("--room", "plain", "--room", "bedroom", "--references", tmp_path / "references")
    _, data = run("light", tmp_path / "l.json", *sections, *rooms)
    shown = {row["method"] for row in data["pictures"]}
    assert {"reference", "the reference itself"} <= shown
    # An unbiased estimator is not found to be biased.
    reference = next(row for row in data["pictures"] if row["method"] == "reference")
    assert abs(reference["bias, %"]) < 5.0 * reference["+-"]
    assert all(row["s, rays alone"] > 0.0 for row in data["grids"])
    assert {row["channel"] for row in data["channels"]} >= {"radiance", "irradiance_i"}


@pytest.mark.long
def test_physics_by_step(tmp_path):
    pytest.importorskip("pybullet")
    pytest.importorskip("mujoco")
    sections = ("--section", "push", "--section", "speed")
    _, data = run("physics", tmp_path / "p.json", *sections)
    for engine in ("pybullet", "mujoco"):
        # A shorter step is nearer to the closed form, on average.
        errors = {4.0: [], 2.0: []}
        for row in data["push"]:
            errors[row["step, ms"]].append(abs(row[f"{engine}, %"]))
        assert np.mean(errors[2.0]) < np.mean(errors[4.0])
        assert all(row[f"{engine}, steps/s"] > 0 for row in data["speed"])
        assert all(row[f"{engine}, moved mm"] < 5.0 for row in data["speed"])


@pytest.mark.long
def test_storage(vectorized, tmp_path):
    said, data = run("storage", tmp_path / "s.json")
    families = {row["family"]: row for row in data["room 1"]["families"]}
    light = families["environment"]
    assert light["dwa 1000 MB"] < light["dwa 45 MB"] < light["half MB"] < light["float MB"]
    assert 0 < light["half"] < light["dwa 45"] < light["dwa 1000"] < light["SH 2"]
    views = data["room 1"]["views"]
    assert views["compact"] < views["complete"] and "| compact |" in said


@pytest.mark.long
def test_dataset(tmp_path):
    _, data = run("dataset", tmp_path / "d.json")
    (made,) = data["runs"]
    assert made["samples"] == 4 and 0 < made["error"] < 1 and made["MB_a_view"] > 0
    phases = sum(made[f"{name}_s"] for name in ("compose", "translation", "render", "output"))
    assert 0 < phases < made["s_a_view"]
    (beside,) = data["beside_others"]
    # 700 s of the clock for 640 x 480 pixels.
    assert beside["us_a_pixel"] * beside["paper_times"] == pytest.approx(700e6 / (640 * 480))
    assert data["planning"]["units"] == 10_000


@pytest.mark.long
def test_loading(tmp_path, torch_packages):
    """More than ten views: all forms have them in the same order."""
    _, data = run("loading", tmp_path / "l.json", packages=torch_packages)
    assert len({row["form"] for row in data["rows"]}) == 5
    for row in data["rows"]:
        assert row["errors"]["depth"] < 1e-6 and row["errors"]["radiance"] < 0.03
        assert all(speed > 0 for speed in row["views_a_second"])


@pytest.mark.long
def test_usd(tmp_path):
    _, data = run("usd", tmp_path / "u.json")
    assert len(data["rows"]) == 5
    for row in data["rows"]:
        for ours in (row["auto"], row["scalar"]):
            assert 0 < ours["translated"] < ours["opened"] < ours["first"]
            assert ours["error"] < 1e-5
