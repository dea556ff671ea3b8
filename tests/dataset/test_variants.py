"""Variants of a room: what is said to be other is, and nothing else."""

from pathlib import Path

import pytest

from openrooms_usd.dataset.plan import Job, plan_jobs
from openrooms_usd.dataset.variants import described, realised, with_other_lights
from openrooms_usd.description import Room, load_dataset, room_of
from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.library.surroundings.sunlight import sun_position

TEXT = """\
rooms:
  - {types: [bathroom], count: 1}
views: {count: 4, resolution: [64, 48], fov: 57.95}
variants: [main, mainDiffMat, mainDiffLight, mainDiffMatLight]
"""


@pytest.fixture(scope="module")
def rooms(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Room]:
    file = tmp_path_factory.mktemp("variants") / "dataset.yaml"
    file.write_text(TEXT)
    dataset = load_dataset(file)
    return {job.variant: realised(job, dataset.views, dataset.folder) for job in plan_jobs(dataset)}


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("variant", "other"),
    [
        ("mainDiffMat", {"materials"}),
        ("mainDiffLight", {"lights"}),
        ("mainDiffMatLight", {"materials", "lights"}),
    ],
)
def test_a_variant_differs_in_what_it_says(
    rooms: dict[str, Room], variant: str, other: set[str]
) -> None:
    main, found = rooms["main"].as_dict(), rooms[variant].as_dict()
    assert {key for key in main if main[key] != found[key]} == other


def test_both_is_one_and_the_other(rooms: dict[str, Room]) -> None:
    both, materials = rooms["mainDiffMatLight"].as_dict(), rooms["mainDiffMat"].as_dict()
    assert both["materials"] == materials["materials"]
    assert materials["materials"]["look"] == 1


def test_cameras_are_those_of_the_dataset(rooms: dict[str, Room]) -> None:
    (view,) = rooms["main"].as_dict()["cameras"]["views"]
    assert (view["count"], view["fov"]) == (4, 57.95)
    assert rooms["main"].cameras.resolution == (64, 48)


def test_other_lights_come_by_day_and_some_lamp_is_on(rooms: dict[str, Room]) -> None:
    before = rooms["main"]
    for seed in range(12):
        after = with_other_lights(before, seed)
        now, then = after.lights.environment, before.lights.environment
        assert (now.scene, now.facing, now.latitude) == (then.scene, then.facing, then.latitude)
        assert sun_position(now.moment, now.latitude, now.longitude).elevation > 0.0
        assert any(lamp.on for lamp in after.lights.lamps.values())
        assert set(before.lights.lamps) <= set(after.lights.lamps)
        assert after == with_other_lights(before, seed)


@pytest.mark.parametrize(
    "environment",
    [{"from": "constant"}, {"from": "file", "file": "sky.exr"}, {"file": "a.exr", "scale": 2.0}],
)
def test_every_environment_has_another(environment: dict[str, object]) -> None:
    lights = {"environment": environment, "lamps": {"a": {"radiance": [1, 2, 3]}}}
    objects = [{"category": "floor_lamp", "name": "a", "at": [1, 1]}]
    room = room_of({"lights": lights, "alignment": {"objects": objects}})
    found = [with_other_lights(room, seed).lights for seed in (1, 2)]
    assert found[0].environment != found[1].environment != room.lights.environment
    assert all(lights.lamps["a"].on for lights in found)
    given = {key: value for key, value in environment.items() if key in ("from", "file")}
    assert {
        k: v for k, v in found[0].environment.model_dump(by_alias=True).items() if k in given
    } == given


def test_lamps_of_which_nobody_says_how_bright_they_are_are_other_too() -> None:
    objects = [{"category": "floor_lamp", "name": "a", "at": [1, 1]}]
    room = room_of({"alignment": {"objects": objects}})
    usual = CATEGORIES["floor_lamp"].lumen
    found = [with_other_lights(room, seed).lights.lamps["a"].lumen for seed in range(20)]
    assert len(set(found)) == 20 and 0.5 * usual <= min(found) < usual < max(found) <= 1.6 * usual


def test_a_dim_panorama_does_not_go_out() -> None:
    room = room_of({"lights": {"environment": {"file": "a.exr", "scale": 1e-7}}})
    assert 0.0 < with_other_lights(room, 1).lights.environment.scale < 1e-6


def test_what_a_person_said_of_materials_stays(tmp_path: Path, source: Path) -> None:
    room = source.parent / "good" / "room.yaml"
    room.write_text(
        room.read_text().replace("{resolution: 16}", "{resolution: 16, floor: carrara_marble}")
    )
    dataset = load_dataset(source)
    job: Job = list(plan_jobs(dataset))[1]
    assert job.variant == "mainDiffMat"
    found = realised(job, dataset.views, dataset.folder).materials
    said = described(job, dataset.folder).materials.floor
    assert (found.look, found.looks, found.floor) == (1, 2, said)
