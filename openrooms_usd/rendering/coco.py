"""What is seen in finished renders as one COCO file: boxes, areas and masks of its objects."""

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from openrooms_usd import names
from openrooms_usd.arrays import Mask
from openrooms_usd.channels import CLASS_CHANNELS
from openrooms_usd.errors import InputError
from openrooms_usd.furniture.record import UNLABELED
from openrooms_usd.portable import common_folder
from openrooms_usd.progress import Progress, each, nested, silent
from openrooms_usd.rendering.folder import CHANNELS_FILE, preview_file
from openrooms_usd.rendering.manifest_schema import AGAIN
from openrooms_usd.rendering.reading import RenderedScene, RenderedView, read_render
from openrooms_usd.rendering.rle import compressed, run_lengths, tight_box
from openrooms_usd.usd.semantics import COCO_GROUPS, TAXONOMIES, classes
from openrooms_usd.version import __version__

Plain = dict[str, Any]


def coco(
    folders: Sequence[Path], taxonomy: str = names.CATEGORY, progress: Progress = silent
) -> Plain:
    """The visible objects of renders, in COCO's form.

    A segmentation holds the pixels whose centre shows the object, as compressed run lengths; the
    box is the least that holds them. What has no class in the taxonomy is left out. Names of
    pictures are relative to the render, or to the folder that holds all renders.

    Args:
        folders: What `orusd render` wrote, each once.
        taxonomy: Whose classes: ``category`` for our own, or a key of `CLASS_CHANNELS`.
        progress: Called with each view.

    Returns:
        Plain data: info, images, categories, annotations.

    Raises:
        InputError: One is not a render, lacks the channels that this needs, or is given twice.
    """
    renders = [read_render(folder) for folder in folders]
    found = Annotations(taxonomy, _class_numbers(renders, taxonomy))
    count, done = sum(len(render.views) for render in renders), 0
    for place, render in zip(_places(folders), renders, strict=True):
        end = done + len(render.views)
        found.add(render, place, nested(progress, "", done / count, end / count))
        done = end
    return found.whole()


class Annotations:
    """What renders show, in COCO's form, gathered one render after the other.

    Args:
        taxonomy: Whose classes: ``category`` for our own, or a key of `CLASS_CHANNELS`.
        numbers: The number of every class; words of renders that have none get the next ones, here
            and for all who share this.
    """

    def __init__(self, taxonomy: str, numbers: dict[str, int]) -> None:
        self._taxonomy, self._numbers = taxonomy, numbers
        # Our own categories are in the legend.
        self._channel = CLASS_CHANNELS.get(taxonomy)
        self._images: list[Plain] = []
        self._annotations: list[Plain] = []
        self._stages: set[str] = set()
        self._conventions: Mapping[str, str] = {}
        if not numbers:
            numbers.update(_class_numbers((), taxonomy))

    @property
    def views(self) -> int:
        """How many views were added."""
        return len(self._images)

    def add(self, render: RenderedScene, place: str, progress: Progress = silent) -> None:
        """Add the views of a render.

        Args:
            render: The render.
            place: What the names of its pictures begin with.
            progress: Called with each view.

        Raises:
            InputError: It lacks the channels that this needs.
        """
        render.check(("instance", *([self._channel] if self._channel else [])))
        self._stages.add(render.manifest.stage or "?")
        self._conventions = self._conventions or render.manifest.conventions
        if self._channel is None:
            for word in sorted({*render.legend("category").values()} - self._numbers.keys()):
                self._numbers[word] = len(self._numbers) + 1
        for view in each(progress, "view", render.each(), len(render.views)):
            self._images.append(_image(view, place, self.views + 1))
            for instance, mask in masks(render, view):
                number = _class(render, view, instance, mask, self._channel, self._numbers)
                if number:
                    row = _annotation(mask, render.legend("instance")[instance], instance)
                    row |= {"image_id": self.views, "category_id": number}
                    self._annotations.append({"id": len(self._annotations) + 1, **row})

    def whole(self) -> Plain:
        """Plain data: info, images, categories, annotations."""
        return {
            "info": {
                "description": f"{', '.join(sorted(self._stages))}, classes of {self._taxonomy}",
                "version": f"{names.CREATOR} {__version__}",
                "conventions": self._conventions,
            },
            "images": self._images,
            "categories": [
                _category(name, number, self._taxonomy) for name, number in self._numbers.items()
            ],
            "annotations": self._annotations,
        }


def _places(folders: Sequence[Path]) -> list[str]:
    """What leads to each render from the folder that holds them all; one render is that folder."""
    whole = [os.path.realpath(folder) for folder in folders]
    if len(set(whole)) < len(whole):
        twice = next(folder for n, folder in enumerate(folders) if whole[n] in whole[:n])
        raise InputError("this render is given twice", place=twice, remedy="name it once")
    above = common_folder(whole)
    ways = (Path(folder).relative_to(above).as_posix() for folder in whole)
    return ["" if way == "." else f"{way}/" for way in ways]


def _category(name: str, number: int, taxonomy: str) -> Plain:
    """A class; those of COCO as its own files have them."""
    above = "structure" if name in names.SHELL else "object"
    if taxonomy == names.COCO:
        above = next(group for group, members in COCO_GROUPS.items() if name in members)
        name = name.replace("_", " ")
    return {"id": number, "name": name, "supercategory": above}


def masks(render: RenderedScene, view: RenderedView) -> Iterator[tuple[int, Mask]]:
    """The numbers of the instances that a view shows, each with its (height, width) pixels.

    Raises:
        InputError: The manifest does not name one of them.
    """
    labels, named = view.labels("instance"), render.legend("instance")
    seen = [int(number) for number in np.unique(labels) if number > 0]
    unknown = [number for number in seen if number not in named]
    if unknown:
        raise InputError(
            f"it shows the object {unknown[0]}, which the manifest does not name",
            place=view.folder / CHANNELS_FILE,
            remedy=AGAIN,
        )
    return ((number, labels == number) for number in seen)


def _class_numbers(renders: Sequence[RenderedScene], taxonomy: str) -> dict[str, int]:
    """The number of every class; in our own taxonomy, words that are not ours come last."""
    if taxonomy in TAXONOMIES:
        return {c: n for n, c in TAXONOMIES[taxonomy].items() if c != UNLABELED}
    seen = {name for render in renders for name in render.legend("category").values()}
    others = sorted(seen - set(classes()))
    return {c: n for n, c in enumerate([*classes(), *others], start=1)}


def _class(
    render: RenderedScene,
    view: RenderedView,
    instance: int,
    mask: Mask,
    channel: str | None,
    numbers: Mapping[str, int],
) -> int:
    if channel is None:
        return numbers.get(render.legend("category").get(instance, ""), 0)
    number = int(view.labels(channel)[mask][0])
    if number and number not in numbers.values():
        raise InputError(
            f"the channel {channel!r} holds {number}, which is not the number of a class",
            place=view.folder / CHANNELS_FILE,
            remedy=AGAIN,
        )
    return number


def _image(view: RenderedView, place: str, number: int) -> Plain:
    shown = "radiance" if "radiance" in view.entry.channels else "instance"
    return {
        "id": number,
        "file_name": f"{place}{view.name}/{preview_file(shown)}",
        "width": view.width,
        "height": view.height,
        "camera": view.entry.camera,
        "K": view.K.tolist(),
        "world_from_camera": view.entry.world_from_camera,
    }


def _annotation(mask: Mask, prim: str, instance: int) -> Plain:
    left, top, right, bottom = tight_box(mask)
    return {
        "prim": prim,
        "instance": instance,
        "bbox": [left, top, right - left, bottom - top],
        "area": int(mask.sum()),
        "segmentation": {"size": list(mask.shape), "counts": compressed(run_lengths(mask))},
        "iscrowd": 0,
    }
