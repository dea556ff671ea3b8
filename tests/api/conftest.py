"""A tiny room, composed and rendered once through the front door."""

from pathlib import Path

import pytest

import openrooms_usd as ou
from tests.api.tiny import CHANNELS, ROOM


@pytest.fixture(scope="package")
def scene(tmp_path_factory: pytest.TempPathFactory) -> ou.Scene:
    """`ROOM`, composed; copy its folder to change it."""
    return ou.compose(ROOM, tmp_path_factory.mktemp("api") / "room")


@pytest.fixture(scope="package")
def rendered(vectorized: str, scene: ou.Scene) -> ou.Render:
    """Both views of it with channels of every kind."""
    return ou.render(scene, channels=CHANNELS, samples=1, grid=(4, 3))


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder that is the current one."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
