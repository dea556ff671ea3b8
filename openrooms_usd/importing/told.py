"""Lights, materials and cameras that a capture knows itself, as sections of the description."""

import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from openrooms_usd.capture import Capture

if TYPE_CHECKING:
    from openrooms_usd.stages.alignment.captured import Captured


def tells_lights(capture: Capture) -> bool:
    """Whether a capture knows what shines, so that no lamp need be invented."""
    return capture.environment is not None


def light_lines(capture: Capture) -> Iterator[str]:
    """The section ``lights``: what shines in, and what each lamp emits."""
    assert capture.environment is not None
    yield f"environment: {_flow(capture.environment)}"
    found = _objects(capture)
    # What stands for a lamp may be none: a box has no bulb.
    lamps = [
        model
        for model in capture.models
        if model.radiance is not None and (model.file or _emits(found[model.id].category))
    ]
    if lamps:
        yield "# Nits of each primary."
        yield "lamps:"
    for model in lamps:
        yield f"  {found[model.id].name}: {_flow({'radiance': list(model.radiance or ())})}"


def material_lines(capture: Capture) -> Iterator[str]:
    """The section ``materials``: the shell, and parts whose file does not say what they are."""
    for part, look in capture.shell.items():
        yield f"{part}: {_flow(look)}"
    found = _objects(capture)
    dressed = [model for model in capture.models if model.looks]
    if dressed:
        yield "overrides:"
    for model in dressed:
        yield f"  {found[model.id].name}: {_flow(model.looks)}"


def _objects(capture: Capture) -> "dict[str, Captured]":
    """The objects of a capture as they will be placed, by their identifiers in it."""
    # What places objects needs USD, which takes a moment to import.
    from openrooms_usd.stages.alignment.aligned import with_boxes
    from openrooms_usd.stages.alignment.captured import captured_objects

    return {one.box.id: one for one in captured_objects(with_boxes(capture), 0.0, (), [])}


def _emits(name: str) -> bool:
    from openrooms_usd.furniture import category

    return category(name).emits


def _flow(value: Mapping[str, Any]) -> str:
    """JSON, which is YAML."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
