"""The furniture of a scan: CADs at the poses that were measured, and where they were placed."""

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.categories.words import plain
from openrooms_usd.description.alignment import ScanAlignment, named_objects
from openrooms_usd.description.naming import captured_names
from openrooms_usd.errors import InputError
from openrooms_usd.scan.placement.correcting import moved_by
from openrooms_usd.scan.placement.violations import Unresolved
from openrooms_usd.scan.reconstruction import FoundFurniture, find_furniture, furniture_report
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.catalogue import Catalogue
from openrooms_usd.stages.instances import told_left_out
from openrooms_usd.stages.placement import Placement
from openrooms_usd.stages.reports import keep_overlay, keep_report
from openrooms_usd.stages.scanned import found_in
from openrooms_usd.stages.segmented import segmented
from openrooms_usd.stages.shelf import Shelf
from openrooms_usd.stages.substitutes import UNKNOWN

Array = NDArray[np.float64]

# Objects that placement moved by more than this are counted in a note, metres.
_COUNTED_MOTION_M: Final = 0.01


def furnish(
    context: StageContext, alignment: ScanAlignment, catalogue: Catalogue
) -> Iterator[Placement]:
    """The objects of a scan, each with its asset; a report of them is kept beside the layer.

    Raises:
        InputError: The layout is not found in a scan, or a CAD cannot be read.
    """
    found_scan = found_in(context.stage)
    if found_scan is None:
        raise InputError(
            "furniture is found in the scan of the layout, and there is none",
            place="alignment",
            remedy="give `layout: {from: scan, scan: FILE}` too",
        )
    scan = segmented(context, alignment, found_scan)
    shelf = Shelf(context, alignment, scan)
    found = find_furniture(
        scan.cloud,
        scan.composed,
        shelf.models,
        shelf.hints,
        shelf.categories,
        alignment.unresolved,
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
    context.notes.extend([*told_left_out(left), *told, *_told(found, len(left))])
    labels = [
        (plain(thing.word or thing.category or "object"), str(thing.instance))
        for thing in found.objects
    ]
    taken = {name for name, _ in named_objects(alignment.further)}
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


def _told(found: FoundFurniture, left_out: int) -> Iterator[str]:
    yield from found.notes
    words = {
        one.instance: (one.word or one.category or "object").replace("_", " ")
        for one in found.objects
    }
    moved = {thing.instance: moved_by(thing)["metres"] for thing in found.objects}
    far = [instance for instance, metres in moved.items() if metres > _COUNTED_MOTION_M]
    if far:
        most = max(far, key=moved.__getitem__)
        text = f"{len(far)} of {len(moved)} objects were moved towards where they can be"
        yield f"{text}, {words[most]} (instance {most}) the farthest: {moved[most]:.2f} m"
    cut = {
        thing.instance: 100.0 * (1.0 - float(thing.fitted.min()))
        for thing in found.objects
        if thing.fitted is not None
    }
    if cut:
        most = max(cut, key=cut.__getitem__)
        text = f"{len(cut)} of {len(moved)} objects were shortened to have room"
        yield f"{text}, {words[most]} (instance {most}) the most: by {cut[most]:.0f} %"
    boxed = sorted(
        {thing.word for thing in found.objects if thing.category == UNKNOWN and thing.word}
    )
    if boxed:
        listed = ", ".join(boxed)
        yield f"boxes stand for what the library has nothing for, or not of its size: {listed}"
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
        yield f"left out, where `alignment.unresolved: keep` keeps them: {each}"
    yield from (_told_unresolved(one, words) for one in found.unresolved)


def _told_unresolved(wrong: Unresolved, words: Mapping[int, str]) -> str:
    what = f"{words[wrong.instance]} (instance {wrong.instance})"
    if wrong.other is not None:
        where = f"inside the {words[wrong.other]} (instance {wrong.other})"
    else:
        where = {"in a wall": "beyond the walls"}.get(wrong.kind, "above all that may carry it")
    return f"still wrong: the {what} is {wrong.depth:.2f} m {where}"
