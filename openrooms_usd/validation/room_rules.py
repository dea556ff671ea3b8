"""Rules about a room as people see it: things and cameras in it, apart, of usual sizes, and lit.

A stage that breaks them is valid USD, but probably not what its author intended.
"""

from collections.abc import Callable, Iterator
from itertools import islice
from typing import Final, NamedTuple

import numpy as np
from pxr import Usd

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.furniture import category
from openrooms_usd.furniture.registry import BUILT, record
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.scan.placement.bodies import Body
from openrooms_usd.scan.placement.penetration import penetration
from openrooms_usd.validation import carrying
from openrooms_usd.validation.model import Complaint, Subject
from openrooms_usd.validation.roomview import RoomObject, RoomView

# What reaches farther into walls, floor or ceiling stands in them, metres: plaster, skirtings and
# what people measure are off by less.
_MAX_OUTSIDE_M: Final = 0.05
# Things that are deeper in each other overlap, metres; what yields, as cushions do, may be
# deeper by that.
_MAX_OVERLAP_M: Final = 0.02
# Lines a direction on which depths are measured.
_LINES: Final = 600
# Limits of plausible size, as shares of the smallest and the largest size that is built, along any
# side.
_SIZE_SHARES: Final = (0.6, 1.6)
# Sides and heights of rooms, widths and heights of openings beyond these are slips of the unit.
_ROOM_M: Final = (0.5, 60.0)
_HEIGHT_M: Final = (1.5, 15.0)
_WIDTHS_M: Final = (0.15, 12.0)
# Complaints beyond these are counted in a note.
_NAMED: Final = 4
_ALL_WAYS: Final = np.concatenate([np.eye(3), -np.eye(3)])


def outside_room(subject: Subject) -> Iterator[Complaint]:
    """Things and cameras are between the walls, the floor and the ceiling."""
    room = subject.room
    for thing in room.things:
        if (beyond := _beyond(room, thing)) > _MAX_OUTSIDE_M:
            yield thing.path, f"sticks {_cm(beyond)} out of the room"
    for path, place in room.cameras:
        if _beyond_points(room, place[None]) > 0.0:
            yield path, "is a camera outside of the room"


def _beyond(room: RoomView, thing: RoomObject) -> float:
    """How far a thing reaches out of the room, metres."""
    ends = np.stack([thing.low, thing.high])
    box = ends[np.indices((2, 2, 2)).reshape(3, -1).T, np.arange(3)]
    # A room need not be convex: a reflex corner may be inside the box of a thing around it.
    if _beyond_points(room, box) <= _MAX_OUTSIDE_M and not _notched(room, thing):
        return 0.0
    points = thing.points
    for reveal in room.reveals:
        points = points[~reveal.holds(points)]
    return _beyond_points(room, points)


def _beyond_points(room: RoomView, points: Array) -> float:
    import shapely

    if not len(points):
        return 0.0
    out = [0.0]
    if room.outline is not None:
        out.append(float(shapely.distance(room.outline, shapely.points(points[:, :2])).max()))
    if room.floor is not None:
        out.append(room.floor - float(points[:, 2].min()))
    return max(*out, room.above_ceiling(points))


def _notched(room: RoomView, thing: RoomObject) -> bool:
    import shapely

    if room.outline is None:
        return False
    box = shapely.box(*thing.low[:2].tolist(), *thing.high[:2].tolist())
    return not bool(room.outline.covers(box))


def cameras_inside(subject: Subject) -> Iterator[Complaint]:
    """No camera is inside a thing."""
    for path, place in subject.room.cameras:
        for thing in subject.room.things:
            if (place > thing.low).all() and (place < thing.high).all() and _is_in(place, thing):
                yield path, f"is a camera inside of {thing.name}"


def _is_in(place: Array, thing: RoomObject) -> bool:
    """Whether most of the ways out of a thing meet its surface from behind."""
    triangles = thing.body.triangles.reshape(-1, 3)
    caster = RayCaster(triangles, np.arange(len(triangles)).reshape(-1, 3))
    hits = caster.first_hit(place, _ALL_WAYS)
    met = hits.triangle >= 0
    leaving = np.einsum("ij,ij->i", caster.normals[hits.triangle[met]], _ALL_WAYS[met]) > 0.0
    return bool(leaving.sum() > 0.5 * len(_ALL_WAYS))


def overlaps(subject: Subject) -> Iterator[Complaint]:
    """No two things are in each other, nor any in a wall that stands free."""
    return _overlaps(subject.room)


def _overlaps(room: RoomView, only: RoomObject | None = None) -> Iterator[Complaint]:
    """Of all things, or of one of them."""
    for one, other in room.pairs(_MAX_OVERLAP_M):
        if only not in (None, one, other):
            continue
        depth = _depth(one.body, other.body, max(_yields(one), _yields(other)))
        if depth > 0.0:
            first, second = sorted((one, other), key=lambda thing: thing.path)
            yield first.path, f"overlaps {second.name} by {_cm(depth)}"
    for wall in room.partitions:
        body = _body(wall.outline, room.floor or 0.0, wall.height)
        for thing in room.things if only is None else (only,):
            if (depth := _depth(thing.body, body, _yields(thing))) > 0.0:
                yield thing.path, f"overlaps {wall.path.rpartition('/')[2]} by {_cm(depth)}"


def _depth(a: Body, b: Body, yields: float) -> float:
    found = penetration(a, b, _MAX_OVERLAP_M + yields, _LINES)
    return 0.0 if found is None else found.depth


def _yields(thing: RoomObject) -> float:
    """How far a thing gives way, metres."""
    known = record(thing.category)
    return known.collision_softness if known else 0.0


def _body(outline: Array, low: float, height: float) -> Body:
    """A prism over a convex outline (K, 2)."""
    ring = np.column_stack([outline, np.full(len(outline), low)])
    rise = np.array([0.0, 0.0, height])
    top = ring + rise
    after, above = np.roll(ring, -1, axis=0), np.roll(top, -1, axis=0)
    middle = np.broadcast_to(ring.mean(axis=0), ring.shape)
    lid = middle + rise
    faces = [(ring, after, above), (ring, above, top), (middle, after, ring), (lid, top, above)]
    along = (outline[1] - outline[0]) / np.linalg.norm(outline[1] - outline[0])
    axes = np.array([along, [-along[1], along[0]]])
    return Body(np.concatenate([np.stack(face, axis=1) for face in faces]), axes)


def floating(subject: Subject) -> Iterator[Complaint]:
    """Something carries each thing: the floor, what is below it, a wall or the ceiling."""
    floor = subject.room.floor or 0.0
    for thing in carrying.floating(subject.room):
        above = float(thing.low[2]) - floor
        yield thing.path, f"floats {_cm(above)} above the floor without a support"


def sizes(subject: Subject) -> Iterator[Complaint]:
    """Things have sizes that such things have."""
    for thing in subject.room.things:
        if thing.category not in BUILT:
            continue
        spec = category(thing.category)
        least, most = (
            np.array(size) * share
            for size, share in zip((spec.min_size, spec.max_size), _SIZE_SHARES, strict=True)
        )
        size = _level_sorted(thing.size)
        if (size < _level_sorted(least)).any() or (size > _level_sorted(most)).any():
            yield (
                thing.path,
                (
                    f"has an unusual size: {_in_words(thing.size)}, and a "
                    f"{thing.category.replace('_', ' ')} is "
                    f"{_in_words(np.array(spec.min_size))} to {_in_words(np.array(spec.max_size))}"
                ),
            )


def _level_sorted(size: Array) -> Array:
    """Its level sides by length, as fronts are not known, then its height."""
    return np.array([*np.sort(size[:2]), size[2]])


def _cm(length: float) -> str:
    return f"{100.0 * length:.0f} cm"


def _in_words(size: Array) -> str:
    return " x ".join(f"{side:.2f}" for side in size.tolist()) + " m"


def slips(subject: Subject) -> Iterator[Complaint]:
    """Rooms, walls and openings have sizes that a house has: others are slips of the unit."""
    room = subject.room
    if room.outline is not None:
        longest = max(np.ptp(np.array(room.outline.exterior.coords), axis=0).tolist())
        yield from _slip(names.ROOM, "a room", "long", longest, _ROOM_M)
        if room.floor is not None and room.ceiling is not None:
            yield from _slip(names.ROOM, "a room", "high", room.ceiling - room.floor, _HEIGHT_M)
    for path, kind, width, height in room.openings:
        yield from _slip(path, f"a {kind}", "wide", width, _WIDTHS_M)
        yield from _slip(path, f"a {kind}", "high", height, _WIDTHS_M)


def _slip(
    path: str, what: str, how: str, length: float, usual: tuple[float, float]
) -> Iterator[Complaint]:
    if not usual[0] <= length <= usual[1]:
        yield path, f"is {length:g} m {how}: {what} of that size suggests a wrong unit"


def light(subject: Subject) -> Iterator[Complaint]:
    """Something shines: a lamp, or the sky by an opening."""
    room = subject.room
    if subject.stage.GetPrimAtPath(names.ROOM) and room.cameras and not room.is_lit:
        yield names.ROOM, "is dark: no lamp shines, and no sky through an opening"


class RoomRule(NamedTuple):
    """A rule about a room.

    Attributes:
        code: Its stable name.
        check: Gives the complaints about a stage.
        remedy: What to do about them.
    """

    code: str
    check: Callable[[Subject], Iterator[Complaint]]
    remedy: str


ROOM_RULES: Final = (
    RoomRule("outside-room", outside_room, "move it into the room, or leave it out"),
    RoomRule("camera-inside", cameras_inside, "move the camera or the thing"),
    RoomRule("overlap", overlaps, "move one of the two, or leave it out"),
    RoomRule(
        "floating",
        floating,
        "put it on the floor, on its support or against a wall; a lamp on the ceiling",
    ),
    RoomRule("size", sizes, "give it its size, a file its unit, or another category"),
    RoomRule("unit", slips, "write lengths in metres, or with their unit: 210 cm"),
    RoomRule("light", light, "put a lamp into the room, or an opening and lights.environment"),
)


def about(stage: Usd.Stage, path: str) -> list[str]:
    """What is wrong with where one thing of a room stands.

    Args:
        stage: The composed room.
        path: The thing's prim.

    Returns:
        A sentence for each complaint.
    """
    subject = Subject(stage)
    thing = next((one for one in subject.room.things if one.path == path), None)
    if thing is None:
        return []
    own = [found for found in (*outside_room(subject), *sizes(subject)) if found[0] == path]
    found = [*own, *_overlaps(subject.room, thing)]
    return [_sentence(complaint) for complaint in found]


def _sentence(complaint: Complaint) -> str:
    return f"{complaint[0].rpartition('/')[2]} {complaint[1]}"


def findings_of(subject: Subject) -> Iterator[str]:
    """One sentence about each rule that the room breaks, of the first few complaints."""
    for rule in ROOM_RULES:
        # To look for all may take long.
        first = list(islice(rule.check(subject), _NAMED + 1))
        if first:
            more = ", and more" if len(first) > _NAMED else ""
            listed = "; ".join(map(_sentence, first[:_NAMED]))
            yield f"{listed}{more} (`orusd validate` lists all)"
