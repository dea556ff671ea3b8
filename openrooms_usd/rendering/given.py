"""Who gives which channel: a renderer its own, the core the exact ones, and what they make.

And by which method a session gives them.
"""

from typing import Final

from openrooms_usd import adapters
from openrooms_usd.channels import CHANNELS, RENDERED
from openrooms_usd.description.rendering import CACHE, REFERENCE, Method
from openrooms_usd.errors import MissingPackageError, RenderError
from openrooms_usd.rendering import friction, shading
from openrooms_usd.rendering.contract import (
    MethodicalSession,
    Renderer,
    RenderRequest,
    RenderSession,
)

PATHS_WORTH_A_CACHE: Final = 8e6
"""From so many paths on it takes less time to fill a light cache first."""

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
        return "no installed renderer gives it"
    return " or ".join(f"--renderer {name}" for name in found) + " gives it"


def _gives(renderer: str, channel: str) -> bool:
    try:
        adapter: Renderer = adapters.load(adapters.RENDERERS, renderer)
    except MissingPackageError:
        return False
    return channel in available(tuple(adapter.channels))


def choose_method(asked: Method | None, session: RenderSession, paths: float = 0.0) -> Method:
    """The method of a render: what is asked for, or what takes less time.

    What depends on a machine does not count, nor whether a cache is there: equal requests have
    equal methods.

    Args:
        asked: A method, or None.
        session: What renders.
        paths: About how many paths the render follows: see `openrooms_usd.rendering.plan.paths_of`.

    Raises:
        RenderError: The session does not have the method.
    """
    has = session.methods if isinstance(session, MethodicalSession) else (REFERENCE,)
    if asked is not None and asked not in has:
        raise RenderError(
            f"{session.backend} does not have the method {asked!r}",
            remedy=f"it has {' and '.join(has)}; omit --method",
        )
    worth = CACHE in has and paths >= PATHS_WORTH_A_CACHE
    return asked or (CACHE if worth else REFERENCE)


def check_request(request: RenderRequest, own: tuple[str, ...], session: RenderSession) -> None:
    """See that a picture can be made.

    Args:
        request: What is asked for.
        own: The channels that the renderer gives.
        session: What renders.

    Raises:
        RenderError: Nothing gives a channel, or it has no pixels.
    """
    choose_method(request.method, session)
    for name in request.channels:
        if name not in own and name not in EXACT:
            raise RenderError(
                f"this renderer does not give the channel {name!r}", remedy=remedy_for(name)
            )
    if request.width < 1 or request.height < 1 or request.bounces < 0:
        raise RenderError(
            f"a picture cannot have {request.width}x{request.height} pixels and {request.bounces} "
            "bounces",
            remedy="give a positive resolution and at least 0 bounces",
        )
