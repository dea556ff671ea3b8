"""What an object stands on, whose points the wall's are, and what is no object at all."""

from dataclasses import replace

import numpy as np
import pytest

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.registration.alignment import align
from openrooms_usd.scan.registration.evidence import Evidence, gathered
from openrooms_usd.scan.registration.hints import Box, Hint
from openrooms_usd.scan.registration.hypotheses import from_box, plain
from openrooms_usd.scan.registration.supportheights import supports
from openrooms_usd.scan.registration.surroundings import walls_of
from openrooms_usd.scan.registration.template import template_of
from tests.scan.alignment_cases import CABINET, CHAIR, SENSOR_ORIGINS, Placed, cad, room, scan

LOW = (((-0.3, -0.2, 0.0), (0.3, 0.2, 0.16)),)
CRATE = (((-0.3, -0.2, 0.0), (0.3, 0.2, 0.3)),)


def sheet(low: list[float], high: list[float], count: int = 4000) -> np.ndarray:
    """Points spread over a rectangle or a block."""
    return np.random.default_rng(7).uniform(low, high, (count, 3))


def test_points_of_the_wall_are_not_those_of_what_stands_before_it() -> None:
    front = sheet([-0.4, 1.50, 0.05], [0.4, 1.51, 0.9])
    wall = sheet([0.4, 1.995, 0.05], [0.8, 2.0, 0.9])
    behind = sheet([0.4, 2.1, 0.05], [0.5, 2.3, 0.9], 500)
    side = sheet([0.39, 1.50, 0.05], [0.41, 2.0, 0.9])
    points = np.concatenate([front, wall, behind, side])
    found = gathered(points, walls=walls_of([room()])).points

    def strays(points: np.ndarray) -> int:
        return int((points[:, 0] > 0.45).sum())

    assert strays(found) < 0.02 * strays(gathered(points).points)
    assert (found[:, 1] > 1.85).sum() > 100


def test_a_picture_keeps_its_points() -> None:
    picture = sheet([-0.4, 1.97, 1.2], [0.4, 1.99, 1.8])
    bare = gathered(picture).points
    assert len(gathered(picture, walls=walls_of([room()])).points) == len(bare)


def cloud_of(*parts: np.ndarray) -> Cloud:
    numbers = np.repeat(np.arange(1, len(parts) + 1), [len(part) for part in parts])
    return Cloud(np.concatenate(parts), instance=numbers.astype(np.int32))


def own(cloud: Cloud, number: int) -> tuple[np.ndarray, Evidence]:
    assert cloud.instance is not None
    rows = np.flatnonzero(cloud.instance == number)
    return rows, Evidence(cloud.points[rows], 0.02)


def test_what_lies_on_a_flat_thing_may_stand_on_it() -> None:
    lower = sheet([-0.3, -0.2, 0.0], [0.3, -0.19, 0.16])
    upper = sheet([-0.3, -0.2, 0.17], [0.3, -0.19, 0.46])
    cloud = cloud_of(upper, lower)
    floor, other = supports(cloud, *own(cloud, 1), bottom=0.1)
    assert floor == 0.0
    assert other == pytest.approx(0.155, abs=0.02)
    # Without a size to expect it may as well be one thing whose foot is hidden.
    assert supports(cloud, *own(cloud, 1), bottom=None) == (0.0,)


def test_the_floor_is_possible_where_a_foot_may_be_hidden() -> None:
    seen, board = (
        sheet([-0.3, -0.2, 0.4], [0.3, 0.2, 0.9]),
        sheet([-0.3, -0.2, 0.38], [0.3, 0.2, 0.39]),
    )
    cloud = cloud_of(seen, board)
    likely, floor = supports(cloud, *own(cloud, 1), bottom=None)
    assert likely == pytest.approx(0.385, abs=0.02)
    assert floor == 0.0
    rise = np.array([0.0, 0.0, 1.0])
    high = cloud_of(seen + rise, board + rise)
    assert len(supports(high, *own(high, 1), bottom=None)) == 1


def test_a_crate_on_a_flat_one_stands_on_it() -> None:
    lower = Placed(LOW, (0.3, 0.7, 0.0), 0.3)
    upper = Placed(CRATE, (0.3, 0.7, 0.16), 0.3)
    cloud = scan([upper, lower], SENSOR_ORIGINS)
    pose = upper.pose()
    near = replace(pose, translation=pose.translation + np.array([0.04, -0.03, -0.06]))
    found = align(cloud, [Hint(1, cad="crate", pose=near)], [cad("crate", CRATE)], [room()])
    assert found.objects[0].pose.translation[2] == pytest.approx(0.16, abs=0.03)
    assert found.objects[0].pose.scale[2] == pytest.approx(1.0, abs=0.08)


@pytest.mark.parametrize(("label", "word"), [(8, "door"), (9, "window"), (1, "wall")])
def test_openings_and_walls_are_left_to_the_layout(label: int, word: str) -> None:
    cloud = scan([Placed(CABINET, (0.2, 0.5, 0.0), 0.7)], SENSOR_ORIGINS)
    labelled = replace(cloud, label=np.full(len(cloud), label, dtype=np.int32))
    found = align(labelled, None, [cad("cabinet", CABINET)], categories={3: ("cabinet",)})
    reasons = [item.reason for item in found.rejected if item.instance == 1]
    assert reasons == [f"its points are labelled {word}, which the layout finds"]


def test_strays_do_not_stretch_a_cad_beyond_sane_limits() -> None:
    template = template_of(cad("chair", CHAIR), np.eye(3), np.ones(3))
    size = template.size * [1.0, 4.0, 1.0]
    box = Box(np.array([0.0, 0.0, 0.45]), size, np.array([1.0, 0.0, 0.0, 0.0]))
    stretch = from_box(template, box, given=False)[0].parameters[4:] - plain(template)
    assert stretch == pytest.approx([0.0, 0.3, 0.0], abs=1e-9)
    given = from_box(template, box, given=True)[0].parameters[4:] - plain(template)
    assert given[1] == pytest.approx(np.log(4.0))
