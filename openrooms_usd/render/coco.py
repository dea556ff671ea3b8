"""What is seen in a finished render as one COCO file: boxes, areas and masks of its objects."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import names
from openrooms_usd.categories.record import UNLABELED
from openrooms_usd.channels import CLASS_CHANNELS
from openrooms_usd.errors import InputError
from openrooms_usd.render.folder import CHANNELS_FILE, preview_file
from openrooms_usd.render.manifest_schema import AGAIN
from openrooms_usd.render.reading import RenderedScene, RenderedView, read_render
from openrooms_usd.render.rle import compressed, run_lengths, tight_box
from openrooms_usd.usd.taxonomies import TAXONOMIES, classes
from openrooms_usd.version import __version__

Plain = dict[str, Any]


def coco(folder: Path, taxonomy: str = names.CATEGORY) -> Plain:
    """The visible objects of a render, in COCO's form.

    A segmentation holds the pixels whose centre shows the object, as compressed run lengths; the
    box is the least that holds them. What has no class in the taxonomy is left out.

    Args:
        folder: What `orusd render` wrote.
        taxonomy: Whose classes: ``category`` for our own, or a key of `CLASS_CHANNELS`.

    Returns:
        Plain data: info, images, categories, annotations.

    Raises:
        InputError: It is no render, or lacks the channels that this needs.
    """
    channel = CLASS_CHANNELS.get(taxonomy)  # our own categories are in the legend
    render = read_render(folder, ("instance", *([channel] if channel else [])))
    numbers = _class_numbers(render, taxonomy)
    images: list[Plain] = []
    annotations: list[Plain] = []
    for view in render.each():
        images.append(_image(view, len(images) + 1))
        for instance, mask in masks(render, view):
            number = _class(render, view, instance, mask, channel, numbers)
            if number:
                row = _annotation(mask, render.legend("instance")[instance], instance)
                row |= {"image_id": len(images), "category_id": number}
                annotations.append({"id": len(annotations) + 1, **row})
    return {
        "info": {
            "description": f"{render.manifest.stage}, classes of {taxonomy}",
            "version": f"{names.CREATOR} {__version__}",
            "conventions": render.manifest.conventions,
        },
        "images": images,
        "categories": [
            {"id": n, "name": c, "supercategory": "structure" if c in names.SHELL else "object"}
            for c, n in numbers.items()
        ],
        "annotations": annotations,
    }


def masks(render: RenderedScene, view: RenderedView) -> Iterator[tuple[int, NDArray[np.bool_]]]:
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


def _class_numbers(render: RenderedScene, taxonomy: str) -> dict[str, int]:
    """The number of every class; in our own taxonomy, words that are not ours come last."""
    if taxonomy in TAXONOMIES:
        return {c: n for n, c in TAXONOMIES[taxonomy].items() if c != UNLABELED}
    others = sorted(set(render.legend("category").values()) - set(classes()))
    return {c: n for n, c in enumerate([*classes(), *others], start=1)}


def _class(
    render: RenderedScene,
    view: RenderedView,
    instance: int,
    mask: NDArray[np.bool_],
    channel: str | None,
    numbers: Mapping[str, int],
) -> int:
    if channel is None:
        return numbers.get(render.legend("category").get(instance, ""), 0)
    number = int(view.labels(channel)[mask][0])
    if number and number not in numbers.values():
        raise InputError(
            f"the channel {channel!r} holds {number}, which is no number of a class",
            place=view.folder / CHANNELS_FILE,
            remedy=AGAIN,
        )
    return number


def _image(view: RenderedView, number: int) -> Plain:
    shown = "radiance" if "radiance" in view.entry.channels else "instance"
    return {
        "id": number,
        "file_name": f"{view.name}/{preview_file(shown)}",
        "width": view.width,
        "height": view.height,
        "camera": view.entry.camera,
        "K": view.entry.K,
        "world_from_camera": view.entry.world_from_camera,
    }


def _annotation(mask: NDArray[np.bool_], prim: str, instance: int) -> Plain:
    left, top, right, bottom = tight_box(mask)
    return {
        "prim": prim,
        "instance": instance,
        "bbox": [left, top, right - left, bottom - top],
        "area": int(mask.sum()),
        "segmentation": {"size": list(mask.shape), "counts": compressed(run_lengths(mask))},
        "iscrowd": 0,
    }
