"""Every tutorial runs from its first line to its last, and says what it shows."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs/tutorials").glob("*.md"))
BLOCK = re.compile(r'^```(\w+)(?: title="([^"]+)")?\n(.*?)^```$', re.MULTILINE | re.DOTALL)
DOWNLOAD = re.compile(r"\]\(([\w.]+\.json)\)")
NUMBER = re.compile(r"\d+(\.\d+)?")


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_tutorial_runs_from_its_first_line_to_its_last(
    page: Path, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    """In an empty folder; numbers of the output may differ, words may not."""
    text = page.read_text(encoding="utf-8")
    folder = tmp_path / "empty"
    folder.mkdir()
    for name in DOWNLOAD.findall(text):
        shutil.copy(page.parent / name, folder)
    environment = dict(os.environ)
    found = [str(Path(sys.executable).parent), environment["PATH"]]
    if "$ blender " in text:
        found.insert(0, str(blender(tmp_path / "bin")))
    if "import torch" in text:
        torch = request.getfixturevalue("torch_packages")
        environment["PYTHONPATH"] = os.pathsep.join([environment.get("PYTHONPATH", ""), torch])
    environment["PATH"] = os.pathsep.join(found)

    for language, title, block in BLOCK.findall(text):
        if title:
            (folder / title).write_text(block, encoding="utf-8")
        for command, shown in commands(block) if language == "console" else []:
            done = subprocess.run(
                ["bash", "-c", command], cwd=folder, env=environment, capture_output=True, text=True
            )
            assert done.returncode == 0, f"$ {command}\n{done.stdout}{done.stderr}"
            said = [plain(line) for line in (done.stdout + done.stderr).splitlines()]
            missing = [line for line in shown if not any(plain(line) in one for one in said)]
            assert missing == [], f"$ {command}\n{done.stdout}{done.stderr}"


def commands(block: str) -> list[tuple[str, list[str]]]:
    """The commands of a block, each with the lines of output that follow it."""
    parts = [part.strip().splitlines() for part in re.split(r"^\$ ", block, flags=re.MULTILINE)]
    return [(command, shown) for command, *shown in filter(None, parts)]


def plain(line: str) -> str:
    """A line without its numbers and the width of its columns."""
    return NUMBER.sub("#", " ".join(line.split()))


def blender(folder: Path) -> Path:
    """A folder with ``blender``, which runs a script as Blender does: in the module ``bpy``."""
    python = os.environ.get("ORUSD_BLENDER_PYTHON", str(ROOT / ".venv-blender/bin/python"))
    if not Path(python).is_file():
        pytest.skip("Blender is missing (.ci/install-blender, ORUSD_BLENDER_PYTHON)")
    folder.mkdir()
    script = folder / "blender"
    script.write_text(f'#!/bin/sh\nexec "{python}" -I "$3"\n')
    script.chmod(0o755)
    return folder


def test_tutorials_say_what_they_give_install_and_show() -> None:
    """Each begins with what is there at its end and how long that takes."""
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        assert re.match(r"# .+\n\n(At the end .+ It takes about \w+ minutes\.)\n", text), page.name
        assert re.search(r"^## Install.*\n\n```bash\npip install ", text, re.MULTILINE), page.name
        assert "\n## Next\n" in text, page.name
