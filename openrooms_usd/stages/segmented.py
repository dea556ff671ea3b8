"""Scans that nobody labelled: the things in them are found, and people are told."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

from openrooms_usd import adapters
from openrooms_usd.description.alignment import ScanAlignment
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.results import FoundRoom
from openrooms_usd.scan.segmentation.boxes import boxes_of
from openrooms_usd.scan.segmentation.byshape import ShapeSegmenter
from openrooms_usd.scan.segmentation.contract import Segmenter, Segments, checked
from openrooms_usd.scan.segmentation.labelled import SHELL_CLASSES, things_of
from openrooms_usd.scan.segmentation.naming import UNNAMED
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.scanned import ScannedRoom
from openrooms_usd.usd.semantics import NYU40

_BY_SHAPE: Final = "shapes"
_REMEDY: Final = (
    "Say better by a file (`orusd import scan --segments FILE`), a segmenter of your own "
    "(`alignment: {segmenter: NAME}`) or `objects`; `unlabelled: leave_out` leaves them out"
)


def segmented(context: StageContext, alignment: ScanAlignment, scanned: ScannedRoom) -> ScannedRoom:
    """The room with the things of its scan told apart, where the scan itself does not do so.

    Raises:
        InputError: No segmenter has that name, or it fails.
        MissingPackageError: The segmenter needs a package that is not installed.
    """
    cloud = scanned.layout.cloud
    if alignment.segmenter is None:
        told = cloud.instance is not None and bool(cloud.instance.any())
        if alignment.objects is not None or scanned.capture.boxes or told:
            return scanned
        if alignment.unlabelled == "leave_out":
            context.notes.append(
                "the scan has no labels, and by `unlabelled: leave_out` no furniture is "
                "looked for in it"
            )
            return scanned
    found, how = _segments(cloud, scanned.rooms, alignment)
    words = found.words
    if alignment.unlabelled == "boxes":
        words = dict.fromkeys(words, UNNAMED)
    context.notes.append(_told(words, how))
    marked = replace(
        cloud, instance=found.instance, words={n: (word,) for n, word in words.items()}
    )
    unnamed = sorted(number for number, word in words.items() if word == UNNAMED)
    boxes = boxes_of(cloud, found.instance, unnamed, scanned.rooms)
    return replace(scanned, layout=replace(scanned.layout, cloud=marked), boxes=boxes)


def _segments(
    cloud: Cloud, rooms: Sequence[FoundRoom], alignment: ScanAlignment
) -> tuple[Segments, str]:
    """The things of a scan, and how they were found."""
    if alignment.segmenter not in (None, _BY_SHAPE):
        name = str(alignment.segmenter)
        segmenter: Segmenter = adapters.load(adapters.SEGMENTERS, name)
        return checked(segmenter.segment(cloud, rooms), len(cloud), name), f"by {name!r}"
    if alignment.segmenter is None and cloud.label is not None and cloud.label.any():
        return _labelled(cloud), "as connected points of one label"
    return ShapeSegmenter().segment(cloud, rooms), "by their shape"


def _labelled(cloud: Cloud) -> Segments:
    """Connected parts of each class that is not the room's."""
    assert cloud.label is not None
    kind = cloud.label.astype("i8")
    kind[(kind >= len(NYU40)) | (cloud.label < 0)] = 0
    for number in SHELL_CLASSES.values():
        kind[kind == number] = 0
    instance = things_of(cloud, kind)
    rows = {int(number): row for row, number in enumerate(instance) if number > 0}
    words = {n: NYU40[kind[row]].replace("_", " ") for n, row in sorted(rows.items())}
    return Segments(instance, words)


def _told(words: Mapping[int, str], how: str) -> str:
    """How many things were found, and what can be done about them."""
    if not words:
        return f"the scan does not say what stands in it, and nothing was found {how}: {_REMEDY}"
    named = Counter(word for word in words.values() if word != UNNAMED)
    listed = [f"{count} {word.replace('_', ' ')}" for word, count in sorted(named.items())]
    if unnamed := sum(word == UNNAMED for word in words.values()):
        listed.append(f"{unnamed} without a name, for which boxes of their size stand")
    return f"the scan does not say what stands in it; found {how}: {', '.join(listed)}. {_REMEDY}"
