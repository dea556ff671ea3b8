"""What no engine can hold is refused, with the prim that is to blame."""

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from openrooms_usd.errors import StageError
from openrooms_usd.physics.mass import MassProperties
from openrooms_usd.physics.world import Body, Contact, Joint, Shape, World
from orusd_urdf.checking import check_world

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
    "mass is no number": (with_mass(np.nan, (1, 1, 1)), "no number"),
    "negative moment": (with_mass(1.0, (-1, 1, 1)), "a principal moment"),
    "impossible moments": (with_mass(1.0, (1, 1, 3)), "above the sum of the others"),
    "moving without mass": (lambda m: m.block("B", X, link={"mass": None}), "has no mass"),
    "flat collider": (with_shape(np.array(CUBE) * [1, 1, 0]), "has no volume"),
    "inverted collider": (with_shape(np.array(CUBE) * [1, 1, -1]), "has no volume"),
    "collider of no numbers": (with_shape(np.full((8, 3), np.inf)), "no number"),
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
        ({"axis": 2 * X}, "no unit vector"),
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
