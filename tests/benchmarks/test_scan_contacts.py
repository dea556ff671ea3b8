"""Penetration, walls and floating of boxes are those of the closed form."""

import numpy as np
import pytest

from openrooms_usd.scan.results import FoundObject, FoundRoom, Pose

pytest.importorskip("fcl")
pytest.importorskip("embreex")

ROOM = FoundRoom(
    np.array([0, 0, 1.0]),
    np.zeros(3),
    np.array([[0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0.0]]),
    ceiling=2.5,
)


def thing(number, at, cad="box"):
    still = Pose(np.array(at, float), np.array([1.0, 0, 0, 0]), np.ones(3))
    return FoundObject(number, cad, cad, still, 0.0, 1.0)


@pytest.fixture(scope="module")
def cads():
    """A box of half a metre on its foot, and a table of a top and four legs."""
    import trimesh

    from benchmarks.scan.truth import Cad

    def box(low, high):
        return trimesh.creation.box(bounds=[low, high])

    legs = [box((x, y, 0), (x + 0.05, y + 0.05, 0.7)) for x in (-0.5, 0.45) for y in (-0.5, 0.45)]
    meshes = {
        "box": box((-0.25, -0.25, 0), (0.25, 0.25, 0.5)),
        "table": trimesh.util.concatenate([box((-0.5, -0.5, 0.7), (0.5, 0.5, 0.75)), *legs]),
    }
    return {
        name: Cad(name, name, np.array(mesh.vertices), np.array(mesh.faces), "none")
        for name, mesh in meshes.items()
    }


def measured(cads, *things, true=()):
    from benchmarks.scan.contacts import contacts

    return contacts(things, cads, [ROOM], true)


@pytest.mark.parametrize(
    ("gap", "depth"), [(0.01, 0), (-0.0008, 0.001), (-0.004, 0.005), (-0.015, 0.02)]
)
def test_boxes_penetrate_as_deep_as_they_overlap(cads, gap, depth):
    found = measured(cads, thing(1, (1, 1, 0)), thing(2, (1.5 + gap, 1.1, 0)))
    assert [d for *_, d in found.penetrations] == ([depth] if depth else [])
    assert found.summary()["pairs_deep"] == (depth > 0.005)


def test_what_is_below_a_table_does_not_penetrate_it(cads):
    found = measured(cads, thing(1, (1, 1, 0), "table"), thing(2, (1.05, 0.95, 0)))
    assert found.penetrations == () and max(found.floating.values()) == 0


def test_walls_are_left_by_as_much_as_a_box_reaches_out(cads):
    found = measured(cads, thing(1, (0.20, 1, 0)), thing(2, (2, 1, 0)))
    assert found.in_walls[1] == pytest.approx(0.05) and found.in_walls[2] == 0
    assert found.summary()["in_walls"] == 1


def test_floating_is_the_gap_to_whatever_is_below(cads):
    found = measured(
        cads,
        thing(1, (1, 1, 0.04)),
        thing(2, (2.5, 1, 0), "table"),
        thing(3, (2.5, 1, 0.77)),
        thing(4, (2.5, 2, 0)),
        thing(5, (2.7, 2.1, 0.49)),
    )
    gaps = [0.04, 0, 0.02, 0, 0]
    assert [found.floating[n] for n in range(1, 6)] == pytest.approx(gaps, abs=1e-6)
    assert found.summary()["floating"] == 2


def test_what_hangs_in_truth_may_hang(cads):
    true = (thing(1, (0.25, 1, 1.2)), thing(2, (2, 1, 2.0)))
    still = measured(cads, *true, true=true)
    assert max(still.floating.values()) == pytest.approx(0)
    away = measured(cads, thing(1, (0.30, 1, 1.2)), thing(2, (2, 1, 1.9)), true=true)
    assert away.floating == pytest.approx({1: 0.05, 2: 0.1})


def test_rough_hints_have_the_noise_that_they_say(cads):
    from scipy.spatial.transform import Rotation

    from benchmarks.scan.truth import Truth, rough, stretched

    things = tuple(thing(n, (1 + n, 1, 0), "box" if n % 2 else "table") for n in range(1, 8))
    truth = stretched(Truth((ROOM,), things, cads), 3)
    shifts, turns, scales = [], [], []
    for seed in range(200):
        hints = rough(truth.objects, truth.cads, seed, "pose")
        for hint, item in zip(hints, truth.objects, strict=True):
            shifts.append(hint.pose.translation - item.pose.translation)
            a, b = (
                Rotation.from_quat(p.rotation, scalar_first=True) for p in (hint.pose, item.pose)
            )
            turns.append((a * b.inv()).as_rotvec(degrees=True)[2])
            scales.append(np.log(hint.pose.scale / item.pose.scale))
    assert np.std(shifts) == pytest.approx(0.10, rel=0.1)
    assert np.std(turns) == pytest.approx(10, rel=0.1)
    assert np.std(scales) == pytest.approx(0.10, rel=0.1)


def test_development_and_test_seeds_are_apart():
    from benchmarks.scan.cases import rooms_of

    assert not set(rooms_of("development", False)) & set(rooms_of("test", False))
