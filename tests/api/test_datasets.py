"""Datasets from Python: the same plan and the same run as by the command."""

from pathlib import Path

import pytest

import openrooms_usd as ou

DATASET = """\
rooms: [{files: [one/room.yaml, two/room.yaml]}]
views: {count: 2}
rendering: {renderer: preview}
channels: [depth]
retries: 0
"""


def test_a_plan_and_what_became_of_it(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "room.yaml").write_text("room: nowhere\n")
    file = tmp_path / "dataset.yaml"
    file.write_text(DATASET)
    jobs = list(ou.plan_dataset(file))
    assert [job.name for job in jobs] == ["room_one/main", "room_two/main"]
    seen: list[str] = []
    done = ou.run_dataset(file, tmp_path / "out", progress=lambda name, _: seen.append(name))
    assert (done.made, done.kept) == (0, 0)
    assert sorted(done.failed) == sorted(unit for job in jobs for unit in job.units()) == seen
    assert all("nowhere" in reason for reason in done.failed.values())


@pytest.mark.parametrize(
    ("wrong", "said"),
    [({"executor": "locl"}, "no executor is named"), ({"options": {"cpus": "1"}}, "no option")],
)
def test_what_is_wrong_is_named(tmp_path: Path, wrong: dict[str, object], said: str) -> None:
    (tmp_path / "dataset.yaml").write_text("rooms: [{count: 1}]\n")
    with pytest.raises(ou.OrusdError, match=said):
        ou.run_dataset(tmp_path / "dataset.yaml", tmp_path / "out", **wrong)  # type: ignore[arg-type]
