"""A declarative USD toolkit for photorealistic indoor scenes with ground truth.

The names below are loaded on first use, so that ``import openrooms_usd`` costs nothing: ``pxr``,
``mitsuba`` and ``scipy`` are imported by the functions that need them.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from openrooms_usd.version import __version__ as __version__

if TYPE_CHECKING:
    from openrooms_usd.compose import compose_room as compose_room
    from openrooms_usd.convert import convert_stage as convert_stage
    from openrooms_usd.description import load_room as load_room
    from openrooms_usd.errors import OrusdError as OrusdError
    from openrooms_usd.render import render_stage as render_stage
    from openrooms_usd.validate import validate_stage as validate_stage

_HOME = {
    "OrusdError": "openrooms_usd.errors",
    "compose_room": "openrooms_usd.compose",
    "convert_stage": "openrooms_usd.convert",
    "load_room": "openrooms_usd.description",
    "render_stage": "openrooms_usd.render",
    "validate_stage": "openrooms_usd.validate",
}

__all__ = [
    "OrusdError",
    "__version__",
    "compose_room",
    "convert_stage",
    "load_room",
    "render_stage",
    "validate_stage",
]


def __getattr__(name: str) -> Any:
    """Load a public name from its module on first use (PEP 562)."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value
