"""Springs of joints that are stiffer than an engine's steps can follow."""

from typing import Final

from openrooms_usd.arrays import Array
from openrooms_usd.physics.world import Body, Joint, Link

# A spring that is pulled once a step oscillates without end where k h2 > 4 I.
_MOST: Final = 3.0


def extra_damping(body: Body, joint: Joint, timestep: float) -> float:
    """What a joint's spring is damped more, so that steps do not make it swing ever farther.

    It is what an implicit step has by itself, and leaves the place of rest as it is.

    Args:
        body: Its body.
        joint: Any of its joints.
        timestep: Seconds of one step.

    Returns:
        N m s/rad or N s/m; none where the spring is soft enough.
    """
    if joint.drive is None or not joint.drive.stiffness:
        return 0.0
    springs = sum(one.drive is not None and one.drive.stiffness > 0.0 for one in body.joints)
    stiff = timestep**2 * joint.drive.stiffness > _MOST / springs * moved_inertia(body, joint)
    return timestep * joint.drive.stiffness if stiff else 0.0


def moved_inertia(body: Body, joint: Joint) -> float:
    """Of what a joint moves with all others held: kg m2 about its axis, or kg along it."""
    below = {joint.child}
    for one in body.joints:
        if one.parent in below:
            below.add(one.child)
    at = next(link for link in body.links if link.name == joint.child).body_from_link
    axis, point = at[:3, :3] @ joint.axis, at[:3, 3]
    own = sum(_about(link, joint, axis, point) for link in body.links if link.name in below)
    if body.fixed:
        return own
    rest = sum(_about(link, joint, axis, point) for link in body.links if link.name not in below)
    return own * rest / (own + rest)


def _about(link: Link, joint: Joint, axis: Array, point: Array) -> float:
    if link.mass is None:
        return 0.0
    if joint.kind == "rail":
        return link.mass.mass
    placed = link.mass.transformed(link.body_from_link)
    return float(axis @ placed.about(point) @ axis)
