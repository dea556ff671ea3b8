"""A synthetic render and what the adapter made of it, which the tests of this folder share."""

from pathlib import Path

import pytest

from openrooms_usd.rendering.datasets import DatasetOptions
from openrooms_usd.rendering.reading import RenderedScene
from orusd_nerf import NerfDataset
from tests.openrooms.synthetic import make_render


@pytest.fixture(scope="session")
def render(tmp_path_factory: pytest.TempPathFactory) -> RenderedScene:
    """Three views of 64x48 of the floor z = 0 and the wall y = 4, with a hole in it."""
    return make_render(tmp_path_factory.mktemp("renders") / "day", views=3)


@pytest.fixture(scope="session")
def dataset(render: RenderedScene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The dataset of that render."""
    root = tmp_path_factory.mktemp("nerf") / "data"
    NerfDataset().write([render], root, DatasetOptions())
    return root
