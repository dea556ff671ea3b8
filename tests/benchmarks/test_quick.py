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
        color3f[] primvars:displayColor = [(0.18, 0.18, 0.18)]
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
def test_first_picture(vectorized, room, tmp_path):
    words = ("--stage", room, "--variant", "llvm")
    _, data = run("first_picture", tmp_path / "f.json", *words)
    (row,) = data["rows"]
    assert row["first_s"] > 0 and row["again_s"] > 0


@pytest.mark.slow
def test_compose(tmp_path):
    said, data = run("compose", tmp_path / "c.json")
    (row,) = data["rows"]
    assert row["objects"] == 10
    assert row["cold_s"] > 0 and row["warm_s"] > 0
    assert "| 10 |" in said


@pytest.mark.long
def test_generate(tmp_path):
    pytest.importorskip("fcl")
    said, data = run("generate", tmp_path / "g.json")
    assert data["rooms"] == 2 and data["violations"] == []
    seconds = sum(row["generate_s"] + row["compose_s"] for row in data["timed"])
    assert data["rooms_per_minute"] == pytest.approx(60 * len(data["timed"]) / seconds)
    assert "| apartment | 1 |" in said


@pytest.mark.slow
def test_variety(tmp_path):
    said, data = run("variety", tmp_path / "v.json")
    assert data["rooms"] == 4 and 0 < data["equal in a room"] < 1
    assert 0 <= data["equal beside each other"] < 1 and "| objects in a room |" in said


@pytest.mark.long
def test_materials(vectorized, tmp_path):
    said, data = run("materials", tmp_path / "m.json")
    # Even directions miss sharp lobes; rough ones they sample nearly as well.
    polished = [row for row in data["sampling"] if row["metallic"] and row["roughness"] < 0.1]
    assert polished and all(row["uniform"] > 10 for row in polished)
    assert data["albedo"]["largest_error"] < 0.05
    first = data["albedo"]["rows"][0]
    assert first["ours"] == pytest.approx(0.55, abs=0.003)
    assert "## albedo" in said


def test_the_hall_has_as_many_objects_as_asked_for(tmp_path):
    from benchmarks.scenes import hall
    from openrooms_usd.description import load_room

    (tmp_path / "room.yaml").write_text(hall(37))
    room = load_room(tmp_path / "room.yaml")
    places = {item.at for item in room.furniture.objects}
    assert len(places) == 37


@pytest.mark.long
def test_light(vectorized, tmp_path):
    _, data = run("light", tmp_path / "l.json", "--section", "hard", "--section", "honesty")
    assert all(row["finite"] == "yes" and not row["replaced pixels"] for row in data["hard"])
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
    # To light a hemisphere takes longer than to cast its rays.
    assert all(row["further view / rays"] > 1.0 for row in data["grids"])
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
        assert all(row[f"{engine}, moved mm"] < 5.0 for row in data["speed"])


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


@pytest.mark.long
def test_loading(tmp_path, torch_packages):
    """More than ten views: all forms have them in the same order."""
    _, data = run("loading", tmp_path / "l.json", packages=torch_packages)
    assert len({row["form"] for row in data["rows"]}) == 5
    for row in data["rows"]:
        assert row["errors"]["depth"] < 1e-6 and row["errors"]["radiance"] < 0.03
    for few, many in zip(data["rows"][::2], data["rows"][1::2], strict=True):
        assert few["form"] == many["form"] and few["channels"] < many["channels"]
        assert few["processor_ms"] < many["processor_ms"]


@pytest.mark.long
def test_usd(tmp_path):
    _, data = run("usd", tmp_path / "u.json")
    assert len(data["rows"]) == 5
    for row in data["rows"]:
        for ours in (row["auto"], row["scalar"]):
            assert 0 < ours["translated"] < ours["opened"] < ours["first"]
            assert ours["error"] < 1e-5
