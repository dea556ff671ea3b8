"""Samples as tensors of torch, and batches of them (extra ``torch``).

Images are (components, height, width), labels (height, width) int64, what there is of every light
has the lights first, hemispheres stay (rows, columns, elevations, azimuths, 3).
"""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from openrooms_usd.channels import CHANNELS, definition
from openrooms_usd.errors import InputError, MissingPackageError
from openrooms_usd.loading.sample import Array, Sample, is_label

try:
    import torch as torch
except ImportError as error:
    raise MissingPackageError(
        "training needs the package 'torch'", remedy="pip install 'openrooms-usd[torch]'"
    ) from error

Tensors = dict[str, Any]
"""Tensors by the names of channels and of what goes with them; names and the like as texts."""

MASK: Final = "light_mask"
# What has a row for each light besides the channels of lights.
_OF_LIGHTS: Final = ("light_numbers", "world_from_box", "box_size")


def tensors_of(sample: Sample) -> Tensors:
    """A sample as tensors.

    Returns:
        The channels by their names; ``K`` (3, 3), ``world_from_camera`` (4, 4), ``mirrored`` and
        ``light_scale``; where there are channels of lights, ``light_numbers`` (lights,),
        ``world_from_box`` (lights, 4, 4) and ``box_size`` (lights, 3); ``name``, and the texts of
        `Sample.about`.
    """
    found: Tensors = {
        "name": sample.name,
        **sample.about,
        "K": _floats(sample.K),
        "world_from_camera": _floats(sample.world_from_camera),
        "mirrored": torch.tensor(sample.mirrored),
        "light_scale": torch.tensor(sample.light_scale, dtype=torch.float32),
    }
    for name, pixels in {**sample.images, **sample.lights}.items():
        label = is_label(definition(name))
        found[name] = _tensor(pixels[..., 0] if label else np.moveaxis(pixels, -1, -3))
    found |= {name: _tensor(grid) for name, grid in sample.grids.items()}
    if sample.lights:
        numbers = np.array(sample.light_numbers, np.int64)
        boxes = _floats(sample.world_from_box), _floats(sample.box_size)
        found |= dict(zip(_OF_LIGHTS, (_tensor(numbers), *boxes), strict=True))
    return found


def collate(samples: Sequence[Mapping[str, Any]]) -> Tensors:
    """A batch of what `tensors_of` gives.

    Returns:
        Tensors with the samples first, texts as lists. What has a row for each light is filled up
        with zeros to the most lights of a sample; ``light_mask`` (samples, lights) says which are
        there.

    Raises:
        InputError: The samples have not the same channels, or not the same size.
    """
    first = samples[0]
    if any(set(one) != set(first) for one in samples):
        raise InputError("the views of a batch have different channels")
    batch: Tensors = {}
    for name, value in first.items():
        values = [one[name] for one in samples]
        if not isinstance(value, torch.Tensor):
            batch[name] = values
            continue
        if _is_of_lights(name):
            values = _filled(values)
        if len({one.shape for one in values}) > 1:
            sizes = " and ".join(sorted({str(tuple(one.shape)) for one in values}))
            raise InputError(
                f"the views of a batch have {name!r} in sizes {sizes}",
                remedy="crop or resize them to one size, or use batches of one",
            )
        batch[name] = torch.stack(values)
    if "light_numbers" in first:
        counts = torch.tensor([len(one["light_numbers"]) for one in samples])
        batch[MASK] = torch.arange(int(counts.max())) < counts[:, None]
    return batch


def _is_of_lights(name: str) -> bool:
    return name in _OF_LIGHTS or (name in CHANNELS and CHANNELS[name].scope == "light")


def _filled(values: Sequence[Any]) -> list[Any]:
    """Tensors with as many rows as the longest has."""
    most = max(len(one) for one in values)
    return [torch.cat([one, one.new_zeros((most - len(one), *one.shape[1:]))]) for one in values]


def _tensor(array: Array) -> Any:
    return torch.from_numpy(np.ascontiguousarray(array))


def _floats(array: Array) -> Any:
    return _tensor(array.astype(np.float32))
