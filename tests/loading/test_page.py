"""What docs/loading.md shows runs as it stands."""

import re
from pathlib import Path
from types import ModuleType

import pytest

PAGE = Path(__file__).parents[2] / "docs/loading.md"


@pytest.mark.slow
def test_the_python_of_the_page_runs_in_order(
    dataset: Path,
    torch: ModuleType,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "homes").symlink_to(dataset)
    monkeypatch.chdir(tmp_path)
    shown = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)
    names: dict[str, object] = {}
    for block in shown:
        exec(block, names)
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("(192, 256, 3)")
    assert (
        said[-1] == "torch.Size([2, 3, 192, 256]) torch.Size([2, 192, 256]) torch.Size([2, 3, 3])"
    )
