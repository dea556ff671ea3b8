"""A look at views that were made so that one thing is wrong with each."""

import json

import numpy as np
import pytest

from openrooms_usd.dataset.quality import assess, camera_faults
from openrooms_usd.rendering.contract import Image, View

SHAPE = (12, 16)


def view(**changed: object) -> View:
    """A sound view, with some channels in place of its own; None leaves one out."""
    channels: dict[str, object] = {
        "radiance": np.full((*SHAPE, 3), 200.0),
        "depth": np.full((*SHAPE, 1), 2.0),
        "valid": np.ones((*SHAPE, 1)),
        "instance": np.arange(SHAPE[0] * SHAPE[1]).reshape(*SHAPE, 1) % 5,
    } | changed
    images = {
        name: Image(np.asarray(pixels, np.float32), 4, 0.0, 0.1, robust_error=0.05)
        for name, pixels in channels.items()
        if pixels is not None
    }
    return View("/c", SHAPE[1], SHAPE[0], np.eye(3), np.eye(4), 1e-3, images)


def one_near() -> np.ndarray:
    depth = np.full((*SHAPE, 1), 2.0)
    depth[0, 0] = 0.01
    return depth


@pytest.mark.parametrize(
    ("changed", "fault"),
    [
        ({"radiance": np.full((*SHAPE, 3), 0.01)}, "it is dark"),
        ({"radiance": np.full((*SHAPE, 3), 3e3)}, "most of it is brighter than white"),
        ({"depth": one_near()}, "the camera is in something"),
        ({"depth": np.full((*SHAPE, 1), 0.2)}, "something stands in front of the camera"),
        ({"valid": np.zeros((*SHAPE, 1))}, "it is empty"),
        ({"instance": np.ones((*SHAPE, 1))}, "it shows one thing alone"),
        ({"normal": np.full((*SHAPE, 3), np.nan)}, "not all numbers are finite in normal"),
    ],
)
def test_each_fault_is_found_alone(changed: dict[str, np.ndarray], fault: str) -> None:
    assert assess(view(**changed))["faults"] == [fault]


def test_what_is_no_number_is_no_measure() -> None:
    holed = np.full((*SHAPE, 3), 200.0)
    holed[3, 4] = np.nan
    found = assess(view(radiance=holed))
    assert found["faults"] == ["not all numbers are finite in radiance"]
    json.dumps(found, allow_nan=False)


def test_a_sound_view_has_none() -> None:
    found = assess(view(), error=0.1)
    assert found["faults"] == []
    assert found["measures"] == {
        "bright_nits": 200.0,
        "blown_share": 0.0,
        "error": 0.05,
        "seen_share": 1.0,
        "nearest_m": 2.0,
        "close_share": 0.0,
        "instances": 4,
    }


def test_noise_is_held_against_the_budget_alone() -> None:
    assert assess(view(), error=0.01)["faults"] == ["it is noisier than asked for"]


def test_channels_that_are_not_asked_for_are_not_missed() -> None:
    found = assess(view(radiance=None, depth=None, valid=None, instance=None))
    assert found == {"measures": {}, "faults": []}


def test_a_channel_that_is_not_there_or_empty_is_missed() -> None:
    nothing = np.zeros((*SHAPE, 3))
    black = view(normal=nothing, base_color=nothing)
    found = assess(black, asked=("normal", "base_color", "part"))
    # Black things there are; surfaces without a normal there are not.
    assert found["faults"] == ["nothing is in normal, part"]
    lit = view(irradiance=nothing)
    assert assess(lit, asked=("irradiance",))["faults"] == ["nothing is in irradiance"]
    dark = view(irradiance=nothing, radiance=nothing)
    assert assess(dark, asked=("irradiance",))["faults"] == ["it is dark"]
    # Outside there are no normals.
    empty = view(valid=np.zeros((*SHAPE, 1)), normal=nothing)
    assert assess(empty, asked=("normal",))["faults"] == ["it is empty"]


def test_faults_of_light_are_not_the_cameras() -> None:
    dark = view(radiance=np.zeros((*SHAPE, 3)), depth=one_near())
    assert camera_faults(dark) == ["the camera is in something"]
