"""CADs are put where they are: from a noisy pose, from a box, from labelled points alone."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.scan.models.cad import UPRIGHT, CadModel
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.registration.alignment import align
from openrooms_usd.scan.registration.hints import Box, Hint
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
