"""Reads URDF files: articulated objects whose doors and drawers keep their joints.

URDF (Unified Robot Description Format, wiki.ros.org/urdf/XML): links with visuals, and joints that
make a tree of them; metres, radians, Z up. PartNet-Mobility describes its objects so. Robots look
along +X; furniture of PartNet-Mobility along -X: the front is where doors and drawers open to.
"""

import math
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Literal
from xml.etree.ElementTree import Element

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.errors import InputError
from openrooms_usd.library.models.pieces import ForeignJoint, ModelPart, Reading, colored
from openrooms_usd.library.models.plainxml import read_xml

_MAX_COORDINATE_M: Final = 1e4
_MOVING: Final[Mapping[str, Literal["hinge", "rail"]]] = {
    "revolute": "hinge",
    "continuous": "hinge",
    "prismatic": "rail",
}
# A hinge without limits turns all round.
_ROUND_DEG: Final = (-180.0, 180.0)


@dataclass(frozen=True, eq=False)
class Hold:
    """A joint, as the file has it.

    Attributes:
        name: Its own.
        kind: Its type.
        parent: The link that holds the child.
        child: The link that it holds.
        parent_from_child: (4, 4) at zero.
        axis: (3,) unit vector in the child's frame.
        limits: Lower and upper, radians or metres; None where there are none.
    """

    name: str
    kind: str
    parent: str
    child: str
    parent_from_child: Array
    axis: Array
    limits: tuple[float, float] | None


def read_hold(joint: Element, path: Path) -> Hold:
    """Read a ``joint`` element.

    Raises:
        InputError: It names no links, or holds no numbers where they should be.
    """
    axis = joint.find("axis")
    along = read_numbers(None if axis is None else axis.get("xyz"), (1.0, 0.0, 0.0), path)
    length = float(np.linalg.norm(along))
    kind = attribute_of(joint, "type", path)
    if kind in _MOVING and length < 1e-9:
        raise broken(path, f"the axis of the joint {joint.get('name', '')[:60]!r} has no length")
    limit = joint.find("limit")
    limits = None
    if limit is not None and kind != "continuous":
        low, high = (read_numbers(limit.get(k), (0.0,), path)[0] for k in ("lower", "upper"))
        limits = (float(min(low, high)), float(max(low, high)))
    return Hold(
        joint.get("name", ""),
        kind,
        attribute_of(joint.find("parent"), "link", path),
        attribute_of(joint.find("child"), "link", path),
        read_origin(joint, path),
        along / max(length, 1e-9),
        limits,
    )


def link_poses(
    links: Mapping[str, Element], holds: Mapping[str, Hold], path: Path
) -> dict[str, Array]:
    """(4, 4) each link's frame in the root's, while all joints are at zero."""
    poses: dict[str, Array] = {}
    for name in links:
        pose, link, seen = np.eye(4), name, {name}
        while (hold := holds.get(link)) is not None:
            pose, link = hold.parent_from_child @ pose, hold.parent
            if link not in links:
                raise broken(path, f"the joint {hold.name[:60]!r} names a missing link")
            if link in seen:
                raise broken(path, f"its joints form a loop at {link[:60]!r}")
            seen.add(link)
        poses[name] = pose
    return poses


def mover_of(name: str, holds: Mapping[str, Hold]) -> str | None:
    """The link nearest to the root that moves, on the way to a link; None where none does."""
    found, link = None, name
    while (hold := holds.get(link)) is not None:
        if hold.kind in _MOVING:
            found = link
        link = hold.parent
    return found


def notes_of(holds: Mapping[str, Hold], movers: Mapping[str, str | None]) -> list[str]:
    """A sentence for each kind of joint that does not move as the file says."""
    carried = [h for h in holds.values() if h.kind in _MOVING and movers.get(h.child) != h.child]
    other = {h.kind for h in holds.values()} - {*_MOVING, "fixed"}
    notes = []
    if carried:
        notes.append(
            f"{len(carried)} joints (such as {carried[0].name[:60]!r}) move against parts that "
            "move: they are fixed to these"
        )
    if other:
        kinds = ", ".join(sorted(kind[:20] for kind in other))
        notes.append(f"joints of the types {kinds} are fixed here")
    return notes


def foreign_joint(hold: Hold, pose: Array) -> ForeignJoint:
    """The joint of a part that moves, in the frame of the root.

    Args:
        hold: As the file has it.
        pose: (4, 4) the part's frame in the root's, while all joints are at zero.
    """
    kind = _MOVING[hold.kind]
    if kind == "hinge":
        limits = _ROUND_DEG
        if hold.limits is not None:
            limits = (math.degrees(hold.limits[0]), math.degrees(hold.limits[1]))
    else:
        limits = hold.limits or (0.0, 0.0)
    return ForeignJoint(hold.child, kind, pose[:3, 3], pose[:3, :3] @ hold.axis, limits)


def read_origin(element: Element, path: Path) -> Array:
    """(4, 4) the pose in an element's ``origin``: fixed axes, first about X, then Y, then Z."""
    from scipy.spatial.transform import Rotation

    found = element.find("origin")
    pose = np.eye(4)
    if found is not None:
        turn = read_numbers(found.get("rpy"), (0.0, 0.0, 0.0), path)
        pose[:3, :3] = Rotation.from_euler("xyz", turn).as_matrix()
        pose[:3, 3] = read_numbers(found.get("xyz"), (0.0, 0.0, 0.0), path)
    return pose


def read_numbers(text: str | None, default: tuple[float, ...], path: Path) -> Array:
    """The numbers of an attribute, as many as its default has.

    Raises:
        InputError: They are others, or absurd.
    """
    if text is None:
        return np.array(default)
    try:
        values = np.array([float(word) for word in text.split()])
    except ValueError as error:
        raise broken(path, f"{text[:60]!r} are not numbers") from error
    if len(values) != len(default) or not (np.abs(values) <= _MAX_COORDINATE_M).all():
        raise broken(path, f"{text[:60]!r} are not {len(default)} numbers of a usual size")
    return values


def attribute_of(element: Element | None, name: str, path: Path) -> str:
    """An attribute that must be there.

    Raises:
        InputError: It is not.
    """
    value = None if element is None else element.get(name)
    if not value:
        what = "a part" if element is None else f"a <{element.tag}>"
        raise broken(path, f"{what} has no {name}")
    return value


def broken(path: Path, reason: str) -> InputError:
    """The error of a file that cannot be used."""
    return InputError(
        f"the URDF file cannot be used: {reason}", place=path, remedy="export the object again"
    )


ReadMesh = Callable[[Path], Reading]

_MAX_LINKS: Final = 10_000
# What opens by less than this part of the object, such as a button, tells no front.
_OPENS_SHARE: Final = 0.1
Front = Literal["+X", "-X", "+Y", "-Y"]
_FRONTS: Final[tuple[tuple[Front, Front], ...]] = (("-X", "+X"), ("-Y", "+Y"))
# A prefix of files that a ROS package holds: the package's name follows.
_PACKAGE: Final = re.compile(r"package://[^/]+/")


def read_urdf(path: Path, read_mesh: ReadMesh) -> Reading:
    """Read a URDF file: every visual is a piece, where it is while all joints are at zero.

    Args:
        path: The file. Meshes are looked for below its folder and, as packages have them, below
            the folder above.
        read_mesh: Reads a mesh file, in its own frame and unit.

    Raises:
        InputError: It is not a URDF file, or names a mesh that is missing or cannot be read.
    """
    root = _parsed(path)
    links = {attribute_of(link, "name", path): link for link in root.iter("link")}
    if not links or len(links) > _MAX_LINKS:
        raise broken(path, f"it has {len(links)} links")
    holds = {hold.child: hold for hold in (read_hold(joint, path) for joint in root.iter("joint"))}
    poses = link_poses(links, holds, path)
    movers = {name: mover_of(name, holds) for name in links}
    notes = notes_of(holds, movers)
    colors = {
        m.get("name"): color
        for m in root.iter("material")
        if (color := m.find("color")) is not None
    }
    pieces = []
    for name, link in links.items():
        for visual in link.findall("visual"):
            for piece in _pieces(visual, name, path, read_mesh, notes):
                moved = piece.mesh.transformed(poses[name])
                shown = _in_color(piece, visual, colors, path)
                pieces.append(replace(shown, mesh=moved, link=movers[name] or ""))
    moving = {piece.link for piece in pieces if piece.link}
    joints = tuple(foreign_joint(holds[name], poses[name]) for name in links if name in moving)
    return Reading(pieces, notes, up="Z", front=_front(pieces, joints), joints=joints)


def _in_color(
    piece: ModelPart, visual: Element, colors: Mapping[str | None, Element], path: Path
) -> ModelPart:
    """A piece in the colour that its visual says, where its mesh file has no material for it."""
    material = visual.find("material")
    if material is None or piece.surface is not None:
        return piece
    color = material.find("color")
    color = colors.get(material.get("name")) if color is None else color
    if color is None:
        return piece
    rgba = read_numbers(color.get("rgba"), (0.8, 0.8, 0.8, 1.0), path)
    return replace(piece, surface=colored("", None, linear_from_srgb(rgba[None, :3]), []))


def meshes_of(path: Path) -> Iterator[Path]:
    """The mesh files that a URDF file names, as far as they are there."""
    for mesh in _parsed(path).iter("mesh"):
        found = _located(path, mesh.get("filename", ""))
        if found is not None:
            yield found


def _parsed(path: Path) -> Element:
    root = read_xml(path, "URDF")
    if root.tag != "robot":
        raise broken(path, f"its root is <{root.tag[:40]}>, not <robot>")
    return root


def _front(pieces: Sequence[ModelPart], joints: Sequence[ForeignJoint]) -> Front:
    """Where most of what opens moves to; +X where little moves sideways."""
    points = np.concatenate([piece.mesh.points for piece in pieces] or [np.zeros((1, 3))])
    moved = np.zeros(2)
    for joint in joints:
        own = np.concatenate([p.mesh.points for p in pieces if p.link == joint.link])
        moved += _opening_motion(joint, own.mean(axis=0))[:2]
    axis = int(np.argmax(np.abs(moved)))
    if abs(moved[axis]) < _OPENS_SHARE * float(np.ptp(points, axis=0).max()):
        return "+X"
    return _FRONTS[axis][int(moved[axis] > 0.0)]


def _opening_motion(joint: ForeignJoint, point: Array) -> Array:
    """(3,) how a point moves while a joint goes to its farther limit, a hinge to 90 degrees."""
    from scipy.spatial.transform import Rotation

    farther = max(joint.limits, key=abs)
    if joint.kind == "rail":
        return np.asarray(farther * joint.axis)
    turn = Rotation.from_rotvec(math.radians(float(np.clip(farther, -90.0, 90.0))) * joint.axis)
    arm = point - joint.origin
    return np.asarray(turn.apply(arm) - arm)


def _pieces(
    visual: Element, link: str, path: Path, read_mesh: ReadMesh, notes: list[str]
) -> Iterator[ModelPart]:
    """A visual as pieces in the frame of its link."""
    geometry = visual.find("geometry")
    mesh = None if geometry is None else geometry.find("mesh")
    title = visual.get("name") or link
    if mesh is None:
        kinds = [] if geometry is None else [child.tag for child in geometry]
        notes.append(f"{title}: {', '.join(kinds)[:40] or 'a visual without geometry'} is left out")
        return
    name = attribute_of(mesh, "filename", path)
    file = _located(path, name)
    if file is None:
        raise InputError(
            f"it names the mesh {name[:200]!r}, which is missing",
            place=path,
            remedy="copy it below the folder of the URDF file",
        )
    scale = read_numbers(mesh.get("scale"), (1.0, 1.0, 1.0), path)
    if not scale.all():
        raise broken(path, f"the scale of {title[:60]!r} is zero")
    pose = read_origin(visual, path) @ np.diag([*scale, 1.0])
    reading = read_mesh(file)
    notes += [note for note in reading.notes if note not in notes]
    for piece in reading.pieces:
        yield replace(piece, title=title, mesh=piece.mesh.transformed(pose))


def _located(path: Path, name: str) -> Path | None:
    """The file of a mesh; None where it is missing, or neither below the folder nor its package."""
    plain = _PACKAGE.sub("", name.replace("\\", "/")).removeprefix("file://")
    own = path.resolve().parent
    for folder in (own, own.parent):
        target = Path(os.path.normpath(folder / plain))
        try:
            untrusted.check_path(target)
            inside = target.resolve().is_relative_to(own.parent)
        except (InputError, OSError, RuntimeError):
            continue
        if inside and target.is_file():
            return target
    return None
