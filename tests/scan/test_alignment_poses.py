"""CADs are put where they are, by the mathematics of the fit: derivatives, frames, visibility."""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import approx_fprime
from scipy.spatial.transform import Rotation

from openrooms_usd.scan.models.cad import UPRIGHT, CadModel
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.visibility import likely_sensor_origins, look_around
from openrooms_usd.scan.registration.alignment import align
from openrooms_usd.scan.registration.evidence import Evidence, gathered
from openrooms_usd.scan.registration.fitting import FINE, AnnealingLevel, refined
from openrooms_usd.scan.registration.hints import Box, Hint
from openrooms_usd.scan.registration.hypotheses import box_of, from_box, true_size
from openrooms_usd.scan.registration.priors import PoseHypothesis
from openrooms_usd.scan.registration.surroundings import ObjectSurroundings, walls_of
from openrooms_usd.scan.registration.template import (
    Template,
    directions,
    posed,
    template_of,
    turn_of,
    unposed,
    upright_of,
)
from openrooms_usd.scan.results import Pose
from tests.scan.alignment_cases import (
    CABINET,
    CHAIR,
    SENSOR_ORIGINS,
    SOFA,
    TABLE,
    Placed,
    cad,
    errors,
    room,
    scan,
)

STRETCH = np.array([1.12, 0.9, 1.06])
SCENE = {
    "chair": Placed(CHAIR, (0.2, 0.9, 0.0), 0.4, "Y", STRETCH),
    "table": Placed(TABLE, (-1.0, 0.4, 0.0), 1.2),
    "sofa": Placed(SOFA, (0.9, 1.58, 0.0), 0.0, "Z", STRETCH),
    "cabinet": Placed(CABINET, (-2.27, -0.9, 0.0), 0.5 * np.pi),
}


@cache
def seen() -> Cloud:
    return scan(list(SCENE.values()), SENSOR_ORIGINS)


def models(**changes: object) -> list[CadModel]:
    return [
        cad(name, one.blocks, one.up, one.scale, **changes)  # type: ignore[arg-type]
        for name, one in SCENE.items()
    ]


def noisy(pose: Pose, seed: int) -> Pose:
    """10 cm, 10 degrees and 10 % off."""
    rng = np.random.default_rng(seed)
    axis, way = rng.normal(size=(2, 3))
    turn = Rotation.from_rotvec(np.deg2rad(10.0) * axis / np.linalg.norm(axis))
    rotation = (turn * Rotation.from_quat(pose.rotation, scalar_first=True)).as_quat(
        scalar_first=True
    )
    shift = 0.1 * way / np.linalg.norm(way)
    return Pose(pose.translation + shift, rotation, pose.scale * (1 + 0.1 * rng.choice([-1, 1], 3)))


def box_around(one: Placed, seed: int) -> Box:
    """A box as noisy, whose heading is off by some quarter turns."""
    rng = np.random.default_rng(seed)
    vertices, _ = one.vertices()
    own = Rotation.from_euler("z", -one.heading).apply(vertices - one.place)
    size, middle = np.ptp(own, axis=0), 0.5 * (own.min(axis=0) + own.max(axis=0))
    center = Rotation.from_euler("z", one.heading).apply(middle) + one.place
    quarters = int(rng.integers(4))
    turn = Rotation.from_euler("z", one.heading + 0.5 * np.pi * quarters + np.deg2rad(8.0))
    size = size[[1, 0, 2]] if quarters % 2 else size
    way = rng.normal(size=3)
    return Box(
        center + 0.08 * way / np.linalg.norm(way),
        size * (1 + 0.1 * rng.choice([-1, 1], 3)),
        turn.as_quat(scalar_first=True),
    )


@pytest.mark.one_in(3)
@pytest.mark.parametrize("seed", range(3))
def test_a_noisy_pose_becomes_the_true_one(seed: int) -> None:
    hints = [
        Hint(i, cad=name, pose=noisy(one.pose(), 10 * seed + i))
        for i, (name, one) in enumerate(SCENE.items(), 1)
    ]
    found = align(seen(), hints, models(), [room()])
    assert found.rejected == ()
    for one, true in zip(found.objects, SCENE.values(), strict=True):
        metres, degrees, scale = errors(one.pose, true.pose())
        assert metres < 0.05, one.cad
        assert degrees < 5.0, one.cad
        assert scale < 0.05, one.cad
        assert one.residual < 0.02
        assert one.coverage > 0.7


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_a_box_gives_pose_and_heading(seed: int) -> None:
    turns = {"table": (0, 2), "cabinet": (0, 2)}
    hints = [
        Hint(i, cad=name, box=box_around(one, 20 * seed + i))
        for i, (name, one) in enumerate(SCENE.items(), 1)
    ]
    found = align(seen(), hints, models(), [room()])
    for one, true in zip(found.objects, SCENE.values(), strict=True):
        metres, degrees, scale = errors(one.pose, true.pose(), turns.get(one.cad, (0,)))
        assert metres < 0.08, one.cad
        assert degrees < 5.0, one.cad
        assert scale < 0.1, one.cad


@pytest.mark.slow
def test_the_upright_axis_is_found_where_no_index_states_it() -> None:
    hints = [
        Hint(i, cad=name, box=box_around(one, i)) for i, (name, one) in enumerate(SCENE.items(), 1)
    ]
    found = align(seen(), hints, models(stated=False), [room()])
    for one, true in zip(found.objects, SCENE.values(), strict=True):
        turn = Rotation.from_quat(one.pose.rotation, scalar_first=True).as_matrix()
        up = UPRIGHT[true.up][2]
        assert turn @ up == pytest.approx([0.0, 0.0, 1.0], abs=1e-9), one.cad


@pytest.mark.slow
def test_labelled_points_alone_find_cad_and_pose() -> None:
    plain = [
        cad("chair_a", CHAIR),
        cad("chair_tall", CHAIR, scale=np.array([1.0, 1.0, 0.6])),
        cad("table_a", TABLE),
        cad("table_long", TABLE, scale=np.array([0.5, 1.0, 1.0])),
    ]
    placed = [Placed(CHAIR, (0.3, 0.6, 0.0), 0.4), Placed(TABLE, (-1.0, 0.4, 0.0), 1.2)]
    cloud = scan(placed, SENSOR_ORIGINS)
    hints = [Hint(1, "chair"), Hint(2, "table")]
    found = align(cloud, hints, plain, [room()])
    assert [one.cad for one in found.objects] == ["chair_a", "table_a"]
    assert errors(found.objects[0].pose, placed[0].pose())[:2] < (0.05, 5.0)
    assert found.objects[1].symmetry == "2"


@pytest.mark.slow
def test_equal_input_gives_equal_bits_with_any_number_of_workers() -> None:
    hints = [
        Hint(i, cad=name, pose=noisy(one.pose(), i)) for i, (name, one) in enumerate(SCENE.items())
    ]
    one, other = (align(seen(), hints, models(), [room()], workers=count) for count in (1, 3))
    assert [thing.cad for thing in one.objects] == [thing.cad for thing in other.objects]
    for first, second in zip(one.objects, other.objects, strict=True):
        assert first.pose.matrix.tobytes() == second.pose.matrix.tobytes()


def test_every_object_is_told_in_order() -> None:
    told: list[tuple[str, float]] = []
    align(seen(), [Hint(90), Hint(91)], models(), progress=lambda *step: told.append(step))
    assert told == [("object 1 of 2", 0.5), ("object 2 of 2", 1.0)]


PARAMETERS = np.array([0.4, -0.3, 0.1, 0.8, 0.05, -0.08, 0.1])


class Case(NamedTuple):
    template: Template
    prior: PoseHypothesis


def case(up: str = "Y") -> Case:
    model = cad("chair", CHAIR, up)  # type: ignore[arg-type]
    template = template_of(model, UPRIGHT[up], np.array([1.1, 0.9, 1.0]))  # type: ignore[index]
    return Case(template, PoseHypothesis(PARAMETERS + 0.05, np.full(7, 0.1), np.zeros(3)))


@pytest.mark.parametrize("up", ["X", "Y", "Z"])
def test_parameters_and_poses_are_the_same(up: str) -> None:
    template, _ = case(up)
    pose = template.pose(PARAMETERS)
    turn = Rotation.from_quat(pose.rotation, scalar_first=True)
    own = template.model.surface.points
    assert posed(template.points, PARAMETERS) == pytest.approx(
        turn.apply(own * pose.scale) + pose.translation, abs=1e-12
    )
    assert template.parameters(pose) == pytest.approx(PARAMETERS, abs=1e-12)
    assert unposed(posed(own, PARAMETERS), PARAMETERS) == pytest.approx(own, abs=1e-12)


@pytest.mark.parametrize("up", ["X", "Y", "Z"])
def test_a_tilted_pose_stands_upright_about_its_middle(up: str) -> None:
    template, _ = case(up)
    pose = template.pose(PARAMETERS)
    tilt = Rotation.from_rotvec([0.12, -0.08, 0.0])
    middle = np.array([[0.0, 0.0, 0.5 * template.size[2]]])
    (centre,) = posed(middle, PARAMETERS)
    tilted = Pose(
        tilt.apply(pose.translation - centre) + centre,
        (tilt * Rotation.from_quat(pose.rotation, scalar_first=True)).as_quat(scalar_first=True),
        pose.scale,
    )
    found = template.parameters(tilted)
    assert posed(middle, found)[0] == pytest.approx(centre, abs=1e-9)
    assert found[3:] == pytest.approx(PARAMETERS[3:], abs=0.01)
    rotation = Rotation.from_quat(tilted.rotation, scalar_first=True).as_matrix()
    assert upright_of(rotation)[2] == pytest.approx(UPRIGHT[up][2])  # type: ignore[index]


def test_normals_stay_across_the_stretched_surface() -> None:
    tangent = np.array([[1.0, 0.4, 0.2], [0.3, -1.0, 0.5]])
    normal = np.cross(*tangent)[None]
    moved = posed(tangent, PARAMETERS) - PARAMETERS[:3]
    assert moved @ directions(normal, PARAMETERS)[0] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_the_prior_and_its_derivative_agree() -> None:
    _, prior = case()
    slope = approx_fprime(PARAMETERS, prior.energy, 1e-6)
    assert 2.0 * prior.system(PARAMETERS).vector == pytest.approx(slope, abs=1e-3)
    wound = PARAMETERS + np.eye(7)[3] * 2.0 * np.pi
    assert prior.energy(wound) == pytest.approx(prior.energy(PARAMETERS))


def test_contacts_and_their_derivatives_agree() -> None:
    """Standing above the floor, with one corner in a wall; which side is there only chooses."""
    template, _ = case()
    template.__dict__["flat"] = np.ones(4)
    around = ObjectSurroundings(None, 0.0, walls_of([room()]).near(np.array([2.4, 0.0]), 0.5))
    place = np.array([2.35, 0.0, 0.03, 0.4, 0.1, 0.0, -0.1])
    rows = around.rows(template, place, np.zeros(4, dtype=np.bool_))

    def energy(p: np.ndarray) -> float:
        return around.rows(template, p, np.zeros(4, dtype=np.bool_)).energy

    assert rows.energy > 10.0
    assert 2.0 * rows.slope.T @ rows.residual == pytest.approx(
        approx_fprime(place, energy, 1e-7), rel=1e-3, abs=1e-2
    )


@pytest.mark.parametrize("axis", range(7))
def test_a_fit_returns_from_every_side(axis: int) -> None:
    template, _ = case("Z")
    truth = PARAMETERS.copy()
    points = posed(template.points, truth)
    prior = PoseHypothesis(truth, np.full(7, 0.3), truth[4:])
    off = np.array([0.05, 0.05, 0.05, 0.1, 0.08, 0.08, 0.08]) * np.eye(7)[axis]
    stages = (AnnealingLevel(0.1, 500, 8, 1.0), *FINE)
    begins = np.array([truth + off, truth - off])
    evidence = Evidence(points, 0.02)
    fits = refined(template, evidence, ObjectSurroundings(), [prior] * 2, begins, stages)
    assert [fit.parameters for fit in fits] == pytest.approx(np.array([truth] * 2), abs=0.012)


def test_poses_that_are_fitted_together_are_fitted_as_alone() -> None:
    """Their visible points differ in number, and their priors, walls and sides in all."""
    placed = Placed(CABINET, (0.0, 1.6, 0.0), 0.3)
    cloud = scan([placed], SENSOR_ORIGINS)
    template = template_of(cad("cabinet", CABINET), np.eye(3), np.ones(3))
    panoramas = look_around(cloud.points, SENSOR_ORIGINS)
    around = ObjectSurroundings(panoramas, 0.0, walls_of([room()]))
    evidence = gathered(cloud.points[cloud.instance == 1])
    truth = np.array([0.0, 1.6, 0.0, 0.3, 0.0, 0.0, 0.0])
    begins = truth + np.array([np.zeros(7), np.full(7, 0.05), np.eye(7)[3] * 1.5])
    priors = [PoseHypothesis(each, np.full(7, 0.2), truth[4:]) for each in begins]
    level = AnnealingLevel(0.1, 300, 3, 1.0)
    together = refined(template, evidence, around, priors, begins, [level])
    for fit, prior, begin in zip(together, priors, begins, strict=True):
        (alone,) = refined(template, evidence, around, [prior], begin[None], [level])
        assert fit.parameters == pytest.approx(alone.parameters, abs=1e-9)
        assert fit.energy == pytest.approx(alone.energy, rel=1e-9)


def test_only_what_faces_an_eye_and_is_not_covered_is_visible() -> None:
    placed = Placed(CABINET, (0.0, 1.0, 0.0), 0.0)
    cloud = scan([placed], SENSOR_ORIGINS)
    template = template_of(cad("cabinet", CABINET), np.eye(3), np.ones(3))
    panoramas = look_around(cloud.points, SENSOR_ORIGINS)
    place = np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    normals = template.normals
    visible = panoramas.visible(posed(template.points, place), normals, template.two_sided)
    assert visible[normals[:, 1] < -0.9].mean() > 0.95
    assert visible[normals[:, 2] > 0.9].mean() > 0.95
    assert not visible[normals[:, 1] > 0.9].any()
    assert not visible[normals[:, 2] < -0.9].any()
    # In the free space before it everything is visible, although no points are there.
    forward = posed(template.points, place + np.eye(7)[1] * -0.6)
    assert (
        panoramas.visible(forward, normals, template.two_sided)[normals[:, 1] < -0.9].mean() > 0.9
    )


def test_without_a_path_people_stand_on_free_floor() -> None:
    cloud = scan([Placed(CABINET, (0.0, 1.0, 0.0), 0.0)], SENSOR_ORIGINS)
    sensor_origins = likely_sensor_origins(cloud.points)
    assert len(sensor_origins) > 5
    assert (np.abs(sensor_origins[:, :2]) < [2.6, 2.1]).all()
    in_cabinet = (np.abs(sensor_origins[:, 0]) < 0.3) & (np.abs(sensor_origins[:, 1] - 1.0) < 0.2)
    assert not in_cabinet.any()


def test_strays_and_the_floor_are_not_the_object() -> None:
    rng = np.random.default_rng(1)
    block = rng.uniform([0, 0, 0], [0.5, 0.5, 0.5], (5000, 3))
    stray = rng.uniform([1.5, 0, 0.2], [1.6, 0.1, 0.3], (60, 3))
    found = gathered(np.concatenate([block, stray]))
    assert found.points[:, 0].max() <= 0.5
    assert found.points[:, 2].min() > 0.02


def test_a_box_around_points_knows_heading_and_size() -> None:
    surface = cad("cabinet", CABINET).surface.points
    turn = turn_of(np.array([0.0, 0, 0, 0.5, 0, 0, 0]))
    base, size, heading = box_of(
        Evidence(surface @ turn.T + np.array([1.0, 2.0, 0.0]), 0.02), 0.0
    ).upright()
    assert base == pytest.approx([1.0, 2.0, 0.0], abs=0.02)
    assert np.sort(size) == pytest.approx([0.44, 0.8, 0.9], abs=0.03)
    assert np.mod(heading - 0.5 + 0.2, 0.5 * np.pi) - 0.2 == pytest.approx(0.0, abs=0.06)


def test_a_unit_is_found_from_the_size_of_a_box() -> None:
    template = template_of(cad("chair", CHAIR, "Z", 0.001), np.eye(3), np.full(3, 0.00105))
    box = box_of(Evidence(template.points, 0.02), 0.0)
    true = true_size(from_box(template, box, given=True)[0])
    assert true is not None
    assert template.pose(np.array([0.0, 0, 0, 0, *true])).scale == pytest.approx(np.full(3, 0.001))
