"""Names that no file system takes are refused in a sentence by every command."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from openrooms_usd.cli import orusd
from openrooms_usd.errors import OrusdError

READERS = (
    ("validate", "*.usda"),
    ("validate", "*.usdz"),
    ("edit", "orphans", "*"),
    ("edit", "import-changes", "*/scene.usda"),
    ("edit", "import-changes", "scene.usda", "--from", "*.usdc"),
    ("compose", "*.yaml", "-o", "out"),
    ("convert", "*.usda", "out"),
    ("simulate", "*.usda"),
    ("labels", "*", "-o", "out.json"),
    ("labels", "*", "-o", "out.json"),
    ("relight", "*", "-o", "out", "--light", "a=1"),
    ("dataset", "write", "*", "-o", "out"),
    ("import", "boxes", "*.csv", "-o", "out"),
    ("import", "scan", "*.ply", "-o", "out"),
    ("import", "scannet", "*", "-o", "out"),
    ("import", "sunrgbd", "*", "-o", "out"),
    ("import", "arkitscenes", "*", "-o", "out"),
)


@pytest.mark.parametrize(
    "name", ["x" * 300, "x/" * 2100, "circle/x"], ids=["long", "deep", "circle"]
)
@pytest.mark.parametrize("words", READERS, ids=" ".join)
def test_a_source_that_cannot_be_is_refused(
    words: tuple[str, ...], name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "circle").symlink_to("circle")
    given = [word.replace("*", name) for word in words]
    done = CliRunner().invoke(orusd, given, standalone_mode=False)
    assert isinstance(done.exception, OrusdError), done.exception
    assert [path.name for path in tmp_path.iterdir()] == ["circle"]


@pytest.mark.parametrize("name", ["x" * 300, "x/" * 2100, "circle/x", "file/x"])
def test_an_output_that_cannot_be_is_refused(name: str, tmp_path: Path) -> None:
    from openrooms_usd.rendering.folder import check_space, check_writable

    (tmp_path / "circle").symlink_to("circle")
    (tmp_path / "file").write_text("somebody's own")
    with pytest.raises(OrusdError):
        check_writable(tmp_path / name)
    if "file" not in name:
        with pytest.raises(OrusdError):
            check_space(tmp_path / name, 1 << 60)
    assert (tmp_path / "file").read_text() == "somebody's own"
