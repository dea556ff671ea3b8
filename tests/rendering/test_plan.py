"""What a run shall render, and what is refused."""

import numpy as np
import pytest
from pxr import Usd

from openrooms_usd.channels import CHANNELS
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError
from openrooms_usd.rendering import context
from openrooms_usd.rendering.opening import open_for_rendering
from openrooms_usd.rendering.plan import choose_cameras, choose_channels, view_names

CAMERAS = ("/World/A/left", "/World/B/left", "/World/B/Right", "/World/Cameras/door")


def test_short_names_where_they_are_the_only_ones():
    assert view_names(CAMERAS) == {
        "/World/A/left": "World.A.left",
        "/World/B/left": "World.B.left",
        "/World/B/Right": "Right",
        "/World/Cameras/door": "door",
    }
    assert len({name.casefold() for name in view_names(("/a/Cam", "/b/cam")).values()}) == 2


def test_names_stay_apart_whatever_the_paths():
    # With underscores the first two would be the same, and the third has that name already.
    paths = ("/A/b/c", "/A_b/c", "/x/A_b_c", "/y/c")
    assert len({name.casefold() for name in view_names(paths).values()}) == len(paths)


@pytest.mark.parametrize("text", ["door", "/World/Cameras/door"])
def test_a_camera_by_name_or_path(text):
    assert choose_cameras([text], CAMERAS) == {"door": "/World/Cameras/door"}


def test_all_cameras_none_and_the_framing_one():
    assert list(choose_cameras((), CAMERAS).values()) == list(CAMERAS)
    assert choose_cameras((), ()) == {"framing": None}


def test_spare_cameras_are_drawn_where_somebody_asks():
    spares = ("/World/Cameras/spare_0", "/World/Cameras/spare_1")
    others = ("/World/Cameras/spare_room", "/Mine/spare_0")
    assert list(choose_cameras((), spares + others).values()) == list(others)
    assert list(choose_cameras((), spares + others, spares=True).values()) == [*spares, *others]
    assert choose_cameras(["spare_1"], spares + others) == {"spare_1": spares[1]}
    assert list(choose_cameras((), spares).values()) == list(spares)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("dor", "did you mean 'door'"),
        ("/World/Cameras/dor", "did you mean '/World/Cameras/door'"),
        ("left", "give a path: /World/A/left, /World/B/left"),
        ("", "there are: "),
    ],
)
def test_wrong_cameras(text, said):
    with pytest.raises(InputError) as caught:
        choose_cameras([text], CAMERAS)
    assert said in str(caught.value)


def test_a_camera_where_there_is_none():
    with pytest.raises(InputError, match="no camera is named 'left'"):
        choose_cameras(["left"], ())


def test_channels_in_the_order_of_the_table():
    assert choose_channels(["valid", "depth", "valid"], tuple(CHANNELS)) == ("depth", "valid")
    assert choose_channels(None, ("valid", "depth", "unheard_of")) == ("depth", "valid")


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["dept"], "did you mean 'depth'"),
        (["position"], "this one gives: depth, valid"),
        ([], "no channel is requested"),
    ],
)
def test_wrong_channels(names, said):
    with pytest.raises(InputError) as caught:
        choose_channels(names, ("depth", "valid"))
    assert said in str(caught.value)


def test_samples_are_64_unless_something_else_is_said():
    assert RenderSettings().samples_or_default == 64
    assert RenderSettings(samples=3).samples_or_default == 3
    assert RenderSettings(error=0.1).samples_or_default is None
    assert RenderSettings(seconds=2.0).samples_or_default is None


@pytest.mark.parametrize(
    "given",
    [
        {"samples": 0},
        {"samples": -1},
        {"samples": 10**9},
        {"error": float("nan")},
        {"error": 0.0},
        {"seconds": float("inf")},
        {"seconds": -1.0},
        {"seed": -1},
        {"seed": 2**40},
        {"seed": "a"},
        {"samples": 2.5},
        {"samples": "many"},
        {"error": "small"},
        {"bounces": -1},
        {"bounces": 10**6},
        {"resolution": (0, 10)},
        {"resolution": (-3, 10)},
        {"resolution": (10**9, 1)},
        {"resolution": (30000, 30000)},
        {"samples": 3, "error": 0.1},
        {"samples": 3, "error": 0.1, "seconds": 2.0},
    ],
)
def test_absurd_numbers(given):
    with pytest.raises(InputError):
        RenderSettings(**given)


def test_the_size_of_the_stage_is_checked_too(tmp_path, monkeypatch):
    monkeypatch.setattr(context, "stage_resolution", lambda stage: (0, 480))
    stage = Usd.Stage.CreateInMemory()
    with pytest.raises(InputError, match="width"):
        open_for_rendering(stage, RenderSettings(renderer="preview"))


def test_numbers_of_numpy_become_pythons_own():
    given = {"seed": np.int64(3), "bounces": np.int8(2), "resolution": (np.int64(8), 6)}
    found = RenderSettings(seconds=np.float32(0.5), **given)
    rows = (found.seed, found.bounces, *found.resolution, found.seconds)
    assert rows == (3, 2, 8, 6, 0.5)
    assert {type(value) for value in rows} == {int, float}


def test_the_page_of_settings_is_what_the_record_says():
    from docs.render_settings import PAGE, page

    assert PAGE.read_text(encoding="utf-8") == page(), "run: python -m docs.render_settings"
