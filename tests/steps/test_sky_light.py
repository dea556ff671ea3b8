"""The sky of the lights step: what is stored, what it is named by, and what replaces what."""

import math
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from openrooms_usd import names
from openrooms_usd.description.room import Room
from openrooms_usd.library.surroundings.environments import horizontal_illuminance
from openrooms_usd.steps import runner
from openrooms_usd.steps.draft import drafting
from openrooms_usd.steps.layout.step import LayoutStep
from openrooms_usd.steps.lights.step import LightsStep
from openrooms_usd.usd.light.lights import DomeLight, read_lights
from openrooms_usd.usd.shading.textures import read_texture

WEIGHTS = np.array([0.2126, 0.7152, 0.0722])
MOMENT = {"from": "sky", "latitude": 48.1, "longitude": 11.6, "date": "2026-04-10", "time": "10:00"}


def stored(folder: Path, **changes: object) -> np.ndarray:
    """The panorama of a composed room."""
    room = Room.model_validate({"lights": {"environment": {**MOMENT, **changes}}})
    with drafting(folder) as draft:
        runner.create_edits(draft)
        for step in (LayoutStep(), LightsStep()):
            list(runner.run(step, room, folder, draft, "fingerprint", 1))
        runner.write_scene(draft)
    composed = Usd.Stage.Open(str(folder / names.SCENE))
    composed.Reload()
    [dome] = [light for light in read_lights(composed) if isinstance(light, DomeLight)]
    assert dome.texture is not None and dome.losses == ()
    assert dome.radiance @ WEIGHTS == pytest.approx(1.0)
    return read_texture(dome.texture)


def file(folder: Path) -> Path:
    [found] = (folder / "layers" / "lights").glob("sky_*.exr")
    return found


@pytest.mark.slow
def test_it_is_stored_in_nits_of_a_float(tmp_path: Path) -> None:
    pixels = stored(tmp_path)
    assert pixels.shape == (720, 1440, 3) and pixels.dtype == np.float32
    # The sun is far above what half a float can hold.
    assert pixels.max() > 1e8 and pixels.min() >= 0
    assert 40e3 < horizontal_illuminance(pixels) < 110e3


@pytest.mark.slow
def test_equal_moments_give_equal_bytes_and_names(tmp_path: Path) -> None:
    stored(tmp_path / "a", utc_offset=2)
    stored(tmp_path / "b", utc_offset=2)
    a, b = file(tmp_path / "a"), file(tmp_path / "b")
    assert a.name == b.name and a.read_bytes() == b.read_bytes()
    stored(tmp_path / "a", utc_offset=1)
    # Another moment is another file, and the old one is gone.
    assert file(tmp_path / "a").name != b.name


@pytest.mark.slow
def test_a_stated_illuminance_is_what_arrives(tmp_path: Path) -> None:
    pixels = stored(tmp_path, illuminance=5000, date="2026-12-24", time="23:00")
    assert horizontal_illuminance(pixels) == pytest.approx(5000, rel=1e-5)


@pytest.mark.slow
def test_the_dome_is_not_turned_but_the_picture_is(tmp_path: Path) -> None:
    """Turning north by a quarter moves the sun by a quarter of the columns to the left."""
    rows_columns = [
        np.unravel_index(int((stored(tmp_path, north=n) @ WEIGHTS).argmax()), (720, 1440))
        for n in (0, 90)
    ]
    (row, column), (turned_row, turned_column) = rows_columns
    assert abs(int(turned_row) - int(row)) <= 1
    step = (int(column) - int(turned_column)) % 1440
    assert step == pytest.approx(360, abs=2)


@pytest.mark.slow
def test_the_sun_stands_over_the_right_wall(tmp_path: Path) -> None:
    """At ten in April in Munich it is in the south-east: right and behind one who faces +Y."""
    pixels = stored(tmp_path, utc_offset="Europe/Berlin") @ WEIGHTS
    row, column = np.unravel_index(int(pixels.argmax()), pixels.shape)
    longitude = math.pi * (1 - 2 * (column + 0.5) / 1440)
    assert math.sin(longitude) > 0.5 and -math.cos(longitude) < -0.3
    assert 90 - 180 * (row + 0.5) / 720 == pytest.approx(35, abs=4)
