"""Times of day in the browser: bakes of a room at two times, and what lies between them."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import openrooms_usd as ou
from openrooms_usd.arrays import Array
from openrooms_usd.view import shell
from openrooms_usd.view.room import room_app
from tests.chromium import Page, needs_chromium, opened
from tests.conftest import SMALL_ROOM
from tests.view.conftest import Shown, lit_picture, slide, turn

pytestmark = [pytest.mark.slow, needs_chromium]


TIMES = {"noon": "12:00", "evening": "19:30"}
WINDOW = "window_0"


@pytest.fixture(scope="module")
def rooms(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, Path]]:
    """The stage and the coarse lightmaps of the small room at each time, one inside the other."""
    folder, home = tmp_path_factory.mktemp("times"), Path("out")
    found = {}
    for name, clock in TIMES.items():
        sky = f'from: sky, latitude: 50, longitude: 10, date: 2026-06-21, time: "{clock}"'
        text = f"{SMALL_ROOM}lights:\n  environment: {{{sky}, north: 200 deg}}\n"
        (folder / f"{name}.yaml").write_text(text)
        scene = Path(ou.compose(folder / f"{name}.yaml", folder / home))
        ou.bake(scene, folder / name, texel=0.25, samples=4)
        found[name] = scene, folder / name
        home = home / "later"
    return found


@pytest.fixture(scope="module")
def alone(rooms: dict[str, tuple[Path, Path]], shown: Shown) -> dict[str, tuple[Array, Array]]:
    """(H, W, 3) light at each time by the page with that bake alone; and what its window gives."""
    found = {}
    for name, (scene, lit) in rooms.items():
        page = shown(room_app(scene, light=[lit]))
        assert page.evaluate("document.getElementById('time')") is None
        whole = lit_picture(page)
        turn(page, WINDOW, on=False)
        found[name] = whole, whole - lit_picture(page)
    return found


@pytest.fixture(scope="module")
def page(
    rooms: dict[str, tuple[Path, Path]], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Page]:
    """Both in one page, which is a file."""
    scratch, (scene, _) = tmp_path_factory.mktemp("page"), rooms["noon"]
    app = room_app(scene, light=[lit for _, lit in rooms.values()])
    shell.write(app, scratch / "day.html")
    with opened(scratch / "day.html", webgl=True, size=(900, 600)) as page:
        page.wait("document.body.dataset.ready == 'yes'")
        yield page


def off(found: Array, expected: Array) -> float:
    """The largest difference of a pixel, as a part of it; below a nit as a part of that."""
    return float((np.abs(found - expected) / np.maximum(np.abs(expected), 1.0)).max())


def test_a_slider_goes_from_the_light_of_one_time_to_that_of_another(
    page: Page, alone: dict[str, tuple[Array, Array]]
) -> None:
    (noon, _), (evening, _) = alone["noon"], alone["evening"]
    assert noon.mean() > 1.5 * evening.mean()
    ends = []
    for time, expected in enumerate((noon, evening)):
        slide(page, "time", time)
        ends.append(off(lit_picture(page), expected))
    slide(page, "time", 0.5)
    between = lit_picture(page)
    middle = off(between, 0.5 * (noon + evening))
    print(f"off by {ends} at the ends, {middle} in the middle")
    assert max(ends) < 1e-5
    assert middle < 1e-4
    # Other shares are another picture: the measure sees it.
    assert off(between, 0.51 * noon + 0.49 * evening) > 5e-3
    assert page.evaluate("document.querySelector('#times output').textContent") == "noon to evening"


@pytest.mark.long
def test_a_window_has_one_switch_for_all_times(
    page: Page, alone: dict[str, tuple[Array, Array]]
) -> None:
    slide(page, "time", 0.25)
    whole = lit_picture(page)
    turn(page, WINDOW, on=False)
    taken = whole - lit_picture(page)
    turn(page, WINDOW, on=True)
    (_, at_noon), (_, at_evening) = alone["noon"], alone["evening"]
    expected = 0.75 * at_noon + 0.25 * at_evening
    assert expected.mean() > 10.0
    # Differences of pictures: parts of the whole.
    assert (np.abs(taken - expected) / np.maximum(whole, 1.0)).max() < 1e-3
