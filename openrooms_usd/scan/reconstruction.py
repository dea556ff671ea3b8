"""From a cloud to rooms and objects, and the report of what was found.

Everything is found in the level frame (see `levelling`); the report is in the scan's own frame,
metres.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, Literal

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.progress import Progress, nested, silent
from openrooms_usd.scan.models.cad import CadModel
from openrooms_usd.scan.openings.detection import DOUBTFUL, LIKELY, find_openings
from openrooms_usd.scan.placement.correcting import moved_by, place
from openrooms_usd.scan.placement.fitting import LeftOut
from openrooms_usd.scan.placement.settling import Unresolved
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.mainpart import main_part
from openrooms_usd.scan.points.surfels import surfels
from openrooms_usd.scan.points.thinning import thin
from openrooms_usd.scan.registration.alignment import Rejected, align
from openrooms_usd.scan.registration.hints import Hint
from openrooms_usd.scan.results import FoundObject, FoundRoom
from openrooms_usd.scan.rooms.layout import LayoutOptions, LayoutRoom, find_layout
from openrooms_usd.scan.rooms.levelling import Level, level
from openrooms_usd.scan.rooms.storeys import Storey, main_storey, storeys

# Voxel size of the downsampled cloud, metres: finer than the noise.
VOXEL_M: Final = 0.02
# Share of the time that alignment takes, of that of furniture.
_ALIGNING_SHARE: Final = 0.95
# A thing whose middle point lies farther beyond the inner faces of the walls than this is not of
# the room, metres: about the thickness of a wall, or the depth of a window's recess.
_BEYOND_M: Final = 0.25
# Points of an instance that are looked at: more change nothing.
_MAX_POINTS: Final = 2000


@dataclass(frozen=True, eq=False)
class FoundLayout:
    """The rooms of a scan.

    Attributes:
        level: Level frame of the scan.
        cloud: The points in the level frame.
        rooms: In the level frame, the largest that were seen well first.
    """

    level: Level
    cloud: Cloud
    rooms: tuple[FoundRoom, ...]

    @property
    def notes(self) -> list[str]:
        """What people should know, one sentence each."""
        notes = list(self.level.notes)
        for number, room in enumerate(self.rooms):
            if room.guessed:
                walls = ", ".join(map(str, room.guessed))
                notes.append(
                    f"room {number}: the scan does not show the walls {walls}: they are guessed"
                )
            if room.ceiling is None:
                slopes = f", but {len(room.slopes)} slopes" if room.slopes else ""
                notes.append(f"room {number}: no level ceiling was seen{slopes}")
            if room.doubtful:
                kinds = ", ".join(opening.type for opening in room.doubtful)
                notes.append(f"room {number}: doubtful, so only in the report: {kinds}")
        return notes


@dataclass(frozen=True, eq=False)
class FoundFurniture:
    """The objects of a scan.

    Attributes:
        objects: In the level frame, with their placed poses.
        rejected: Instances without a CAD.
        unresolved: Violations that no small motion resolves.
        left_out: Objects that have no place.
        elsewhere: Instances of other rooms.
        notes: What people should know, one sentence each.
    """

    objects: tuple[FoundObject, ...]
    rejected: tuple[Rejected, ...] = ()
    unresolved: tuple[Unresolved, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    elsewhere: tuple[int, ...] = ()
    notes: tuple[str, ...] = field(default=())


def find_rooms(
    cloud: Cloud, options: LayoutOptions | None = None, up: Array | None = None
) -> FoundLayout:
    """Find the rooms of a scan with their openings.

    Args:
        cloud: Finite points, metres, anywhere.
        options: What people may choose.
        up: (3,) roughly upwards; None: Z.

    Raises:
        InputError: The scan shows too little of a room, or has no such storey.
    """
    options = options or LayoutOptions()
    flat, stands, storey = standing(cloud, options, up)
    # The largest of those that were seen well: half-seen ones may be larger than they are.
    found = sorted(
        find_layout(flat, stands, options), key=lambda room: -_area(room.corners) * room.coverage
    )
    rooms = tuple(_room(room, flat, stands) for room in found)
    return FoundLayout(stands, _within(cloud.moved(stands.level_from_scan), storey), rooms)


def without_rooms(
    cloud: Cloud, options: LayoutOptions | None = None, up: Array | None = None
) -> FoundLayout:
    """The level frame of a scan whose rooms are known: the frame of `find_rooms`, which needs more.

    Args:
        cloud: Finite points, metres, anywhere.
        options: What people may choose.
        up: (3,) roughly upwards; None: Z.

    Raises:
        InputError: The scan has no level floor, or has no such storey.
    """
    _, stands, storey = standing(cloud, options or LayoutOptions(), up)
    return FoundLayout(stands, _within(cloud.moved(stands.level_from_scan), storey), ())


def standing(
    cloud: Cloud, options: LayoutOptions, up: Array | None = None
) -> tuple[Cloud, Level, Storey | None]:
    """The thinned points of a storey in the level frame on its floor, among which rooms are found.

    Args:
        cloud: Finite points, metres, anywhere.
        options: What people may choose.
        up: (3,) roughly upwards; None: Z.

    Returns:
        The points, the level frame, and the storey; None where there is but one.

    Raises:
        InputError: The scan has no level floor, or has no such storey.
    """
    main, thinned = main_part(cloud), thin(cloud, VOXEL_M)
    inside = thinned if main is cloud else thin(main, VOXEL_M)
    stands, storey = _storey(inside, level(inside, up), options.storey)
    return _within(thinned.moved(stands.level_from_scan), storey), stands, storey


def _storey(cloud: Cloud, stands: Level, wanted: int | None) -> tuple[Level, Storey | None]:
    """The level frame on the floor of a storey, and that storey; None if it is the only one.

    Args:
        cloud: In the scan's frame.
        stands: The level frame on the lowest floor.
        wanted: Which one, from below; None: the main one.
    """
    found = storeys(surfels(cloud.moved(stands.level_from_scan)))
    if wanted is not None and wanted >= len(found):
        shows = "1 storey" if len(found) == 1 else f"{len(found)} storeys"
        raise InputError(
            f"the scan shows {shows}, there is no storey {wanted}",
            remedy="count from 0, the lowest",
        )
    if len(found) < 2:
        return stands, None
    chosen = main_storey(found) if wanted is None else found[wanted]
    raised = np.eye(4)
    raised[2, 3] = -chosen.floor
    heights = ", ".join(f"{storey.floor:.1f} m" for storey in found)
    last = len(found) - 1
    why = f"; `storey: 0` to `{last}` selects another" if wanted is None else ", as asked"
    note = (
        f"the scan shows {len(found)} storeys, with floors at {heights} above the lowest; the one "
        f"at {chosen.floor:.1f} m is composed{why}"
    )
    moved = replace(
        stands,
        level_from_scan=raised @ stands.level_from_scan,
        point=stands.point + chosen.floor * stands.normal,
        notes=(*stands.notes, note),
    )
    own = replace(chosen, floor=0.0, low=chosen.low - chosen.floor, high=chosen.high - chosen.floor)
    return moved, own


def _within(cloud: Cloud, storey: Storey | None) -> Cloud:
    """The points of a storey; all where there is but one."""
    if storey is None:
        return cloud
    height = cloud.points[:, 2]
    return cloud.take((height > storey.low) & (height < storey.high))


def find_furniture(
    cloud: Cloud,
    rooms: Sequence[FoundRoom],
    models: Sequence[CadModel],
    hints: Sequence[Hint] | None = None,
    categories: Mapping[int, Sequence[str]] | None = None,
    unresolved: Literal["leave_out", "keep"] = "keep",
    workers: int = 1,
    progress: Progress = silent,
) -> FoundFurniture:
    """Align CADs to the objects of a scan, and make their poses physically plausible.

    Args:
        cloud: The scan, in the level frame.
        rooms: Those of its rooms that are composed.
        models: CADs to choose from.
        hints: The objects, in the level frame; None: every labelled instance.
        categories: The CADs' categories that a label may mean, best first.
        unresolved: What becomes of objects that penetrate others or walls, or float.
        workers: Threads; the result never depends on it.
        progress: Called with every object, and the finished fraction.
    """
    composed = tuple(rooms)
    away = elsewhere(cloud, hints, composed)
    cloud = _without(cloud, away)
    here = None if hints is None else [hint for hint in hints if hint.instance not in away]
    share = nested(progress, "", 0.0, _ALIGNING_SHARE)
    aligned = align(cloud, here, models, composed, categories, workers, share)
    progress("placement", _ALIGNING_SHARE)
    known = {hint.instance: hint.support for hint in hints or ()}
    objects = [replace(o, support=known.get(o.instance, "")) for o in aligned.objects]
    by_id = {model.id: model for model in models}
    placed = place(objects, by_id, composed, unresolved=unresolved)
    return FoundFurniture(
        placed.objects,
        aligned.rejected,
        placed.unresolved,
        placed.left_out,
        tuple(sorted(away)),
        placed.notes,
    )


def _without(cloud: Cloud, instances: Collection[int]) -> Cloud:
    """The cloud, whose points of some instances belong to none."""
    if cloud.instance is None or not instances:
        return cloud
    away = np.isin(cloud.instance, list(instances))
    return replace(cloud, instance=np.where(away, 0, cloud.instance).astype(np.int32))


def layout_report(layout: FoundLayout, scan_from_level: Array) -> dict[str, Any]:
    """The rooms in the form of the report."""
    rooms = [room.moved(scan_from_level).as_dict() for room in layout.rooms]
    return {"coverage": layout.level.coverage, "notes": layout.notes, "rooms": rooms}


def furniture_report(found: FoundFurniture, scan_from_level: Array) -> dict[str, Any]:
    """The objects in the form of the report."""
    return {
        "notes": list(found.notes),
        "objects": [
            {**thing.moved(scan_from_level).as_dict(), "moved": moved_by(thing)}
            for thing in found.objects
        ],
        "rejected": [
            {"instance": r.instance, "category": r.category, "reason": r.reason}
            for r in found.rejected
        ],
        "left_out": [
            {"instance": one.instance, "word": one.word, "reason": one.reason}
            for one in found.left_out
        ],
        "elsewhere": list(found.elsewhere),
        "unresolved": [
            {"kind": u.kind, "instance": u.instance, "other": u.other, "depth": u.depth}
            for u in found.unresolved
        ],
    }


def _room(room: LayoutRoom, cloud: Cloud, stands: Level) -> FoundRoom:
    openings = find_openings(cloud, room.corners, room.ceiling, DOUBTFUL)
    return FoundRoom(
        normal=np.array([0.0, 0.0, 1.0]),
        point=np.zeros(3),
        corners=np.column_stack([room.corners, np.zeros(len(room.corners))]),
        guessed=room.guessed,
        ceiling=room.ceiling,
        openings=tuple(o for o in openings if o.confidence >= LIKELY),
        measures={"coverage": room.coverage, "floor_residual": stands.residual},
        slopes=room.slopes,
        doubtful=tuple(o for o in openings if o.confidence < LIKELY),
    )


def _area(corners: Array) -> float:
    x, y = corners.T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def elsewhere(
    cloud: Cloud, hints: Sequence[Hint] | None, rooms: Sequence[FoundRoom]
) -> frozenset[int]:
    """The instances that stand in none of some rooms.

    Args:
        cloud: In the frame of the rooms.
        hints: The objects; None: every instance of the cloud.
        rooms: Those that are composed; none: nothing is elsewhere.
    """
    if not rooms:
        return frozenset()
    numbers = _numbers(cloud) if hints is None else [hint.instance for hint in hints]
    places = _points(cloud, numbers)
    for hint in hints or ():
        if not len(places[hint.instance]) and (known := hint.box or hint.pose) is not None:
            place = hint.box.center if hint.box is not None else None
            place = hint.pose.translation if place is None and hint.pose is not None else place
            assert place is not None, known
            places[hint.instance] = place[None, :2]
    return frozenset(
        number for number, points in places.items() if len(points) and _is_beyond(points, rooms)
    )


def _numbers(cloud: Cloud) -> list[int]:
    if cloud.instance is None:
        return []
    return [int(number) for number in np.unique(cloud.instance) if number > 0]


def _points(cloud: Cloud, numbers: Collection[int]) -> dict[int, Array]:
    """(P, 2) of each instance in the plan, not all of many."""
    if cloud.instance is None:
        return {number: np.empty((0, 2)) for number in numbers}
    order = np.argsort(cloud.instance, kind="stable")
    ranked = cloud.instance[order]
    found = {}
    for number in numbers:
        begin, end = np.searchsorted(ranked, [number, number + 1])
        step = max((end - begin) // _MAX_POINTS, 1)
        found[number] = cloud.points[order[begin:end:step], :2]
    return found


def _is_beyond(points: Array, rooms: Sequence[FoundRoom]) -> bool:
    import shapely

    places = shapely.points(points)
    distances = [
        float(np.median(shapely.distance(shapely.Polygon(room.corners[:, :2]), places)))
        for room in rooms
    ]
    return min(distances) > _BEYOND_M
