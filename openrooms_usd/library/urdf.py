"""Reads URDF files: articulated objects whose doors and drawers keep their joints.

URDF (Unified Robot Description Format, wiki.ros.org/urdf/XML): links with visuals, and joints that
make a tree of them; metres, radians, Z up. PartNet-Mobility describes its objects so. Robots look
along +X; furniture of PartNet-Mobility along -X: the front is where doors and drawers open to.
"""

import math
import os
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final, Literal
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.library.pieces import ForeignJoint, Piece, Reading
from openrooms_usd.library.plainxml import read_xml
from openrooms_usd.library.urdftree import (
    attribute_of,
    broken,
    foreign_joint,
    link_poses,
    mover_of,
    notes_of,
    read_hold,
    read_numbers,
    read_origin,
)

Array = NDArray[np.float64]
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
        InputError: It is no URDF, or names a mesh that is not there or cannot be read.
    """
    root = _parsed(path)
    links = {attribute_of(link, "name", path): link for link in root.iter("link")}
    if not links or len(links) > _MAX_LINKS:
        raise broken(path, f"it has {len(links)} links")
    holds = {hold.child: hold for hold in (read_hold(joint, path) for joint in root.iter("joint"))}
    poses = link_poses(links, holds, path)
    movers = {name: mover_of(name, holds) for name in links}
    notes = notes_of(holds, movers)
    pieces = []
    for name, link in links.items():
        for visual in link.findall("visual"):
            for piece in _pieces(visual, name, path, read_mesh, notes):
                moved = piece.mesh.transformed(poses[name])
                pieces.append(replace(piece, mesh=moved, link=movers[name] or ""))
    moving = {piece.link for piece in pieces if piece.link}
    joints = tuple(foreign_joint(holds[name], poses[name]) for name in links if name in moving)
    return Reading(pieces, notes, up="Z", front=_front(pieces, joints), joints=joints)


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


def _front(pieces: Sequence[Piece], joints: Sequence[ForeignJoint]) -> Front:
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
) -> Iterator[Piece]:
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
            f"it names the mesh {name[:200]!r}, which is not there",
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
