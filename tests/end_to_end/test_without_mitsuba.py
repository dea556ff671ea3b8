"""Where Mitsuba is not installed rooms are composed and checked, and rendering says what lacks."""

import json
import subprocess
import sysconfig
import venv
from pathlib import Path

import pytest

MAIN = "from openrooms_usd.cli import main; main()"


@pytest.fixture
def python(tmp_path: Path) -> Path:
    """An environment with all that is installed here but Mitsuba and Dr.Jit."""
    folder = tmp_path / "environment"
    venv.create(folder, symlinks=True)
    packages = next(folder.glob("[lL]ib*/**/site-packages"))
    for key in ("purelib", "platlib"):
        for item in Path(sysconfig.get_paths()[key]).iterdir():
            left_out = item.name.lower().startswith(("mitsuba", "drjit"))
            if not left_out and not (packages / item.name).exists():
                (packages / item.name).symlink_to(item)
    return next(folder.glob("[bB]*/python*"))


def orusd(python: Path, cwd: Path, *words: str) -> subprocess.CompletedProcess[str]:
    command = [str(python), "-W", "error", "-c", MAIN, *words]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True)


@pytest.mark.slow
def test_only_rendering_needs_mitsuba(python: Path, tmp_path: Path) -> None:
    missing = subprocess.run([str(python), "-c", "import mitsuba"], capture_output=True, text=True)
    assert "No module named 'mitsuba'" in missing.stderr
    (tmp_path / "room.yaml").write_text("room: office\n")
    done = orusd(python, tmp_path, "compose", "room.yaml", "-o", "out")
    assert done.returncode == 0, done.stderr
    done = orusd(python, tmp_path, "validate", "--json", "out/scene.usda")
    assert done.returncode == 0, done.stderr
    # The room is empty, and dark.
    assert [found["code"] for found in json.loads(done.stdout)["findings"]] == ["light"]
    for variant in ("auto", "scalar"):
        words = ("render", "out/scene.usda", "-o", "pictures", "--variant", variant)
        done = orusd(python, tmp_path, *words)
        assert "Traceback" not in done.stderr
        assert done.returncode == 6, done.stderr
        assert "mitsuba" in done.stderr and "pip install mitsuba" in done.stderr
        assert not (tmp_path / "pictures").exists()
    done = orusd(python, tmp_path, "convert", "out/scene.usda", "scene.xml")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "scene.xml").is_file(), "writing a file needs no renderer"
    done = orusd(python, tmp_path, "doctor")
    assert "Traceback" not in done.stderr
    assert "not usable: the renderer needs the package 'mitsuba'" in done.stdout
