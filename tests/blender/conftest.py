"""Blender in a process of its own, and rooms for it."""

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from openrooms_usd.composing import compose_room
from openrooms_usd.demo import write_starter
from openrooms_usd.generation import generate, write

ROOT = Path(__file__).parents[2]
Blender = Callable[..., Any]


@pytest.fixture(scope="session")
def blender(tmp_path_factory: pytest.TempPathFactory) -> Blender:
    """Runs a job of `work.py` in Blender and gives what it has seen."""
    python = os.environ.get("ORUSD_BLENDER_PYTHON", str(ROOT / ".venv-blender/bin/python"))
    if not Path(python).is_file():
        pytest.skip("Blender is missing (.ci/install-blender, ORUSD_BLENDER_PYTHON)")
    folder = tmp_path_factory.mktemp("blender")

    def run(job: str, scene: Path, **what: Any) -> Any:
        report = folder / "report.json"
        report.unlink(missing_ok=True)
        told = {"job": job, "scene": str(scene), "report": str(report), **what}
        (folder / "job.json").write_text(json.dumps(told))
        command = [python, "-P", str(Path(__file__).parent / "work.py"), str(folder / "job.json")]
        environment = {key: x for key, x in os.environ.items() if not key.startswith("PYTHON")}
        done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=300)
        assert done.returncode == 0 and report.is_file(), done.stdout + done.stderr
        return json.loads(report.read_text())

    return run


@pytest.fixture(scope="session")
def example(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bundled example's description, composed into ``out`` beside it."""
    folder = tmp_path_factory.mktemp("example")
    described = write_starter(folder)[0]
    compose_room(described, folder / "out", workers=2)
    return folder / "out"


@pytest.fixture(scope="session")
def bedroom(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bedroom that nobody has drawn."""
    folder = tmp_path_factory.mktemp("bedroom")
    (folder / "room.yaml").write_text(write(generate("bedroom", 3)))
    compose_room(folder / "room.yaml", folder / "out", workers=2)
    return folder / "out"
