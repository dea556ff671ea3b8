"""The furniture of a scan: CADs at the poses that were measured, and where they were placed."""

from collections import Counter, defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

from openrooms_usd import adapters
from openrooms_usd.description.furniture import ScanFurniture, named_objects
from openrooms_usd.description.naming import captured_names
from openrooms_usd.errors import InputError
from openrooms_usd.furniture.words import category_of, plain
from openrooms_usd.scan.artefact import FoundScan
from openrooms_usd.scan.placement.correcting import moved_by
from openrooms_usd.scan.placement.fitting import whereabouts
from openrooms_usd.scan.placement.settling import Unresolved
from openrooms_usd.scan.placement.support import WALL
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.reconstruction import FoundFurniture, find_furniture, furniture_report
from openrooms_usd.scan.results import FoundRoom
from openrooms_usd.scan.segmentation.boxes import boxes_of
from openrooms_usd.scan.segmentation.byshape import ShapeSegmenter
from openrooms_usd.scan.segmentation.contract import Segmenter, Segments, checked
from openrooms_usd.scan.segmentation.naming import SHELL_CLASSES, UNNAMED, things_of
from openrooms_usd.steps.alignment.captured import UNKNOWN
from openrooms_usd.steps.alignment.catalogue import Catalogue
from openrooms_usd.steps.alignment.instances import told_left_out
from openrooms_usd.steps.alignment.placement import Placement
from openrooms_usd.steps.alignment.shelf import CadCandidates
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.layout.scanned import found_in
from openrooms_usd.steps.reports import keep_overlay, keep_report
from openrooms_usd.usd.semantics import NYU40

# Objects that placement moved by more than this are counted in a note, metres.
_COUNTED_MOTION_M: Final = 0.01
_BY_SHAPE: Final = "shapes"
_REMEDY: Final = (
    "For better results give labels (`orusd import scan --segments FILE`), your own segmenter "
    "(`furniture: {segmenter: NAME}`) or `objects`; `unlabelled: leave_out` leaves them out"
)


def furnish(
    context: StepContext, furniture: ScanFurniture, catalogue: Catalogue
) -> Iterator[Placement]:
    """The objects of a scan, each with its asset; a report of them is kept beside the layer.

    Raises:
        InputError: The layout is not found in a scan, or a CAD cannot be read.
    """
    found_scan = found_in(context.stage)
    if found_scan is None:
        raise InputError(
            "furniture is found in the layout's scan, but the layout is not from a scan",
            place="furniture",
            remedy="give `layout: {from: scan, scan: FILE}` too",
        )
    scan = segmented(context, furniture, found_scan)
    shelf = CadCandidates(context, furniture, scan)
    found = find_furniture(
        scan.cloud,
        scan.composed,
        shelf.models,
        shelf.hints,
        shelf.categories,
        furniture.unresolved,
        context.workers,
        context.progress,
    )
    left = [instance for instance in shelf.instances if instance.meaning.kind != "thing"]
    found = replace(found, rejected=(*(i.left_out for i in left), *found.rejected))
    keep_report(context, furniture_report(found, scan.scan_from_level))
    bounds = {model.id: model.extent for model in shelf.models}
    keep_overlay(context, scan.cloud, scan.rooms, found.objects, bounds)
    words = {hint.instance: hint.word or hint.category or "" for hint in shelf.hints or ()}
    told = _told_elsewhere([words.get(number, "") for number in found.elsewhere])
    context.notes.extend([*told_left_out(left), *told, *_furniture_notes(found, len(left))])
    labels = [
        (plain(thing.word or thing.category or "object"), str(thing.instance))
        for thing in found.objects
    ]
    taken = {name for name, _ in named_objects(furniture.further)}
    names = captured_names(labels, taken)
    by_instance = {str(o.instance): name for o, name in zip(found.objects, names, strict=True)}
    for name, thing in zip(names, found.objects, strict=True):
        yield shelf.placement(catalogue, name, thing, by_instance.get(thing.support))


def _told_elsewhere(words: Sequence[str]) -> Iterator[str]:
    """One sentence about all that stands in other rooms."""
    if words:
        counts = Counter(word or "object" for word in words)
        listed = ", ".join(f"{count} {word}" for word, count in sorted(counts.items()))
        yield f"beyond the walls, and left out: {listed}"


def _furniture_notes(found: FoundFurniture, left_out: int) -> Iterator[str]:
    yield from found.notes
    words = {
        one.instance: (one.word or one.category or "object").replace("_", " ")
        for one in found.objects
    }
    moved = {thing.instance: moved_by(thing)["metres"] for thing in found.objects}
    far = [instance for instance, metres in moved.items() if metres > _COUNTED_MOTION_M]
    if far:
        most = max(far, key=moved.__getitem__)
        text = f"moved {len(far)} of {len(moved)} objects out of walls and each other"
        yield f"{text}, {words[most]} (instance {most}) the farthest: {moved[most]:.2f} m"
    cut = {
        thing.instance: 100.0 * (1.0 - float(thing.fitted.min()))
        for thing in found.objects
        if thing.fitted is not None
    }
    if cut:
        most = max(cut, key=cut.__getitem__)
        text = f"{len(cut)} of {len(moved)} objects were shortened to fit"
        yield f"{text}, {words[most]} (instance {most}) the most: by {cut[most]:.0f} %"
    boxed = sorted(
        {thing.word for thing in found.objects if thing.category == UNKNOWN and thing.word}
    )
    known = [word for word in boxed if category_of(word, 0.0) is not None]
    if unknown := [word for word in boxed if word not in known]:
        yield f"no category fits, so boxes replace: {', '.join(unknown)}"
    if known:
        yield f"impossible sizes for their categories, so boxes replace: {', '.join(known)}"
    reasons = defaultdict[str, list[str]](list)
    for rejected in found.rejected[left_out:]:
        what = f" ({rejected.category})" if rejected.category else ""
        reasons[rejected.reason].append(f"{rejected.instance}{what}")
    for reason, whom in reasons.items():
        yield f"without a CAD: {', '.join(whom)}; {reason}"
    if found.left_out:
        each = "; ".join(
            f"{one.word} (instance {one.instance}): {one.reason}" for one in found.left_out
        )
        yield f"left out, where `furniture.unresolved: keep` keeps them: {each}"
    hung = {thing.instance for thing in found.objects if thing.support == WALL}
    yield from (_told_unresolved(one, words, hung) for one in found.unresolved)


def _told_unresolved(wrong: Unresolved, words: Mapping[int, str], hung: Collection[int]) -> str:
    what = f"{words[wrong.instance]} (instance {wrong.instance})"
    if wrong.other is not None:
        where = f"inside the {words[wrong.other]} (instance {wrong.other})"
    else:
        where = whereabouts(wrong, hangs=wrong.instance in hung)
    return f"not resolved: the {what} is {wrong.depth:.2f} m {where}"


def segmented(context: StepContext, furniture: ScanFurniture, scan: FoundScan) -> FoundScan:
    """The room with the things of its scan told apart, where the scan itself does not do so.

    Raises:
        InputError: No segmenter has that name, or it fails.
        MissingPackageError: The segmenter needs a package that is not installed.
    """
    cloud = scan.cloud
    if furniture.segmenter is None:
        told = cloud.instance is not None and bool(cloud.instance.any())
        if furniture.objects is not None or scan.captured or told:
            return scan
        if furniture.unlabelled == "leave_out":
            context.notes.append(
                "the scan has no labels, and `unlabelled: leave_out` turns the search for "
                "furniture off"
            )
            return scan
    found, how = _segments(cloud, scan.composed, furniture)
    words = found.words
    if furniture.unlabelled == "boxes":
        words = dict.fromkeys(words, UNNAMED)
    context.notes.append(_told_segments(words, how))
    marked = replace(
        cloud, instance=found.instance, words={n: (word,) for n, word in words.items()}
    )
    unnamed = sorted(number for number, word in words.items() if word == UNNAMED)
    boxes = boxes_of(cloud, found.instance, unnamed, scan.composed)
    return replace(scan, cloud=marked, boxes=boxes)


def _segments(
    cloud: Cloud, rooms: Sequence[FoundRoom], furniture: ScanFurniture
) -> tuple[Segments, str]:
    """The things of a scan, and how they were found."""
    if furniture.segmenter not in (None, _BY_SHAPE):
        name = str(furniture.segmenter)
        segmenter: Segmenter = adapters.load(adapters.SEGMENTERS, name)
        return checked(segmenter.segment(cloud, rooms), len(cloud), name), f"by {name!r}"
    if furniture.segmenter is None and cloud.label is not None and cloud.label.any():
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


def _told_segments(words: Mapping[int, str], how: str) -> str:
    """How many things were found, and what can be done about them."""
    if not words:
        return f"the scan has no labels, and nothing was found {how}: {_REMEDY}"
    named = Counter(word for word in words.values() if word != UNNAMED)
    listed = [f"{count} {word.replace('_', ' ')}" for word, count in sorted(named.items())]
    if unnamed := sum(word == UNNAMED for word in words.values()):
        listed.append(f"{unnamed} without a name, replaced by boxes of their size")
    return f"the scan has no labels; found {how}: {', '.join(listed)}. {_REMEDY}"
