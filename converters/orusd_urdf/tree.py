"""Bodies as the tree that MuJoCo simulates: nested bodies, joints, inertia and geoms."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import PurePosixPath
from typing import Final, NamedTuple
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.engines import DEFAULT_TIMESTEP, Friction
from openrooms_usd.geometry.quaternions import quaternion
from openrooms_usd.physics.mass import MassProperties
from openrooms_usd.physics.world import Body, Joint, Link, Shape, Visual
from orusd_urdf.assets import Assets
from orusd_urdf.boxes import as_box
from orusd_urdf.checking import moving_links, sturdy_inertia
from orusd_urdf.frames import place, relative, text
from orusd_urdf.looks import PLAIN, Loss, RobotMaterial
from orusd_urdf.naming import safe
from orusd_urdf.robot import ENDLESS, coefficient
from orusd_urdf.springs import extra_damping

# Hinges that are a ball together.
_BALL: Final = 3
_KINDS: Final = {"hinge": "hinge", "rail": "slide"}
_STIFF: Final = "its spring is damped more: it is too stiff for the steps"
# MuJoCo makes a tetrahedron of every mesh, also of those that it only draws.
_FEWEST_POINTS: Final = 4


class ContactSurface(NamedTuple):
    """A geom that collides.

    Attributes:
        geom: Its name.
        body: The name of its body.
        link: That of its link's element.
        room: Whether that is the room.
        moves: Whether it can.
        friction: Its coefficient.
        bounds: (2, 3) its least and greatest corner in the world, where it stands at first.
    """

    geom: str
    body: str
    link: str
    room: bool
    moves: bool
    friction: float
    bounds: Array


def link_name(body: Body, link: Link) -> str:
    """The name of a link's ``<body>``: that of its body for the base; no other has a dot."""
    base = link.name == body.links[0].name
    return safe(body.name) if base else f"{safe(body.name)}.{safe(link.name)}"


def joint_name(body: Body, joint: Joint) -> str:
    """The name of a joint."""
    return f"{safe(body.name)}.{safe(joint.name)}"


def ball_name(body: Body, first: Joint) -> str:
    """The name of three hinges that are a ball: that of the first says about which axis."""
    return re.sub(r"_rot[XYZ](_\d+)?$", "", joint_name(body, first))


def joined(body: Body) -> Iterator[tuple[Joint, ...]]:
    """The joints of every link that has some above it, in their order from its parent on."""
    between = {link.name for link in body.links if link.between}
    above: dict[str, tuple[Joint, ...]] = {}
    for joint in body.joints:
        steps = (*above.pop(joint.parent, ()), joint)
        if joint.child in between:
            above[joint.child] = steps
        else:
            yield steps


def is_ball(joints: Sequence[Joint], joint: Joint) -> bool:
    """Whether a joint, with the two that follow it, turns freely about all axes."""
    free = [
        one
        for one in joints
        if one.kind == "hinge" and not np.isfinite(one.limits).any() and one.drive is None
    ]
    alike = len({(one.damping, one.friction) for one in free}) == 1
    return len(free) == _BALL and alike and not joint.friction and joint is free[0]


def written(joints: Sequence[Joint]) -> Iterator[Joint]:
    """The joints that MJCF has elements of: not those that follow the first one of a ball."""
    left = 0
    for joint in joints:
        left = _BALL if is_ball(joints, joint) else max(left - 1, 0)
        if joint.kind != "fixed" and left in (0, _BALL):
            yield joint


@dataclass
class Tree:
    """Builds the elements of a scene.

    Attributes:
        assets: Receives meshes and pictures.
        looks: What materials look like, by their paths; None for nothing to look at.
        friction: Which coefficient of each surface counts.
        surfaces: Every geom that collides, in order.
        prims: The prim of every body, joint and geom, by its name.
        losses: What could not be kept.
        drives: Motors of joints.
        timestep: Seconds of one step of the engine.
    """

    assets: Assets
    looks: Mapping[str, RobotMaterial] | None
    friction: Friction
    timestep: float = DEFAULT_TIMESTEP
    surfaces: list[ContactSurface] = field(default_factory=list)
    prims: dict[str, dict[str, str]] = field(
        default_factory=lambda: {"bodies": {}, "joints": {}, "geoms": {}}
    )
    losses: list[Loss] = field(default_factory=list)
    drives: list[Element] = field(default_factory=list)
    _meshes: dict[PurePosixPath, str] = field(default_factory=dict)

    def body(self, body: Body) -> Element:
        """A body with all links below its base."""
        links = {link.name: link for link in body.links}
        elements = {
            name: self._link(body, link) for name, link in links.items() if not link.between
        }
        base = elements[body.links[0].name]
        _set_place(base, body.world_from_body)
        if not body.fixed:
            base.insert(0, Element("freejoint", name=safe(body.name)))
        for joints in joined(body):
            parent, child = links[joints[0].parent], links[joints[-1].child]
            _set_place(elements[child.name], relative(parent.body_from_link, child.body_from_link))
            for row, joint in enumerate(written(joints)):
                ball = is_ball(joints, joint)
                name = ball_name(body, joint) if ball else joint_name(body, joint)
                extra = extra_damping(body, joint, self.timestep)
                if extra:
                    self.losses.append((child.path, "approximated", _STIFF))
                damped = replace(joint, damping=joint.damping + extra)
                elements[child.name].insert(row, _joint(damped, name, ball))
                self.prims["joints"][name] = child.path
                self.drives.extend(_drive(damped, name, joint.damping))
            elements[parent.name].append(elements[child.name])
        return base

    def asset(self) -> Element:
        """The meshes, pictures and materials of all bodies so far."""
        element = Element("asset")
        textures: dict[PurePosixPath, str] = {}
        for material, look, picture in self.assets.materials:
            values = {"name": material, "rgba": place([*look.color, look.opacity])}
            if picture is not None:
                values["texture"] = textures.setdefault(picture, picture.stem)
            values |= {"roughness": place(look.roughness), "metallic": place(look.metallic)}
            SubElement(element, "material", values)
        for file, name in textures.items():
            SubElement(element, "texture", name=name, type="2d", file=str(file))
        for file, inertia in self._meshes.items():
            SubElement(element, "mesh", name=file.stem, file=str(file), inertia=inertia)
        return element

    def _link(self, body: Body, link: Link) -> Element:
        name = link_name(body, link)
        self.prims["bodies"][name] = link.path
        element = Element("body", name=name)
        if link.mass is not None:
            element.append(_inertial(link.mass))
        moves = link.name in moving_links(body)
        for shape in link.shapes:
            geom = f"{name}.{safe(shape.name)}"
            self.prims["geoms"][geom] = f"{link.path}/{shape.name}"
            factor = coefficient(shape.contact, self.friction)
            bounds = _bounds(shape, body.world_from_body @ link.body_from_link)
            room = body.path == names.ROOM
            self.surfaces.append(ContactSurface(geom, body.name, name, room, moves, factor, bounds))
            element.append(self._collision(shape, geom, body.name, factor))
        if self.looks is not None:
            element.extend(self._visuals(link, name, body.name, self.looks))
        return element

    def _collision(self, shape: Shape, name: str, body: str, friction: float) -> Element:
        element = Element("geom", {"class": "collision", "name": name})
        box = as_box(shape.mesh)
        if box is not None:
            element.set("type", "box")
            element.set("size", place(box.size / 2.0))
            _set_place(element, box.frame)
        else:
            file = self.assets.collision(f"{body}_{shape.name}", shape.mesh)
            element.set("type", "mesh")
            element.set("mesh", self._mesh(file, "convex"))
        element.set("friction", text(friction))
        return element

    def _visuals(
        self, link: Link, name: str, body: str, looks: Mapping[str, RobotMaterial]
    ) -> Iterator[Element]:
        for visual in link.visuals:
            if len(np.unique(visual.mesh.triangles)) < _FEWEST_POINTS:
                self.losses.append((link.path, "approximated", f"{visual.name} is one triangle"))
                continue
            yield self._visual(visual, f"{name}:{safe(visual.name)}", body, looks)

    def _visual(
        self, visual: Visual, name: str, body: str, looks: Mapping[str, RobotMaterial]
    ) -> Element:
        look = looks.get(visual.material, PLAIN)
        file = self.assets.visual(f"{body}_{visual.name}", visual, look)
        return Element(
            "geom",
            {
                "class": "visual",
                "name": name,
                "mesh": self._mesh(file, "shell"),
                "material": self.assets.material(look, visual.material),
            },
        )

    def _mesh(self, file: PurePosixPath, inertia: str) -> str:
        # MuJoCo wants to know the inertia of meshes that give none to anything: one that it can
        # compute for sheets and for hulls.
        self._meshes.setdefault(file, inertia)
        return file.stem


def _bounds(shape: Shape, M: Array) -> Array:
    points = shape.mesh.points @ M[:3, :3].T + M[:3, 3]
    return np.stack([points.min(axis=0), points.max(axis=0)])


def _joint(joint: Joint, name: str, ball: bool) -> Element:
    element = Element("joint", name=name, type="ball" if ball else _KINDS[joint.kind])
    if not ball:
        element.set("axis", place(joint.axis))
    if np.isfinite(joint.limits).any():
        element.set("range", text(np.clip(joint.limits, -ENDLESS, ENDLESS)))
    drive = joint.drive
    if drive and np.isfinite(drive.force):
        # The motor damps, so that it never gives more than it can.
        element.set("damping", "0")
    else:
        element.set("damping", text(joint.damping))
    if drive and drive.stiffness and np.isinf(drive.force):
        element.set("stiffness", text(drive.stiffness))
        element.set("springref", text(drive.target))
    element.set("frictionloss", text(joint.friction))
    return element


def _drive(joint: Joint, name: str, gain: float) -> Iterator[Element]:
    """What a spring and a damper cannot do: draw to a speed, or give no more than so much.

    Args:
        joint: With what damps it in steps.
        name: Its name.
        gain: What its drive's speed is multiplied with.
    """
    drive = joint.drive
    if drive is None or (np.isinf(drive.force) and not drive.speed):
        return
    push = gain * drive.speed
    bias = [push, 0.0, 0.0]
    if np.isfinite(drive.force):
        bias = [push + drive.stiffness * drive.target, -drive.stiffness, -joint.damping]
    element = Element("general", name=name, joint=name, gainprm="0", biastype="affine")
    element.set("biasprm", text(bias))
    if np.isfinite(drive.force):
        element.set("forcerange", text([-drive.force, drive.force]))
    yield element


def _inertial(mass: MassProperties) -> Element:
    tensor = sturdy_inertia(mass)
    six = [tensor[row, column] for row, column in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    return Element("inertial", pos=text(mass.centre), mass=text(mass.mass), fullinertia=text(six))


def _set_place(element: Element, frame: Array) -> None:
    element.set("pos", place(frame[:3, 3]))
    # MuJoCo has the real part first.
    element.set("quat", text(np.round(np.roll(quaternion(frame[:3, :3]), 1), 15)))
