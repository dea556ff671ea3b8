"""A user's own materials go through room.yaml into the picture, and the room outlives their files.

The maps have one value each, so that what the pixels must hold is known: sRGB 188 is 0.503 in the
scene, and 1 - glossiness is roughness.
"""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.composing import compose_room
from openrooms_usd.library.pictures import write_png

ROOM = """
layout: {polygon: [[0, 0], [3, 0], [3, 3], [0, 3]]}
materials:
  floor: {file: ./own/Bricks001, size: 1 m}
  walls: {file: ./own/wall.mtlx}
cameras:
  views: [{name: down, eye: [0.5, 0.5, 1.6], target: [2.2, 2.2, 0.6]}]
"""
WALL = """<?xml version="1.0"?><materialx version="1.38" colorspace="lin_rec709">
<standard_surface name="S" type="surfaceshader">
<input name="base_color" type="color3" value="0.2, 0.4, 0.6"/>
<input name="base" type="float" value="1"/>
<input name="specular_roughness" type="float" value="0.7"/></standard_surface>
<surfacematerial name="Blue" type="material">
<input name="surfaceshader" type="surfaceshader" nodename="S"/></surfacematerial></materialx>"""


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory, show_once: Any) -> Any:
    folder = tmp_path_factory.mktemp("own")
    home = folder / "own" / "Bricks001"
    home.mkdir(parents=True)
    even = np.full((4, 4, 3), 255, np.uint8)
    write_png(home / "Bricks001_1K_Color.png", even // 255 * np.uint8(188), is_color=True)
    write_png(home / "Bricks001_1K_Gloss.png", even // 255 * np.uint8(51), is_color=False)
    (home / "LICENSE").write_text("CC0-1.0")
    (folder / "own" / "wall.mtlx").write_text(WALL)
    (folder / "room.yaml").write_text(ROOM)
    scene = compose_room(folder / "room.yaml", folder / "out").scene
    shutil.rmtree(folder / "own")
    (folder / "out").rename(folder / "elsewhere")
    return show_once(folder / "elsewhere" / Path(scene).name, "own")


def of(shown: Any, channel: str, where: str) -> np.ndarray:
    """The distinct values of a channel on what has a name in its prim's path."""
    parts = shown.names("down", "part")
    on = np.char.find(np.char.lower(parts), where) >= 0
    assert on.sum() > 20
    return np.unique(shown["down"][channel][on], axis=0)


def test_maps_of_a_folder_arrive_with_their_colour_space_and_meaning(shown: Any) -> None:
    np.testing.assert_allclose(of(shown, "base_color", "floor"), [[0.503] * 3], atol=2e-3)
    np.testing.assert_allclose(of(shown, "roughness", "floor"), [[1 - 51 / 255]], atol=2e-3)


def test_a_materialx_surface_arrives(shown: Any) -> None:
    np.testing.assert_allclose(of(shown, "base_color", "wall"), [[0.2, 0.4, 0.6]], atol=1e-3)
    np.testing.assert_allclose(of(shown, "roughness", "wall"), [[0.7]], atol=1e-3)
