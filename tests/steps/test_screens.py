"""Screens that are on: where their light stands, what it shows, whose pixels it is."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdLux

from openrooms_usd import names
from openrooms_usd.errors import DescriptionError
from openrooms_usd.library.styles.displays import SHOWN, picture
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd.light.lights import RectLight, read_lights
from tests.steps.test_lights import compose, room

TELEVISION = {
    "name": "set",
    "category": "television",
    "at": [2, 3],
    "yaw": 90.0,
    "size": [1.14, 0.23, 0.71],
    "style": "feet",
}


def screens(stage: Usd.Stage) -> list[RectLight]:
    return [light for light in read_lights(stage) if isinstance(light, RectLight)]


def composed(folder: Path, *objects: dict[str, Any], **wanted: Any) -> tuple[Usd.Stage, list[str]]:
    return compose(folder, room([*objects], screens=wanted))


def test_a_screen_shines_to_the_front_of_its_thing(tmp_path: Path) -> None:
    stage, notes = composed(tmp_path, TELEVISION, set={"nits": 250})
    assert notes == []
    [light] = screens(stage)
    assert light.path == f"{names.SCREENS}/set"
    frame = light.world_from_light
    # A thing faces along its -Y, which a yaw of 90 degrees turns to +X; light leaves along -Z.
    np.testing.assert_allclose(-frame[:3, 2], [1, 0, 0], atol=1e-6)
    np.testing.assert_allclose(frame[:3, 1], [0, 0, 1], atol=1e-6)
    np.testing.assert_allclose(np.linalg.det(frame[:3, :3]), 1.0, atol=1e-6)
    assert 1.05 < light.width < 1.14
    assert frame[1, 3] == pytest.approx(3.0, abs=1e-3)
    np.testing.assert_allclose(light.radiance, 250.0, rtol=1e-6)
    assert light.texture is not None
    assert light.losses == ()


def test_its_pixels_are_those_of_the_thing(tmp_path: Path) -> None:
    stage, _ = composed(tmp_path, TELEVISION, set={})
    legend = translate(stage).legend
    assert f"{names.FURNITURE}/set" in legend.instance.values()
    assert not [path for path in legend.instance.values() if path.startswith(names.LIGHTS)]


def test_screens_are_off_unless_listed_and_bent_ones_stay_dark(tmp_path: Path) -> None:
    stage, _ = composed(tmp_path / "off", TELEVISION, set={"on": False})
    assert screens(stage) == []
    tube = {**TELEVISION, "size": [0.6, 0.48, 0.64], "style": "tube"}
    stage, notes = composed(tmp_path / "tube", tube, set={})
    assert screens(stage) == []
    assert "curved" in notes[0]
    with pytest.raises(DescriptionError, match="no screen 'sett'"):
        composed(tmp_path / "none", TELEVISION, sett={})


def test_the_same_seed_shows_the_same(tmp_path: Path) -> None:
    files = []
    for number in range(2):
        stage, _ = composed(tmp_path / str(number), TELEVISION, set={})
        prim = UsdLux.RectLight(stage.GetPrimAtPath(f"{names.SCREENS}/set"))
        files.append(Path(prim.GetTextureFileAttr().Get().resolvedPath).read_bytes())
    assert files[0] == files[1]


@pytest.mark.parametrize("shows", SHOWN)
def test_pictures_have_bright_and_dark_parts(shows: str) -> None:
    for seed in range(3):
        found = picture(shows, 1.6, np.random.default_rng(seed))
        assert found.shape == (240, 384, 3)
        levels = found.mean(axis=2)
        assert levels.std() > 20
        assert 30 < levels.mean() < 215
