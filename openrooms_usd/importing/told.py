"""Lights, materials and cameras that a capture knows itself, as sections of the description."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from openrooms_usd.capture import Capture


def tells_lights(capture: Capture) -> bool:
    """Whether a capture knows what shines, so that no lamp need be invented."""
    return capture.environment is not None


def light_lines(capture: Capture) -> Iterator[str]:
    """The section ``lights``: what shines in, and what each lamp emits."""
    assert capture.environment is not None
    yield f"environment: {_flow(capture.environment)}"
    names = object_names(capture)
    lamps = [model for model in capture.models if model.radiance is not None]
    if lamps:
        yield "# Nits of each primary."
        yield "lamps:"
    for model in lamps:
        yield f"  {names[model.id]}: {_flow({'radiance': list(model.radiance or ())})}"


def material_lines(capture: Capture) -> Iterator[str]:
    """The section ``materials``: the shell, and parts whose file does not say what they are."""
    for part, look in capture.shell.items():
        yield f"{part}: {_flow(look)}"
    names = object_names(capture)
    dressed = [model for model in capture.models if model.looks]
    if dressed:
        yield "overrides:"
    for model in dressed:
        yield f"  {names[model.id]}: {_flow(model.looks)}"


def object_names(capture: Capture) -> dict[str, str]:
    """What the objects of a capture will be called, by their identifiers in it."""
    # What places objects needs USD, which takes a moment to import.
    from openrooms_usd.stages.aligned import with_boxes
    from openrooms_usd.stages.captured import captured_objects

    objects = captured_objects(with_boxes(capture), 0.0, (), [])
    return {thing.box.id: thing.name for thing in objects}


def _flow(value: Mapping[str, Any]) -> str:
    """JSON, which is YAML."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
