"""Who gives which channel: a renderer its own, the core the exact ones, and what they make."""

from typing import Final

from openrooms_usd import adapters
from openrooms_usd.channels import CHANNELS, RENDERED
from openrooms_usd.errors import MissingPackageError
from openrooms_usd.render import friction, shading
from openrooms_usd.render.contract import Renderer

EXACT: Final = tuple(name for name in RENDERED if CHANNELS[name].kind != "light")
"""The channels of geometry, materials and labels, which the core makes for every renderer."""


def rendered(own: tuple[str, ...]) -> tuple[str, ...]:
    """What can be rendered with a renderer that gives some channels of its own."""
    return tuple(name for name in RENDERED if name in own or name in EXACT)


def available(own: tuple[str, ...]) -> tuple[str, ...]:
    """The same, and what can be made of it."""
    given = rendered(own)
    return (*given, *friction.derivable(given), *shading.derivable(given))


def remedy_for(channel: str) -> str:
    """How to come by a channel that the chosen renderer does not give."""
    found = [name for name in adapters.available(adapters.RENDERERS) if _gives(name, channel)]
    if not found:
        return "no renderer that is installed gives it"
    return " or ".join(f"--renderer {name}" for name in found) + " gives it"


def _gives(renderer: str, channel: str) -> bool:
    try:
        adapter: Renderer = adapters.load(adapters.RENDERERS, renderer)
    except MissingPackageError:
        return False
    return channel in available(tuple(adapter.channels))
