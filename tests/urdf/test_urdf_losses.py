"""What no engine can hold is refused; what a format or an engine cannot do is said."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from openrooms_usd.errors import StageError
from openrooms_usd.physics.mass import MassProperties
from openrooms_usd.physics.world import Body, Contact, Drive, Joint, Shape, Visual, World
from orusd_urdf import mjcf
from orusd_urdf.checking import check_world
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
    assert "do not touch initially" in reason and explicit(tmp_path / "more") == stands
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
        "MuJoCo has no restitution: nothing bounces",
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


def test_a_spring_is_lost_in_urdf_and_that_is_said(make: SimpleNamespace, tmp_path: Path) -> None:
    from orusd_urdf.urdf import write_urdf

    body = make.cabinet()
    held = replace(body.joints[0], drive=Drive(stiffness=1000.0))
    lost = write_urdf(World((replace(body, joints=(held, body.joints[1])),)), tmp_path, looks={})
    said = "its drive is lost except for the damping"
    assert lost == [("/World/C/Door", "approximated", said)]


X = np.array([1.0, 0.0, 0.0])


def with_mass(mass: float, moments: tuple[float, float, float]) -> Callable[..., Body]:
    given = MassProperties(mass, np.zeros(3), np.diag(moments))
    return lambda make: make.block("B", np.zeros(3), link={"mass": given})


def with_shape(points: object) -> Callable[..., Body]:
    def build(make: SimpleNamespace) -> Body:
        flat = make.mesh(np.array(points, dtype=float), make.box((1.0, 1.0, 1.0)).triangles)
        return make.block("B", np.zeros(3), link={"shapes": (Shape("s", flat, Contact(1, 1)),)})

    return build


def with_joints(*ends: tuple[str, str]) -> Callable[..., Body]:
    def build(make: SimpleNamespace) -> Body:
        joints = [
            Joint(f"j{i}", "hinge", parent, child, X, (0.0, 1.0))
            for i, (parent, child) in enumerate(ends)
        ]
        return replace(make.cabinet(), joints=tuple(joints))

    return build


CUBE = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
BAD: dict[str, tuple[Callable[..., Body], str]] = {
    "negative mass": (with_mass(-1.0, (1, 1, 1)), "a mass of -1 kg"),
    "no mass at all": (with_mass(0.0, (1, 1, 1)), "a mass of 0 kg"),
    "mass is not finite": (with_mass(np.nan, (1, 1, 1)), "not finite"),
    "negative moment": (with_mass(1.0, (-1, 1, 1)), "a principal moment"),
    "impossible moments": (with_mass(1.0, (1, 1, 3)), "above the sum of the others"),
    "moving without mass": (lambda m: m.block("B", X, link={"mass": None}), "has no mass"),
    "flat collider": (with_shape(np.array(CUBE) * [1, 1, 0]), "has no volume"),
    "inverted collider": (with_shape(np.array(CUBE) * [1, 1, -1]), "has no volume"),
    "collider of no numbers": (with_shape(np.full((8, 3), np.inf)), "not finite"),
    "scaled frame": (lambda m: m.block("B", X, turn=2 * np.eye(3)), "not rigid"),
    "mirrored frame": (lambda m: m.block("B", X, turn=np.diag([1, 1, -1])), "not rigid"),
    "loop": (with_joints(("Body", "Door"), ("Drawer", "Door"), ("Door", "Drawer")), "a loop"),
    "ring": (with_joints(("Drawer", "Door"), ("Door", "Drawer")), "a loop"),
    "back to the base": (with_joints(("Body", "Door"), ("Door", "Body")), "a loop"),
    "nothing holds it": (with_joints(("Body", "Door")), "no joint holds 'Drawer'"),
    "unknown link": (with_joints(("Body", "Lid")), "no link is named 'Lid'"),
}


@pytest.mark.parametrize("kind", list(BAD))
def test_an_impossible_body_is_refused(make: SimpleNamespace, kind: str) -> None:
    build, said = BAD[kind]
    with pytest.raises(StageError, match=said) as caught:
        check_world(World((build(make),)))
    assert caught.value.place and caught.value.place.startswith("/World")
    assert caught.value.remedy


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"axis": 2 * X}, "not a unit vector"),
        ({"limits": (1.0, 0.0)}, "limits 1 to 0"),
        ({"damping": -1.0}, "negative damping"),
    ],
)
def test_an_impossible_joint_is_refused(
    make: SimpleNamespace, change: dict[str, object], said: str
) -> None:
    body = make.cabinet()
    first, *others = body.joints
    with pytest.raises(StageError, match=said):
        check_world(World((replace(body, joints=(replace(first, **change), *others)),)))


def test_negative_friction_is_refused(make: SimpleNamespace) -> None:
    with pytest.raises(StageError, match="negative"):
        check_world(World((make.block("B", X, mu=-0.1),)))


def test_a_thin_sheet_of_glass_is_no_mistake(make: SimpleNamespace) -> None:
    pane = Shape("s", make.box((10.0, 10.0, 0.001)), Contact(1.0, 1.0))
    sheet = MassProperties(250.0, np.zeros(3), np.diag([1.0, 1.0, 2.0 * (1 + 1e-7)]))
    check_world(World((make.block("B", X, link={"shapes": (pane,), "mass": sheet}),)))
    check_world(World((make.cabinet(),)))
