"""Datasets from Python: the same plan and the same run as by the command."""

from pathlib import Path

import pytest

import openrooms_usd as ou
from openrooms_usd.dataset.status import status_of
from openrooms_usd.errors import RenderError

DATASET = """\
rooms: [{files: [one/room.yaml, two/room.yaml]}]
views: {count: 2}
rendering: {renderer: preview}
channels: [depth]
retries: 0
"""


def test_a_run_all_of_whose_views_fail_is_an_error(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "room.yaml").write_text("room: nowhere\n")
    file = tmp_path / "dataset.yaml"
    file.write_text(DATASET)
    jobs = list(ou.plan_dataset(file))
    assert [job.name for job in jobs] == ["room_one/main", "room_two/main"]
    seen: list[str] = []
    with pytest.raises(
        RenderError, match=r"all 4 views failed; room_one/main/view_0: (?s:.*)nowhere"
    ):
        ou.run_dataset(file, tmp_path / "out", progress=lambda name, _: seen.append(name))
    assert sorted(unit for job in jobs for unit in job.units()) == seen
    assert len(status_of(tmp_path / "out").failures) == 4


@pytest.mark.parametrize(
    ("wrong", "said"),
    [({"executor": "locl"}, "no executor is named"), ({"options": {"cpus": "1"}}, "no option")],
)
def test_what_is_wrong_is_named(tmp_path: Path, wrong: dict[str, object], said: str) -> None:
    (tmp_path / "dataset.yaml").write_text("rooms: [{count: 1}]\n")
    with pytest.raises(ou.OrusdError, match=said):
        ou.run_dataset(tmp_path / "dataset.yaml", tmp_path / "out", **wrong)  # type: ignore[arg-type]
