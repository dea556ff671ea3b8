"""A stage opened for a renderer of a test."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pxr import Usd

from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.contract import NO_OPTIONS, Renderer
from openrooms_usd.rendering.opening import open_for_rendering


def open_with(
    renderer: Renderer, stage: Path | Usd.Stage, options: Mapping[str, str] = NO_OPTIONS, **how: Any
) -> RenderContext:
    """What a renderer, which need not be registered, makes of a stage; by settings by name."""
    settings = RenderSettings(options=dict(options), **how)
    return open_for_rendering(stage, settings, renderer=renderer)
