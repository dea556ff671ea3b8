"""The plan follows from the file, and variants change what is said to be other."""

from collections import Counter
from importlib.util import find_spec
from itertools import islice
from pathlib import Path

import pytest

from openrooms_usd.dataset import plan
from openrooms_usd.dataset.plan import Job, code_of, jobs_of, lines, plan_jobs
from openrooms_usd.dataset.variants import described, realised, with_other_lights
from openrooms_usd.description import Room, load_dataset, room_of
from openrooms_usd.errors import DescriptionError, InputError
from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.library.surroundings.sunlight import sun_position
from openrooms_usd.names import STEPS

GENERATED = """\
seed: 7
rooms:
  - {types: [bedroom, kitchen], count: 1000}
views: {count: 2}
variants: [main, mainDiffLight]
"""


def planned(tmp_path: Path, text: str) -> list[Job]:
    (tmp_path / "dataset.yaml").write_text(text)
    return list(plan_jobs(load_dataset(tmp_path / "dataset.yaml")))


def test_the_same_file_gives_the_same_plan(tmp_path: Path) -> None:
    jobs = planned(tmp_path, GENERATED)
    assert list(lines(jobs)) == list(lines(planned(tmp_path, GENERATED)))
    units = [unit for job in jobs for unit in job.units()]
    assert len(set(units)) == len(units) == 4000
    assert units[:2] == ["bedroom_0/main/view_0", "bedroom_0/main/view_1"]


def test_a_plan_as_text_is_the_same_plan(tmp_path: Path) -> None:
    jobs = planned(tmp_path, GENERATED)[:40]
    assert list(jobs_of(lines(jobs))) == jobs


def test_rooms_that_are_added_at_the_end_move_no_other(tmp_path: Path) -> None:
    more = planned(tmp_path, GENERATED.replace("1000", "1200"))
    assert more[:2000] == planned(tmp_path, GENERATED)


def test_every_number_is_drawn_from_the_seed(tmp_path: Path) -> None:
    jobs, others = planned(tmp_path, GENERATED), planned(tmp_path, GENERATED.replace("7", "8"))
    assert len({job.room.source["seed"] for job in jobs}) == 1000
    assert len({job.seed for job in jobs}) == len({job.key for job in jobs}) == 2000
    assert not {job.key for job in jobs} & {job.key for job in others}


@pytest.mark.parametrize(
    "change",
    ["budget: {samples: 3}", "views: {count: 3}", "channels: [depth]", "rendering: {bounces: 1}"],
)
def test_what_determines_pixels_is_in_the_key(tmp_path: Path, change: str) -> None:
    before = planned(tmp_path, GENERATED)[0]
    section = change.partition(":")[0]
    kept = "".join(f"{line}\n" for line in GENERATED.splitlines() if not line.startswith(section))
    after = planned(tmp_path, f"{kept}{change}\n")[0]
    assert after.key != before.key


def test_what_determines_none_is_not(tmp_path: Path) -> None:
    before = planned(tmp_path, GENERATED)[0]
    after = planned(tmp_path, f"{GENERATED}retries: 4\nname: other\noutputs: [{{as: nerf}}]\n")[0]
    assert after == before


def test_splits_have_their_shares_in_every_run_of_rooms(tmp_path: Path) -> None:
    rooms = [job.room for job in planned(tmp_path, GENERATED) if job.variant == "main"]
    for start in (0, 333, 900):
        found = Counter(room.split for room in islice(rooms, start, start + 100))
        assert abs(found["train"] - 80) <= 2 and abs(found["val"] - 10) <= 2
    alone = planned(tmp_path, GENERATED + "splits: {train: 0, val: 0, test: 1}\n")
    assert {job.room.split for job in alone} == {"test"}


def test_a_description_is_in_the_key_by_its_content(source: Path) -> None:
    before = list(plan_jobs(load_dataset(source)))
    room = source.parent / "good" / "room.yaml"
    room.write_text(room.read_text().replace("seed: 3", "seed: 4"))
    after = list(plan_jobs(load_dataset(source)))
    assert [a.key == b.key for a, b in zip(after, before, strict=True)] == [False] * 2 + [True] * 2
    room.unlink()
    with pytest.raises(InputError, match="no such file"):
        list(plan_jobs(load_dataset(source)))


def test_no_two_rooms_have_one_name(tmp_path: Path) -> None:
    files = ["a.yaml", "b/a.yaml", "a_again_2.yaml", "c/a.yaml", "d/a_again_2.yaml"]
    for file in files:
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).write_text("room: office\n")
    names = [job.room.name for job in planned(tmp_path, f"rooms: [{{files: {files}}}]\n")]
    assert names[:2] == ["room_a", "room_a_again_2"]
    assert len(set(names)) == len(files)


def test_the_example_is_one() -> None:
    example = Path(__file__).parents[2] / "examples" / "dataset.yaml"
    assert sum(1 for _ in lines(plan_jobs(load_dataset(example)))) == 300


def test_mistakes_are_told_with_their_places(tmp_path: Path) -> None:
    (tmp_path / "dataset.yaml").write_text(
        "seeed: 2\nrooms:\n  - {types: [living_rom], count: 0}\n  - files: []\n"
        "variants: [main, main]\nbudget: {samples: 3, error: 0.1}\nsplits: {train: 0.9}\n"
    )
    with pytest.raises(DescriptionError) as caught:
        load_dataset(tmp_path / "dataset.yaml")
    said = str(caught.value)
    for fragment in (
        "7 mistakes",
        ":1:1: seeed: unknown key (did you mean 'seed'?)",
        ":3:14: rooms[0].types[0]: found 'living_rom' (did you mean 'living_room'?)",
        ":3:34: rooms[0].count: expected at least 1",
        ":4:12: rooms[1].files",
        ":5:18: variants[1]: main is given twice",
        ":6:29: budget.error: only one of these",
        ":7:9: splits: train, val and test must add up to 1, got 1.1",
    ):
        assert fragment in said


def test_an_unknown_renderer_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no renderer is named"):
        planned(tmp_path, GENERATED + "rendering: {renderer: nonsense}\n")


def test_files_that_a_room_names_are_in_the_key(tmp_path: Path) -> None:
    """Of that room alone, and only where its room.yaml is one."""
    room = "room: office\nlayout: {polygon: [[0, 0], [4, 0], [4, 3], [0, 3]]}\n"
    texts = {"plain": room, "wrong": f"{room}lights: {{environment: {{fil: sky.exr}}}}\n"}
    texts["outside"] = f"{room}lights: {{environment: {{file: sky.exr}}}}\n"
    for name, text in texts.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / "room.yaml").write_text(text)
    dataset = f"rooms: [{{files: [{', '.join(f'{name}/room.yaml' for name in texts)}]}}]\n"
    keys = []
    for content in (None, b"one", b"two", b"one"):
        if content is not None:
            (tmp_path / "outside" / "sky.exr").write_bytes(content)
        keys.append([job.key for job in planned(tmp_path, dataset)])
    plain, wrong, outside = zip(*keys, strict=True)
    assert len(set(plain)) == len(set(wrong)) == 1
    assert len(set(outside)) == 3
    assert outside[1] == outside[3]


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
    room = room_of({"lights": lights, "furniture": {"objects": objects}})
    found = [with_other_lights(room, seed).lights for seed in (1, 2)]
    assert found[0].environment != found[1].environment != room.lights.environment
    assert all(lights.lamps["a"].on for lights in found)
    given = {key: value for key, value in environment.items() if key in ("from", "file")}
    assert {
        k: v for k, v in found[0].environment.model_dump(by_alias=True).items() if k in given
    } == given


def test_lamps_of_which_nobody_says_how_bright_they_are_are_other_too() -> None:
    objects = [{"category": "floor_lamp", "name": "a", "at": [1, 1]}]
    room = room_of({"furniture": {"objects": objects}})
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


def test_the_code_of_every_step_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    monkeypatch.setattr(plan, "code_digest", lambda *modules: asked.extend(modules))
    code_of.__wrapped__("preview")
    steps = [name for name in asked if name.startswith("openrooms_usd.steps.")]
    assert [name for name in STEPS if f"openrooms_usd.steps.{name}.step" not in steps] == []
    assert [name for name in steps if find_spec(name) is None] == []
