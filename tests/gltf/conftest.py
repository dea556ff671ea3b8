"""Exports, and the programs of others that look at them."""

import os
import shutil
import subprocess
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from pxr import Usd

from openrooms_usd.exporters import Report
from orusd_gltf import GltfExporter
from tests.gltf.reading import Glb, read

ROOT = Path(__file__).parents[2]
MODULES = Path(os.environ.get("ORUSD_NODE_MODULES", ROOT / ".node-gltf/node_modules"))

Export = Callable[..., tuple[Glb, Report]]


@pytest.fixture
def export(tmp_path: Path) -> Export:
    """Write a stage, and read the file again."""

    def run(stage: Usd.Stage, options: Mapping[str, Any] | None = None) -> tuple[Glb, Report]:
        report = GltfExporter().convert(stage, tmp_path / "made.glb", options or {})
        return read(tmp_path / "made.glb"), report

    return run


@pytest.fixture(scope="session")
def node() -> Callable[..., str]:
    """Runs a script in Node.js, where the packages of `.ci/install-gltf-validator` are."""
    if not shutil.which("node") or not (MODULES / "gltf-validator").is_dir():
        pytest.skip("the glTF validator is missing (.ci/install-gltf-validator)")

    def run(script: str, *arguments: Any) -> str:
        command = ["node", str(Path(__file__).parent / script), *map(str, arguments)]
        environment = os.environ | {"ORUSD_NODE_MODULES": str(MODULES)}
        done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=300)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    return run
