"""URDF files as furniture: where parts are, how they move, and what is refused."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.errors import InputError
from openrooms_usd.library.assets import Model
from openrooms_usd.library.models.meshfile import dependencies, read_model

CUBE = (
    "".join(f"v {x} {y} {z}\n" for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5))
    + "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
)
# A cabinet 0.6 deep that looks along -X: a door on its left edge, a drawer, a knob on the door.
CABINET = """<?xml version="1.0"?>
<robot name="cabinet">
  <link name="base"/>
  <link name="body"><visual name="frame"><geometry>
    <mesh filename="m/cube.obj" scale="0.6 1.0 2.0"/></geometry></visual></link>
  <joint name="to_body" type="fixed">
    <parent link="base"/><child link="body"/><origin xyz="0 0 1"/></joint>
  <link name="door"><visual name="door-1"><origin xyz="0 -0.5 0"/><geometry>
    <mesh filename="package://cabinet/m/cube.obj" scale="0.02 1.0 0.8"/></geometry></visual></link>
  <joint name="door_hinge" type="revolute"><parent link="body"/><child link="door"/>
    <origin xyz="-0.31 0.5 0.5"/><axis xyz="0 0 -2"/><limit lower="0" upper="1.5707963267948966"/>
  </joint>
  <link name="knob"><visual name="knob"><geometry>
    <mesh filename="m/cube.obj" scale="0.04 0.04 0.04"/></geometry></visual></link>
  <joint name="knob_turns" type="continuous"><parent link="door"/><child link="knob"/>
    <origin xyz="-0.03 -0.9 0"/><axis xyz="1 0 0"/></joint>
  <link name="drawer"><visual name="drawer"><geometry>
    <mesh filename="m/cube.obj" scale="0.5 0.9 0.4"/></geometry></visual></link>
  <joint name="rail" type="prismatic"><parent link="body"/><child link="drawer"/>
    <origin xyz="-0.06 0 -0.5" rpy="0 0 3.141592653589793"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.4"/></joint>
</robot>
"""


def written(folder: Path, text: str = CABINET) -> Path:
    (folder / "m").mkdir(parents=True, exist_ok=True)
    (folder / "m/cube.obj").write_text(CUBE)
    (folder / "cabinet.urdf").write_text(text)
    return folder / "cabinet.urdf"


def middle(model: Model, part: str) -> np.ndarray:
    return np.asarray(model.parts[part].extent.mean(axis=0))


def test_visuals_have_the_colours_that_the_file_says(tmp_path: Path) -> None:
    named = '<material name="wood"><color rgba="0 0.5 1 1"/></material>'
    text = CABINET.replace("<link name", f"{named}<link name", 1).replace(
        "</geometry></visual>", '</geometry><material name="wood"/></visual>', 1
    )
    surfaces = read_model(written(tmp_path, text)).surfaces
    assert list(surfaces) == ["frame"]
    np.testing.assert_allclose(surfaces["frame"].base_color, [0.0, 0.214, 1.0], atol=0.001)


def test_the_front_is_where_it_opens_to(tmp_path: Path) -> None:
    model = read_model(written(tmp_path))
    # Depth comes along our Y, the door in front at -Y, its hinge on the right of who looks at it.
    low, high = model.extent
    np.testing.assert_allclose(high - low, [1.0, 0.66, 2.0], atol=1e-9)
    assert middle(model, "door_1")[1] < middle(model, "frame")[1]


def test_joints_move_their_parts_as_the_file_says(tmp_path: Path) -> None:
    model = read_model(written(tmp_path))
    door, drawer = model.joints
    assert (door.kind, drawer.kind) == ("hinge", "rail")
    assert door.meshes == ("door_1", "knob")
    assert drawer.meshes == ("drawer",)
    assert door.limits == pytest.approx((0.0, 90.0))
    assert drawer.limits == pytest.approx((0.0, 0.4))
    # Closed the door lies along the front; opened by 90 degrees it stands out of it.
    turn = Rotation.from_rotvec(np.radians(90.0) * np.array(door.axis))
    opened = turn.apply(middle(model, "door_1") - door.origin) + door.origin
    np.testing.assert_allclose(opened - door.origin, [0.0, -0.5, 0.0], atol=1e-9)
    # The joint's frame is turned by half a turn: its +X is the cabinet's -X, our -Y.
    np.testing.assert_allclose(drawer.axis, [0.0, -1.0, 0.0], atol=1e-9)


def test_a_part_that_moves_on_a_moving_part_is_fixed_to_it_and_said(tmp_path: Path) -> None:
    notes = " ".join(read_model(written(tmp_path)).notes)
    assert "1 joints (such as 'knob_turns') move against parts that move" in notes


def test_joints_are_stretched_with_the_object(tmp_path: Path) -> None:
    own = read_model(written(tmp_path))
    model = read_model(written(tmp_path), size=(2.0, 1.32, 1.0))
    factor = np.array([2.0, 2.0, 0.5])
    for before, after in zip(own.joints, model.joints, strict=True):
        np.testing.assert_allclose(after.origin, factor * before.origin, atol=1e-9)
        np.testing.assert_allclose(after.axis, before.axis, atol=1e-9)
    assert model.joints[0].limits == pytest.approx((0.0, 90.0))
    assert model.joints[1].limits == pytest.approx((0.0, 0.8))


def test_without_anything_that_opens_the_front_is_that_of_robots(tmp_path: Path) -> None:
    still = CABINET.replace('"revolute"', '"fixed"').replace('"prismatic"', '"fixed"')
    model = read_model(written(tmp_path, still.replace('"continuous"', '"fixed"')))
    assert model.joints == ()
    assert middle(model, "door_1")[1] > middle(model, "frame")[1]


def test_its_meshes_are_its_dependencies(tmp_path: Path) -> None:
    assert dependencies(written(tmp_path)) == [(tmp_path / "m/cube.obj").resolve()]


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("<robot", '<!DOCTYPE x [<!ENTITY a "b">]>\n<robot', "DOCTYPE"),
        ("</robot>", "", "not readable XML"),
        ("robot", "model", "not <robot>"),
        ("m/cube.obj", "../../secret.obj", "missing"),
        ("m/cube.obj", "m/none.obj", "missing"),
        ("m/cube.obj", "cabinet.urdf", "cannot be read"),
        ('<parent link="base"/>', '<parent link="door"/>', "form a loop"),
        ('<parent link="base"/>', '<parent link="nobody"/>', "missing"),
        ('<child link="body"/>', "", "no link"),
        ('xyz="0 0 1"', 'xyz="0 0 nan"', "numbers"),
        ('xyz="0 0 1"', 'xyz="0 0"', "not 3 numbers"),
        ('xyz="0 0 -2"', 'xyz="0 0 0"', "no length"),
        ('scale="0.02 1.0 0.8"', 'scale="0 1 1"', "scale"),
    ],
)
def test_what_cannot_be_trusted_is_refused(old: str, new: str, reason: str, tmp_path: Path) -> None:
    (tmp_path / "secret.obj").write_text(CUBE)
    path = written(tmp_path / "package/urdf", CABINET.replace(old, new))
    with pytest.raises(InputError, match=reason) as refused:
        read_model(path)
    assert "remedy" in str(refused.value)


def test_nesting_cannot_exhaust_the_parser(tmp_path: Path) -> None:
    deep = f'<robot name="a">{"<b>" * 5000}{"</b>" * 5000}</robot>'
    with pytest.raises(InputError, match="nested deeper"):
        read_model(written(tmp_path, deep))


def test_meshes_of_a_package_lie_beside_its_folder_of_descriptions(tmp_path: Path) -> None:
    path = written(tmp_path / "package/urdf")
    (tmp_path / "package/urdf/m").rename(tmp_path / "package/m")
    assert len(read_model(path).parts) == 4


def test_a_real_object_of_partnet_mobility(real: Callable[[str], Path]) -> None:
    """A remote control: 57 buttons that slide into its top by 5 mm, lying where its boxes say."""
    path = real("partnet_mobility/100809/mobility.urdf")
    model = read_model(path)
    assert len(model.joints) == 57
    assert {joint.kind for joint in model.joints} == {"rail"}
    assert all(joint.limits == pytest.approx((0.0, 0.005)) for joint in model.joints)
    # Its bounding_box.json: 0.4939 x 1.8997 x 0.1900, Y up there.
    np.testing.assert_allclose(np.ptp(model.extent, axis=0), [0.4939, 0.19, 1.8997], atol=1e-3)
    assert sum(len(joint.meshes) for joint in model.joints) < len(model.parts)
