"""Objects that are hard to align, what they stand on, whose points the wall's are."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.planindex import PlanIndex
from openrooms_usd.scan.registration.alignment import align
from openrooms_usd.scan.registration.evidence import Evidence, gathered
from openrooms_usd.scan.registration.hints import Box, Hint, moved_pose
from openrooms_usd.scan.registration.hypotheses import from_box, plain
from openrooms_usd.scan.registration.selection import MIN_OBJECT_POINTS
from openrooms_usd.scan.registration.supportheights import supports
from openrooms_usd.scan.registration.surroundings import walls_of
from openrooms_usd.scan.registration.template import template_of
from openrooms_usd.scan.results import Pose
from tests.scan.alignment_cases import (
    CABINET,
    CHAIR,
    SENSOR_ORIGINS,
    TABLE,
    Block,
    Placed,
    cad,
    errors,
    room,
    scan,
)


def near(pose: Pose) -> Pose:
    """Some centimetres, degrees and per cent off."""
    turn = Rotation.from_euler("z", 8.0, degrees=True)
    rotation = turn * Rotation.from_quat(pose.rotation, scalar_first=True)
    return Pose(
        pose.translation + np.array([0.06, -0.06, 0.03]),
        rotation.as_quat(scalar_first=True),
        pose.scale * [1.1, 0.9, 0.9],
    )


@pytest.mark.slow
def test_a_side_at_the_wall_that_nobody_saw_is_at_the_wall() -> None:
    """The CAD has other sizes, and only the wall can tell the depth."""
    true = Placed(CABINET, (0.5, 1.77, 0.0), 0.0, "Z", np.array([0.85, 1.3, 1.1]))
    front = scan([true], np.array([[0.5, -1.0, 0.7], [0.3, -1.2, 0.8]]))
    hint = Hint(1, cad="cabinet", pose=near(true.pose()))
    model = cad("cabinet", CABINET, scale=true.scale)
    with_wall = align(front, [hint], [model], [room()]).objects[0]
    without = align(front, [hint], [model]).objects[0]
    back = with_wall.pose.translation[1] + 0.22 / 1.3 * with_wall.pose.scale[1]
    assert back == pytest.approx(2.0, abs=0.03)
    assert errors(with_wall.pose, true.pose())[2] < 0.05 < errors(without.pose, true.pose())[2]


@pytest.mark.slow
def test_a_chair_under_a_table_keeps_its_place() -> None:
    chair = Placed(CHAIR, (0.0, 0.15, 0.0), 0.1)
    table = Placed(TABLE, (0.0, 0.45, 0.0), 0.0)
    cloud = scan([chair, table], SENSOR_ORIGINS)
    hints = [
        Hint(1, cad="chair", pose=near(chair.pose())),
        Hint(2, cad="table", pose=near(table.pose())),
    ]
    found = align(cloud, hints, [cad("chair", CHAIR), cad("table", TABLE)], [room()])
    for one, true in zip(found.objects, (chair, table), strict=True):
        metres, degrees, scale = errors(one.pose, true.pose())
        assert metres < 0.05
        assert degrees < 5.0
        assert scale < 0.05


@pytest.mark.slow
def test_labels_that_are_wrong_in_a_tenth_of_the_points_do_not_matter() -> None:
    chair, cabinet = Placed(CHAIR, (0.2, 0.5, 0.0), 0.7), Placed(CABINET, (0.85, 0.75, 0.0), 0.7)
    cloud = scan([chair, cabinet], SENSOR_ORIGINS)
    assert cloud.instance is not None
    wrong = cloud.instance.copy()
    close = (wrong == 2) & (np.linalg.norm(cloud.points - [0.6, 0.55, 0.5], axis=1) < 0.3)
    assert 0.05 < close.sum() / (wrong == 1).sum() < 0.6
    wrong[close] = 1
    spoiled = replace(cloud, instance=wrong)
    hint = Hint(1, cad="chair", pose=near(chair.pose()))
    found = align(spoiled, [hint], [cad("chair", CHAIR)], [room()]).objects[0]
    metres, degrees, scale = errors(found.pose, chair.pose())
    assert metres < 0.05
    assert degrees < 5.0
    assert scale < 0.05


@pytest.mark.slow
def test_a_cad_in_millimetres_is_scaled() -> None:
    true = Placed(CHAIR, (0.2, 0.5, 0.0), 0.7, "Y", 0.001)
    cloud = scan([true], SENSOR_ORIGINS)
    vertices, _ = true.vertices()
    box = Box(
        vertices.mean(axis=0),
        np.array([0.5, 0.5, 0.9]),
        Rotation.from_euler("z", 0.75).as_quat(scalar_first=True),
    )
    found = align(cloud, [Hint(1, cad="chair", box=box)], [cad("chair", CHAIR, "Y", 0.001)])
    metres, degrees, scale = errors(found.objects[0].pose, true.pose())
    assert (metres, degrees, scale) < (0.03, 5.0, 0.05)
    assert scale < 0.05


@pytest.mark.slow
def test_what_stands_on_a_table_ends_at_its_top() -> None:
    thing = (((-0.15, -0.10, 0.0), (0.15, 0.10, 0.35)), ((-0.15, 0.05, 0.35), (0.15, 0.10, 0.5)))
    table, box = Placed(TABLE, (0.0, 0.6, 0.0), 0.2), Placed(thing, (0.1, 0.6, 0.74), 0.2)
    cloud = scan([box, table], SENSOR_ORIGINS)
    found = align(cloud, [Hint(1, cad="box", pose=near(box.pose()))], [cad("box", thing)])
    assert found.objects[0].pose.translation[2] == pytest.approx(0.74, abs=0.015)


def test_few_points_are_refused_with_the_reason() -> None:
    chair = Placed(CHAIR, (0.2, 0.5, 0.0), 0.7)
    cloud = scan([chair], SENSOR_ORIGINS)
    assert cloud.instance is not None
    rows = np.flatnonzero((cloud.instance == 1) & (cloud.points[:, 2] > 0.1))
    others = np.flatnonzero(cloud.instance == 0)
    few = cloud.take(np.concatenate([rows[:: len(rows) // 30][:30], others]))
    hints = [Hint(1, "chair"), Hint(2, "sofa"), Hint(3, "chair", "chair_z")]
    found = align(few, hints, [cad("chair", CHAIR)])
    assert found.objects == ()
    assert "points" in found.rejected[0].reason
    assert str(MIN_OBJECT_POINTS) in found.rejected[0].reason
    assert "no points of this instance" in found.rejected[1].reason


@pytest.mark.parametrize(
    ("hint", "reason"),
    [
        (Hint(1, "piano"), "no CAD of the category piano"),
        (Hint(1, "chair", "chair_z"), "no CAD 'chair_z'"),
        (Hint(1, None), "no CAD has the category"),
    ],
)
def test_what_has_no_cad_is_refused_with_the_reason(hint: Hint, reason: str) -> None:
    cloud = scan([Placed(CHAIR, (0.2, 0.5, 0.0), 0.7)], SENSOR_ORIGINS)
    labelled = replace(cloud, label=np.full(len(cloud), 5, dtype=np.int32))
    found = align(labelled, [hint], [cad("chair", CHAIR)])
    assert reason in found.rejected[0].reason


def test_a_cad_that_is_nowhere_near_is_refused() -> None:
    cloud = scan([Placed(CHAIR, (0.2, 0.5, 0.0), 0.7)], SENSOR_ORIGINS)
    pole = cad("pole", (((-0.01, -0.01, 0.0), (0.01, 0.01, 3.0)),))
    far = Pose(np.array([0.2, 0.5, 0.0]), np.array([1.0, 0.0, 0.0, 0.0]), np.ones(3))
    found = align(cloud, [Hint(1, cad="pole", pose=far)], [pole])
    assert "does not fit" in found.rejected[0].reason


@pytest.mark.slow
def test_points_without_instances_are_cut_out_by_the_hint() -> None:
    chair = Placed(CHAIR, (0.2, 0.5, 0.0), 0.7)
    cloud = scan([chair], SENSOR_ORIGINS)
    bare = Cloud(cloud.points, sensor_origins=cloud.sensor_origins)
    hint = Hint(7, cad="chair", pose=near(chair.pose()))
    found = align(bare, [hint], [cad("chair", CHAIR)], [room()]).objects[0]
    assert errors(found.pose, chair.pose())[0] < 0.05
    assert errors(found.pose, chair.pose())[1] < 5.0


def test_hints_move_with_their_frame() -> None:
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_rotvec([0.1, -0.2, 0.7]).as_matrix()
    matrix[:3, 3] = [4.0, -2.0, 1.0]
    pose = Placed(CHAIR, (0.2, 0.5, 0.1), 0.7, "Y", 1.2).pose()
    corner = np.array([0.3, 0.2, -0.1])
    moved = moved_pose(pose, matrix)

    def carried(one: Pose) -> np.ndarray:
        turn = Rotation.from_quat(one.rotation, scalar_first=True)
        return turn.apply(one.scale * corner) + one.translation

    expected = matrix[:3, :3] @ carried(pose) + matrix[:3, 3]
    assert carried(moved) == pytest.approx(expected, abs=1e-12)
    back = Hint(1, pose=moved).moved(np.linalg.inv(matrix)).pose
    assert back is not None
    assert back.rotation == pytest.approx(pose.rotation, abs=1e-12)


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
    floor, other = supports(cloud, PlanIndex(cloud.points), *own(cloud, 1), bottom=0.1)
    assert floor == 0.0
    assert other == pytest.approx(0.155, abs=0.02)
    # Without a size to expect it may as well be one thing whose foot is hidden.
    assert supports(cloud, PlanIndex(cloud.points), *own(cloud, 1), bottom=None) == (0.0,)


def test_the_floor_is_possible_where_a_foot_may_be_hidden() -> None:
    seen, board = (
        sheet([-0.3, -0.2, 0.4], [0.3, 0.2, 0.9]),
        sheet([-0.3, -0.2, 0.38], [0.3, 0.2, 0.39]),
    )
    cloud = cloud_of(seen, board)
    likely, floor = supports(cloud, PlanIndex(cloud.points), *own(cloud, 1), bottom=None)
    assert likely == pytest.approx(0.385, abs=0.02)
    assert floor == 0.0
    rise = np.array([0.0, 0.0, 1.0])
    high = cloud_of(seen + rise, board + rise)
    assert len(supports(high, PlanIndex(high.points), *own(high, 1), bottom=None)) == 1


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
    assert reasons == [f"its points are labelled {word}, which the layout reconstructs"]


def test_strays_do_not_stretch_a_cad_beyond_sane_limits() -> None:
    template = template_of(cad("chair", CHAIR), np.eye(3), np.ones(3))
    size = template.size * [1.0, 4.0, 1.0]
    box = Box(np.array([0.0, 0.0, 0.45]), size, np.array([1.0, 0.0, 0.0, 0.0]))
    stretch = from_box(template, box, given=False)[0].parameters[4:] - plain(template)
    assert stretch == pytest.approx([0.0, 0.3, 0.0], abs=1e-9)
    given = from_box(template, box, given=True)[0].parameters[4:] - plain(template)
    assert given[1] == pytest.approx(np.log(4.0))


def shelves(blocks: tuple[Block, ...], heading: float, place: tuple[float, float, float]) -> Pose:
    """How a bookshelf that is built at any size is found in what is scanned of some blocks."""
    cloud = scan([Placed(blocks, place, heading)], SENSOR_ORIGINS)
    model = cad("bookshelf", (((-0.5, -0.2, 0.0), (0.5, 0.2, 1.6)),))
    model = replace(model, sizes=np.array([[0.3, 0.15, 0.5], [5.0, 1.0, 2.5]]))
    hint = Hint(1, word="bookshelf", choices=(("bookshelf",),))
    return align(cloud, [hint], [model], [room()]).objects[0].pose


def heading_of(pose: Pose) -> float:
    """Degrees from the next wall of the room."""
    turn = Rotation.from_quat(pose.rotation, scalar_first=True).as_euler("xyz", degrees=True)[2]
    return float((turn + 45.0) % 90.0 - 45.0)


def test_shelves_that_go_around_a_corner_stand_along_the_wall() -> None:
    """The smallest box around their points lies across, 6 degrees askew."""
    wing = ((-2.0, 1.6, 0.0), (1.5, 1.98, 1.6))
    steps = [((-2.48, 1.6 - 0.1 * k, 0.0), (-1.9 - 0.1 * k, 1.7 - 0.1 * k, 1.6)) for k in range(6)]
    found = shelves((wing, *steps), 0.0, (0.0, 0.0, 0.0))
    assert heading_of(found) == pytest.approx(0.0, abs=0.2)
    assert found.translation[1] == pytest.approx(1.79, abs=0.03)
    assert 0.4 * found.scale[1] == pytest.approx(0.38, abs=0.05)


def test_shelves_that_stand_askew_at_a_wall_stay_askew() -> None:
    found = shelves((((-1.2, -0.25, 0.0), (1.2, 0.25, 1.6)),), 0.2, (0.0, 1.5, 0.0))
    assert heading_of(found) == pytest.approx(np.degrees(0.2), abs=1.0)


def test_the_wall_that_a_box_stands_at_askew() -> None:
    walls = walls_of([room()])  # 5 x 4 m about the origin: the third is at y = 2
    size = np.array([2.0, 0.4, 1.0])
    askew = np.array([0.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.0])
    askew[1] = 2.0 - 1.0 * np.sin(0.2) - 0.2 * np.cos(0.2) - 0.1
    assert walls.gaps(askew, size)[2] == pytest.approx(0.1)
    found = walls.askew(askew, size)
    assert found is not None
    assert (found[0], found[1]) == (2, pytest.approx(-0.2))
    assert walls.askew(askew - np.eye(7)[1] * 0.3, size) is None
    assert walls.askew(askew * [1, 1, 1, 0, 1, 1, 1], size) is None
