"""A body as the XML of a robot: links with inertia, visuals and colliders, and joints."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import Final
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.engines import Friction
from openrooms_usd.physics import pair
from openrooms_usd.physics.world import Body, Contact, Joint, Link, Shape, Visual
from orusd_urdf.assets import Assets
from orusd_urdf.boxes import as_box
from orusd_urdf.checking import sturdy_inertia
from orusd_urdf.frames import place, relative, rpy, text
from orusd_urdf.looks import PLAIN, RobotMaterial
from orusd_urdf.naming import safe

# URDF wants limits of motors, which a room does not have: more than any hand or robot gives.
_MAX_EFFORT: Final = 1000.0
_MAX_VELOCITY: Final = 100.0
# What stands for no limit where there is another, radians or metres.
ENDLESS: Final = 1e6
_KINDS: Final = {"hinge": "revolute", "rail": "prismatic", "fixed": "fixed"}


def robot_element(
    body: Body,
    assets: Assets,
    looks: Mapping[str, RobotMaterial] | None,
    friction: Friction,
    prefix: str,
) -> Element:
    """A body as ``<robot>``; what it refers to is written.

    Args:
        body: A body that `checking.check_world` lets pass.
        assets: Receives meshes and pictures.
        looks: What materials look like, by their paths; None for nothing to look at.
        friction: Which coefficient of each surface counts.
        prefix: What comes before the name of a file of the assets' folder.
    """
    robot = _Robot(body, assets, looks, friction, prefix)
    root = Element("robot", name=safe(body.name))
    links = [element for link in body.links for element in robot.link(link)]
    root.extend(robot.materials())
    root.extend(links)
    by_name = {link.name: link for link in body.links}
    root.extend(_joint(joint, by_name[joint.parent], by_name[joint.child]) for joint in body.joints)
    return root


@dataclass
class _Robot:
    body: Body
    assets: Assets
    looks: Mapping[str, RobotMaterial] | None
    friction: Friction
    prefix: str
    _used: dict[str, RobotMaterial] = field(default_factory=dict)

    def materials(self) -> list[Element]:
        """The colours of all links, each once, as ROS wants them."""
        elements = []
        for name, look in self._used.items():
            elements.append(Element("material", name=name))
            SubElement(elements[-1], "color", rgba=place([*look.color, look.opacity]))
        return elements

    def link(self, link: Link) -> list[Element]:
        """A link, and one more without mass for every further surface that it collides with.

        URDF has one contact for a link, so that what is made of several things is several links.
        """
        first = Element("link", name=safe(link.name))
        elements, holder = [first], first
        groups = _by_contact(link.shapes)
        for number, (contact, shapes) in enumerate(groups):
            if number:
                # No name of the world has a dot.
                holder = Element("link", name=f"{safe(link.name)}.{number}")
                elements += [holder, _mount(first.get("name", ""), holder.get("name", ""))]
            holder.append(_contact(contact, self.friction))
            holder.append(_inertial(None if number else link))
            holder.extend(self._collision(shape) for shape in shapes)
        if not groups:
            first.append(_inertial(link))
        if self.looks is not None:
            first.extend(self._visual(visual, self.looks) for visual in link.visuals)
        return elements

    def _visual(self, visual: Visual, looks: Mapping[str, RobotMaterial]) -> Element:
        look = looks.get(visual.material, PLAIN)
        file = self.assets.visual(f"{self.body.name}_{visual.name}", visual, look)
        material = self.assets.material(look, visual.material)
        self._used.setdefault(material, look)
        element = Element("visual", name=safe(visual.name))
        self._mesh(element, file)
        SubElement(element, "material", name=material)
        return element

    def _collision(self, shape: Shape) -> Element:
        element = Element("collision", name=safe(shape.name))
        box = as_box(shape.mesh)
        if box is None:
            stem = f"{self.body.name}_{shape.name}"
            self._mesh(element, self.assets.collision(stem, shape.mesh))
            return element
        element.append(_origin(box.frame))
        SubElement(SubElement(element, "geometry"), "box", size=place(box.size))
        return element

    def _mesh(self, element: Element, file: PurePosixPath) -> None:
        geometry = SubElement(element, "geometry")
        SubElement(geometry, "mesh", filename=f"{self.prefix}{file}")


def coefficient(contact: Contact, friction: Friction) -> float:
    """The one of its coefficients that an engine with one of them uses."""
    return contact.static_friction if friction == "static" else contact.dynamic_friction


def _by_contact(shapes: tuple[Shape, ...]) -> list[tuple[Contact, list[Shape]]]:
    """Shapes by what they are made of, in their order."""
    groups: dict[tuple[float, float, float], tuple[Contact, list[Shape]]] = {}
    for shape in shapes:
        contact = shape.contact
        key = contact.static_friction, contact.dynamic_friction, contact.restitution
        groups.setdefault(key, (contact, []))[1].append(shape)
    return list(groups.values())


def _contact(contact: Contact, friction: Friction) -> Element:
    """What Bullet multiplies with the same of the other surface."""
    element = Element("contact")
    values = {
        "lateral_friction": pair.factor(coefficient(contact, friction)),
        "rolling_friction": 0.0,
        "spinning_friction": 0.0,
        "restitution": pair.factor(contact.restitution),
    }
    for tag, value in values.items():
        SubElement(element, tag, value=text(value))
    return element


def _inertial(link: Link | None) -> Element:
    """Mass and inertia about the centre, along the link's axes; none where nothing moves."""
    mass = link.mass if link is not None else None
    element = Element("inertial")
    inertia = np.zeros((3, 3)) if mass is None else sturdy_inertia(mass)
    if mass is not None:
        SubElement(element, "origin", xyz=text(mass.centre), rpy="0 0 0")
    SubElement(element, "mass", value="0" if mass is None else text(mass.mass))
    tensor = {
        f"i{'xyz'[row]}{'xyz'[column]}": text(inertia[row, column])
        for row in range(3)
        for column in range(row, 3)
    }
    SubElement(element, "inertia", tensor)
    return element


def _joint(joint: Joint, parent: Link, child: Link) -> Element:
    low, high = joint.limits
    endless = joint.kind == "hinge" and not (np.isfinite(low) or np.isfinite(high))
    kind = "continuous" if endless else _KINDS[joint.kind]
    element = Element("joint", name=safe(joint.name), type=kind)
    SubElement(element, "parent", link=safe(parent.name))
    SubElement(element, "child", link=safe(child.name))
    element.append(_origin(relative(parent.body_from_link, child.body_from_link)))
    if joint.kind == "fixed":
        return element
    SubElement(element, "axis", xyz=place(joint.axis))
    limit = SubElement(element, "limit", effort=text(_MAX_EFFORT), velocity=text(_MAX_VELOCITY))
    if not endless:
        limit.set("lower", text(max(low, -ENDLESS)))
        limit.set("upper", text(min(high, ENDLESS)))
    SubElement(element, "dynamics", damping=text(joint.damping), friction=text(joint.friction))
    return element


def _mount(parent: str, child: str) -> Element:
    element = Element("joint", name=f"{child}.mount", type="fixed")
    SubElement(element, "parent", link=parent)
    SubElement(element, "child", link=child)
    return element


def _origin(frame: Array) -> Element:
    return Element("origin", xyz=place(frame[:3, 3]), rpy=place(rpy(frame[:3, :3])))
