"""What may hinder loaders that were written for the released dataset."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd.render.datasets import DatasetOptions
from openrooms_usd.render.reading import RenderedScene, RenderedView
from orusd_openrooms import layout, readers
from orusd_openrooms.crowding import CROWDED

_RELEASED: Final = (640, 480)
# Horizontal, degrees: IndoorLightEditing takes it for granted, InverseRenderingOfIndoorScene 57.
_RELEASED_FIELD_DEG: Final = 57.95
_FIELD_TOLERANCE_DEG: Final = 1.0


def cautions(
    renders: Sequence[RenderedScene],
    root: Path,
    options: DatasetOptions,
    crowded: Sequence[Mapping[str, frozenset[int]]],
) -> Iterator[str]:
    """A sentence for each.

    Args:
        renders: What was written.
        root: The dataset's folder.
        options: How it was laid out.
        crowded: The lights that found no place, by view, of each split.
    """
    if options.layout == "split":
        yield (
            "this is the tree of the release, in which the published loaders find no pictures: "
            "what they read is the layout merged"
        )
    # Variants share their views.
    suffixes = map(layout.suffix_of, options.splits)
    of_suffix = dict(zip(suffixes, crowded, strict=True))
    for suffix, each in of_suffix.items():
        place = options.scene if suffix == layout.SUFFIXES[0] else f"{options.scene}, {suffix}"
        for name, numbers in sorted(each.items()):
            if options.crowded == "leave-out":
                said, why = "is left out", f"{CROWDED}, for which IndoorLightEditing has no room"
            else:
                least = ", ".join(map(str, sorted(numbers)))
                said, why = f"is without its least lights, {least}", CROWDED
            yield f"{place}: {name} {said}: it has {why}"
    views = [view for render in renders for view in render.views.values()]
    if {(view.width, view.height) for view in views} != {_RELEASED}:
        yield "the released loaders expect pictures of 640x480"
    fields = sorted({round(_field_deg(view), 2) for view in views})
    if any(abs(field - _RELEASED_FIELD_DEG) > _FIELD_TOLERANCE_DEG for field in fields):
        said = " to ".join(f"{field:g}" for field in dict.fromkeys((fields[0], fields[-1])))
        yield (
            f"the field of view is {said} degrees, and the released loaders take "
            f"{_RELEASED_FIELD_DEG} or 57 for granted: use --fov {_RELEASED_FIELD_DEG}, in a "
            f"dataset.yaml views: {{fov: {_RELEASED_FIELD_DEG}}}, or change it in them"
        )
    shared = readers.read_intrinsics(root / layout.SHARED_INTRINSICS)
    if not all(np.allclose(view.K, shared, rtol=1e-6) for view in views):
        yield (
            f"{layout.SHARED_INTRINSICS.as_posix()} is that of other cameras: loaders that read it "
            "for all scenes will be wrong about these"
        )
    if caution := layout.caution(root):
        yield caution


def _field_deg(view: RenderedView) -> float:
    """The horizontal field of view, degrees."""
    return float(2.0 * np.degrees(np.arctan(0.5 * view.width / view.K[0, 0])))
