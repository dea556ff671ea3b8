"""`orusd annotate layout` on the command line."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from openrooms_usd.cli import orusd
from openrooms_usd.errors import OrusdError

PLAN = "layout:\n  polygon: [[0, 0], [5, 0], [5, 4], [0, 4]]\n"


def run(*words: object) -> Result:
    return CliRunner().invoke(orusd, ["annotate", "layout", *map(str, words)])


def test_a_plan_is_written_as_a_page(tmp_path: Path) -> None:
    (tmp_path / "room.yaml").write_text(PLAN)
    done = run(tmp_path / "room.yaml", "--export", tmp_path / "plan.html")
    assert (done.exit_code, done.output) == (0, f"wrote {tmp_path / 'plan.html'}\n")
    text = (tmp_path / "plan.html").read_text()
    assert '"corners":[[0.0,0.0],[5.0,0.0],[5.0,4.0],[0.0,4.0]]' in text
    assert str(tmp_path) not in text


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["scan.npz"], "needs a folder"),
        (["scan.npz", "-o", "out"], "unit"),
        (["room.yaml"], "did you mean 'height'"),
        (["none.yaml"], "none.yaml"),
    ],
)
def test_what_cannot_be_opened_is_told_and_nothing_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    np.savez("scan.npz", points=np.random.default_rng(0).uniform(0, 1e-4, (500, 3)))
    Path("room.yaml").write_text(PLAN + "  hieght: 3\n")
    done = run(*words, "--export", "plan.html")
    assert isinstance(done.exception, OrusdError) and said in str(done.exception)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["room.yaml", "scan.npz"]
