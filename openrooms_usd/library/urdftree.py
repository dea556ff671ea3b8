"""The tree of a URDF file: how its links hold each other, and which of them move.

What a hinge or rail joins to the root's fixed parts moves; what moves against something that moves
is fixed to that, and said.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.library.pieces import ForeignJoint

Array = NDArray[np.float64]

_MAX_COORDINATE_M: Final = 1e4
_MOVING: Final[Mapping[str, Literal["hinge", "rail"]]] = {
    "revolute": "hinge", "continuous": "hinge", "prismatic": "rail",
}  # fmt: skip
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
                raise broken(path, f"the joint {hold.name[:60]!r} names a link that is not there")
            if link in seen:
                raise broken(path, f"its joints lead round in a circle at {link[:60]!r}")
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
        notes.append(f"joints of the kinds {kinds} do not move here")
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
        raise broken(path, f"{text[:60]!r} are no numbers") from error
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
