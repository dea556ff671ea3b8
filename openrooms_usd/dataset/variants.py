"""A room of the plan as a description, and its variants: other materials, other lights.

Everything that is not said to be other stays: the shell, the objects and the cameras. Other
materials are another look of the room (``materials.look``); what a person said of a material
stays. Other lights are another moment outside, and lamps of another brightness and hue, some off.
"""

import math
from collections.abc import Mapping
from datetime import date, datetime, timedelta
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd.dataset.plan import Job
from openrooms_usd.dataset.records import LEFT_OUT
from openrooms_usd.description import Room, lights, load_room, named_objects, parse_room, room_of
from openrooms_usd.description.dataset import DatasetViews
from openrooms_usd.description.furniture import ObjectList
from openrooms_usd.description.layout import ScanLayout
from openrooms_usd.description.moments import zone
from openrooms_usd.draws import generator
from openrooms_usd.errors import InputError, SparseScanError
from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.generation import expanded, generate, write
from openrooms_usd.library.styles.beams import lamp_kelvin
from openrooms_usd.library.surroundings.sunlight import sun_position

Section = dict[str, Any]

OTHER_MATERIALS: Final = frozenset({"mainDiffMat", "mainDiffMatLight"})
OTHER_LIGHTS: Final = frozenset({"mainDiffLight", "mainDiffMatLight"})

# Of light that is redrawn: how often a lamp is on, and the range of factors of what lamps and
# surroundings give.
_ON_SHARE: Final = 0.7
_LAMP_FACTOR: Final = (0.5, 1.6)
_OUTSIDE_FACTOR: Final = (0.4, 1.8)
_TINT: Final = (0.85, 1.15)
# Moments are tried until the sun stands so high; clocks are read to so many minutes.
_LEAST_ELEVATION_DEG: Final = 6.0
_MOST_TRIES: Final = 60
_CLOCK_MIN: Final = 10
_OVERCAST_SHARE: Final = 0.25
_TURBIDITY: Final = (2.2, 4.5)
_DIGITS: Final = 5
# A walk leads past so many of the best views.
_STOPS: Final = 5
# What the generator says of the room itself, which is drawn anew with other materials.
_DRAWN_SURFACES: Final = ("floor", "walls", "trim", "accents", "cladding", "beams")


def described(job: Job, folder: Path) -> Room:
    """The room of a job, before its variant.

    Args:
        job: The job.
        folder: Where the names of files in the dataset.yaml begin.

    Raises:
        InputError: The file cannot be read, or no such room can be made.
        DescriptionError: It has mistakes.
    """
    source = job.room.source
    if "importer" in source:
        return captured_room(job, folder)
    if "file" in source:
        return load_room(folder / str(source["file"]))
    made = generate(source["type"], source["seed"], None, source["style"], source["clutter"])
    return parse_room(write(made), job.room.name)


def realised(job: Job, views: DatasetViews, folder: Path) -> Room:
    """The room of a job as it is composed: in its variant, with the cameras of the dataset.

    Args:
        job: The job.
        views: From where it is seen.
        folder: Where the names of files in the dataset.yaml begin.

    Raises:
        InputError: As `described`.
        DescriptionError: As `described`.
    """
    room = described(job, folder)
    if job.variant in OTHER_LIGHTS:
        # Lamps can only be named where they are listed.
        room = with_other_lights(expanded(room), job.seed)
    if job.variant in OTHER_MATERIALS:
        room = with_other_materials(room, generated="file" not in job.room.source)
    return with_cameras(room, views)


def with_other_materials(room: Room, *, generated: bool = False) -> Room:
    """The same room in its next look.

    Args:
        room: The room.
        generated: Whether its surfaces are not specified, so that they vary, too.
    """
    data = room.as_dict()
    section: Section = data.setdefault("materials", {})
    if generated:
        for name in _DRAWN_SURFACES:
            section.pop(name, None)
    look = room.materials.look + 1
    section |= {"look": look, "looks": max(room.materials.looks, look + 1)}
    return _again(room, data)


def with_other_lights(room: Room, seed: int) -> Room:
    """The same room at another moment, under other lamps.

    Args:
        room: The room; its objects are listed, or its lamps in ``lights``.
        seed: Draws all that is other.
    """
    data = room.as_dict()
    section: Section = data.setdefault("lights", {})
    rng = generator(seed, "dataset", "environment")
    section["environment"] = _environment(room, section.get("environment", {}), rng)
    section["lamps"] = _lamps(room, seed)
    return _again(room, data)


def with_cameras(room: Room, views: DatasetViews) -> Room:
    """The same room with the cameras that the views of a dataset are chosen among."""
    data = room.as_dict()
    section: Section = data.setdefault("cameras", {})
    section["resolution"] = list(views.resolution)
    if views.source == "capture":
        data["cameras"] = {"from": "capture", "resolution": list(views.resolution)}
    elif views.source != "described":
        own = (getattr(view, "fov", None) for view in room.cameras.views)
        fov = views.fov or next((angle for angle in own if angle), None)
        is_path = views.source == "path"
        select = {
            "from": "select",
            "count": _STOPS if is_path else views.count,
            "spare": 0 if is_path else views.replace,
            "prefer": views.prefer,
        }
        data["cameras"] = {
            "resolution": list(views.resolution),
            "views": [select | ({"fov": fov} if fov else {})],
        }
    return _again(room, data)


def _again(room: Room, data: Mapping[str, Any]) -> Room:
    found = room_of(data)
    return found.located(room.folder) if room.folder else found


def _environment(room: Room, said: Mapping[str, Any], rng: np.random.Generator) -> Section:
    now = room.lights.environment
    factor = float(rng.uniform(*_OUTSIDE_FACTOR))
    if isinstance(now, lights.SkyEnvironment):
        return {**said, **_moment(now, rng)}
    if isinstance(now, lights.FileEnvironment):
        turned = (now.rotate + float(rng.uniform(0.0, 360.0))) % 360.0
        kept = "scale" if now.illuminance is None else "illuminance"
        value = now.illuminance or now.scale or 1.0
        return {**said, "rotate": round(turned, 1), kept: _digits(value * factor)}
    assert isinstance(now, lights.ConstantEnvironment)
    color = [_digits(part * float(rng.uniform(*_TINT))) for part in now.color]
    return {**said, "color": color, "illuminance": _digits(now.illuminance * factor)}


def _moment(now: lights.SkyEnvironment, rng: np.random.Generator) -> Section:
    """Another day and hour at the same place, by daylight where there is any."""
    local_zone = zone(now.utc_offset, now.longitude)
    year = date.fromisoformat(now.date).year
    best: tuple[float, datetime] | None = None
    for _ in range(_MOST_TRIES):
        day = date(year, 1, 1) + timedelta(days=int(rng.integers(365)))
        minute = _CLOCK_MIN * int(rng.integers(24 * 60 // _CLOCK_MIN))
        local = datetime(day.year, day.month, day.day, minute // 60, minute % 60, tzinfo=local_zone)
        height = sun_position(local, now.latitude, now.longitude).elevation
        if best is None or height > best[0]:
            best = height, local
        if height >= _LEAST_ELEVATION_DEG:
            best = height, local
            break
    assert best is not None
    return {
        "date": best[1].date().isoformat(),
        "time": f"{best[1]:%H:%M}",
        "turbidity": round(float(rng.uniform(*_TURBIDITY)), 1),
        "overcast": bool(rng.random() < _OVERCAST_SHARE),
    }


def _lamps(room: Room, seed: int) -> dict[str, Section]:
    """What every lamp emits; one of them is on at least."""
    found = {}
    for name, usual in _usual_lumens(room).items():
        # Drawn for each, so that one that is added changes no other.
        rng = generator(seed, "dataset", "lamp", name)
        lamp = room.lights.lamps.get(name, lights.Lamp())
        found[name] = _lamp(room, lamp, usual, rng)
    if found and not any(row["on"] for row in found.values()):
        next(iter(found.values()))["on"] = True
    return found


def _usual_lumens(room: Room) -> dict[str, float | None]:
    """The lamps that are listed in the room or in its lights, with what their kind emits."""
    found: dict[str, float | None] = dict.fromkeys(room.lights.lamps)
    if isinstance(room.furniture, ObjectList):
        for name, row in named_objects(room.furniture.objects):
            spec = CATEGORIES.get(row.category)
            if spec and spec.emits:
                found[name] = spec.lumen
    return found


def _lamp(room: Room, lamp: lights.Lamp, usual: float | None, rng: np.random.Generator) -> Section:
    row = lamp.model_dump(mode="json", exclude_unset=True)
    row["on"] = bool(rng.random() < _ON_SHARE)
    least, most = map(math.log, _LAMP_FACTOR)
    factor = math.exp(float(rng.uniform(least, most)))
    kelvin = int(rng.choice(lamp_kelvin(room.room)))
    if lamp.radiance is not None:
        row["radiance"] = [_digits(part * factor) for part in lamp.radiance]
        return row
    lumen = usual if lamp.lumen is None else lamp.lumen
    if lumen is not None:
        row["lumen"] = round(lumen * factor, 1)
    return row if lamp.color is not None else {**row, "kelvin": kelvin}


def _digits(value: float) -> float:
    """As many digits as people read, however small the number."""
    return float(f"{value:.{_DIGITS}g}")


# Rooms of captures: described where they lie, and left out where a scan shows too little.


class LeftOutError(InputError):
    """A scan that shows too little of its room."""

    code = LEFT_OUT


def captured_room(job: Job, folder: Path) -> Room:
    """The room of a capture, as `orusd import` describes it; nothing is copied.

    Args:
        job: Its source has the ``file``, the ``importer`` and its ``options``.
        folder: Where the names of files in the dataset.yaml begin.

    Raises:
        InputError: The capture cannot be read, or has no usable floor.
    """
    from openrooms_usd.importing import described_capture

    source = job.room.source
    return described_capture(
        str(source["importer"]), str(source["file"]), folder, dict(source["options"])
    )


def coverage_of(job: Job, room: Room, folder: Path, scene: Path) -> dict[str, float] | None:
    """How much a scan shows of its room (`openrooms_usd.scan.shown`); its layout is composed.

    Args:
        job: Its source may have a least ``coverage``.
        room: The room, as it is described.
        folder: Where its files' names begin.
        scene: The folder of the composed room.

    Returns:
        The parts of ``floor`` and ``walls`` and of the ``whole``; None if not requested, or if the
        room is not found in points.

    Raises:
        LeftOutError: It is less than was asked for, or too little to find any room.
        InputError: The scan cannot be read.
    """
    # What finds rooms in points takes a second to import.
    from openrooms_usd.composing import compose_room
    from openrooms_usd.scan.shown import shown
    from openrooms_usd.steps.layout.scanned import found_in
    from openrooms_usd.usd.files.layers import open_stage

    least: Any = job.room.source.get("coverage")
    if least is None or not isinstance(room.layout, ScanLayout):
        return None
    try:
        made = compose_room(room, scene, base=folder, only="layout")
    except SparseScanError as error:
        raise LeftOutError(error.message, place=error.place, remedy=error.remedy) from error
    found = found_in(open_stage(made.scene))
    assert found is not None, "it is found in points"
    seen = shown(found.cloud.points, found.composed)
    if seen.whole < least:
        raise LeftOutError(
            f"the scan shows {seen.floor:.0%} of the floor and {seen.walls:.0%} of the walls, "
            f"together {seen.whole:.0%}; {least:.0%} are required",
            place=job.room.source["file"],
            remedy="scan what is missing, or lower `coverage`",
        )
    return seen.as_dict()
