"""Rooms of captures: described where they lie, and left out where a scan shows too little."""

from pathlib import Path
from typing import Any

from openrooms_usd.dataset.plan import Job
from openrooms_usd.dataset.records import LEFT_OUT
from openrooms_usd.description import Room
from openrooms_usd.description.layout import ScanLayout
from openrooms_usd.errors import InputError, SparseScanError


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
        The parts of ``floor`` and ``walls`` and of the ``whole``; None where nobody asks, or the
        room is not found in points.

    Raises:
        LeftOutError: It is less than was asked for, or too little to find any room.
        InputError: The scan cannot be read.
    """
    # What finds rooms in points takes a second to import.
    from openrooms_usd.composing import compose_room
    from openrooms_usd.scan.shown import shown
    from openrooms_usd.stages.layout.scanned import found_in
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
            f"together {seen.whole:.0%}; {least:.0%} are asked for",
            place=job.room.source["file"],
            remedy="scan what is missing, or ask for less `coverage`",
        )
    return seen.as_dict()
