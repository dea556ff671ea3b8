"""The synthetic render that the tests of this folder share."""

import shutil
from pathlib import Path

import pytest

from openrooms_usd.rendering.reading import RenderedScene
from tests.openrooms.synthetic import make_render


@pytest.fixture(scope="session")
def render(tmp_path_factory: pytest.TempPathFactory) -> RenderedScene:
    """Two views of 64x48, hemispheres on 16x12 points."""
    return make_render(tmp_path_factory.mktemp("renders") / "day")


@pytest.fixture
def day(render: RenderedScene, tmp_path: Path) -> Path:
    """A copy of the render, to be changed."""
    return Path(shutil.copytree(render.folder, tmp_path / "day"))
