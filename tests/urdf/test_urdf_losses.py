"""What a format or an engine cannot do is said, and what is left out on request."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from openrooms_usd.physics.world import Shape, Visual, World
from orusd_urdf import mjcf
from orusd_urdf.mjcf import write_mjcf
from orusd_urdf.usdphysics import write_usdphysics


def explicit(folder: Path) -> set[frozenset[str]]:
    root = ElementTree.parse(folder / "scene.xml").getroot()
    pairs = root.iterfind("contact/pair")
    return {frozenset((p.get("geom1", ""), p.get("geom2", ""))) for p in pairs}


def test_only_unequal_things_that_can_meet_are_pairs(make: SimpleNamespace, tmp_path: Path) -> None:
    at = np.array([[0.0, 0.0, 0.25], [0.3, 0.0, 0.05], [5.0, 0.0, 0.05], [6.0, 0.0, 0.05]])
    world = World(
        (
            make.ground(0.6),
            make.block("A", at[0], 0.3),
            make.block("B", at[1], 0.4),
            make.block("C", at[2], 0.302),
            make.block("D", at[3], 0.2, fixed=True, link={"mass": None}),
        )
    )
    floor = [{"Room.Floor", f"{name}.hull"} for name in "ABC"]
    near, far = [{"A.hull", "B.hull"}], [{"B.hull", "C.hull"}]
    # D is fixed as the floor is, and stands within reach of nobody; A and C are as good as equal.
    fixed = [{f"{name}.hull", "D.hull"} for name in "ABC"]
    notes = {}
    for which in ("all", "near", "close", "none"):
        notes[which] = write_mjcf(world, tmp_path / which, looks={}, pairs=which)  # type: ignore[arg-type]
    found = {which: explicit(tmp_path / which) for which in notes}
    assert found["all"] == {frozenset(pair) for pair in [*floor, *near, *far, *fixed]}
    assert found["near"] == {frozenset(pair) for pair in [*floor, *near]}
    # A hangs 20 cm above the floor, and 10 cm above B, which is beside it.
    assert found["close"] == {frozenset(pair) for pair in floor[1:]}
    assert found["none"] == set()
    assert [len(lost) for lost in notes.values()] == [0, 1, 1, 1]


def test_too_many_pairs_are_only_those_that_are_near(
    make: SimpleNamespace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two blocks far from each other: three pairs of unequal things, two of them with the floor."""
    places = np.array([[0.0, 0.0, 0.05], [5.0, 0.0, 0.05]])
    blocks = [make.block(n, at, mu) for n, at, mu in zip("AB", places, (0.3, 0.4), strict=True)]
    world = World((make.ground(0.6), *blocks))
    assert mjcf.MAX_PAIRS == 100_000
    assert write_mjcf(world, tmp_path / "few", looks={}) == []
    assert len(explicit(tmp_path / "few")) == 3
    monkeypatch.setattr(mjcf, "MAX_PAIRS", 2)
    ((path, outcome, reason),) = write_mjcf(world, tmp_path / "many", looks={})
    assert (path, outcome) == ("/", "approximated")
    assert "apart have the larger coefficient" in reason and "pairs=all" in reason
    stands = {frozenset({"Room.Floor", f"{n}.hull"}) for n in "AB"}
    assert explicit(tmp_path / "many") == stands
    # Also when what touches is too many.
    monkeypatch.setattr(mjcf, "MAX_PAIRS", 1)
    ((_, _, reason),) = write_mjcf(world, tmp_path / "more", looks={})
    assert "do not touch at first" in reason and explicit(tmp_path / "more") == stands
    # Asked for, all are written however many they are.
    assert write_mjcf(world, tmp_path / "all", looks={}, pairs="all") == []
    assert explicit(tmp_path / "all") == explicit(tmp_path / "few")
    monkeypatch.setattr(mjcf, "MAX_PAIRS", 3)
    assert write_mjcf(world, tmp_path / "just", looks={}) == []


def test_mujoco_neither_bounces_nor_draws_one_triangle(
    make: SimpleNamespace, tmp_path: Path
) -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    link = {
        "shapes": (Shape("hull", make.box((0.2, 0.2, 0.1)), make.contact(0.4, 0.5)),),
        "visuals": (Visual("one", make.mesh(points, [[0, 1, 2]])),),
    }
    lost = write_mjcf(World((make.block("B", np.zeros(3), link=link),)), tmp_path, looks={})
    assert {reason for _, _, reason in lost} == {
        "MuJoCo knows no restitution: nothing bounces",
        "one is one triangle",
    }


@pytest.fixture
def empty() -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.Xform.Define(stage, "/World")
    return stage


def test_what_physx_cannot_do_is_said(
    make: SimpleNamespace, empty: Usd.Stage, tmp_path: Path
) -> None:
    round_thing = (Shape("hull", make.prism(0.1, 0.1, 40), make.contact(0.4)),)
    world = World((make.block("B", np.zeros(3), link={"shapes": round_thing}), make.cabinet(0, 2)))
    lost = write_usdphysics(empty, world, tmp_path)
    assert [(path, reason) for path, _, reason in lost] == [
        ("/World/B/hull", "PhysX keeps 64 of the 80 points of its hull"),
        ("/World/C", "PhysX has no dry friction for door, which holds on to the world"),
        ("/World/C", "PhysX has no dry friction for drawer, which holds on to the world"),
    ]


def test_foreign_units_are_said(empty: Usd.Stage, tmp_path: Path) -> None:
    UsdGeom.SetStageMetersPerUnit(empty, 0.01)
    lost = write_usdphysics(empty, World(()), tmp_path)
    assert [reason for _, _, reason in lost] == ["its units stay 0.01 m and 1 kg"]


def test_a_hinge_without_limits_turns_for_ever(make: SimpleNamespace, tmp_path: Path) -> None:
    from orusd_urdf.urdf import write_urdf

    body = make.cabinet()
    free = replace(body.joints[0], limits=(-np.inf, np.inf))
    write_urdf(World((replace(body, joints=(free, body.joints[1])),)), tmp_path, looks={})
    root = ElementTree.parse(tmp_path / "objects/C/C.urdf").getroot()
    kinds = {joint.get("name"): joint.get("type") for joint in root.iterfind("joint")}
    assert kinds == {"door": "continuous", "drawer": "prismatic"}
