"""What a backend cannot have of a scene or give of it, in words."""

import math
import os
from typing import Final

from openrooms_usd.channels import CHANNELS
from openrooms_usd.errors import InputError, RenderError
from openrooms_usd.rendering import RenderRequest
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.instances import Instances
from openrooms_usd.rendering.scene.models import MODELS, Model
from orusd_mitsuba.variants import Backend, vectorized_remedy

_MANY_EXPANDED_TRIANGLES: Final = 4_000_000
# What an expanded triangle takes at most, with Embree's share, measured.
_BYTES_EXPANDED: Final = 250


def affordable_model(name: str, backend: Backend) -> Model:
    """A reflectance model as a backend can have it.

    Args:
        name: One of `openrooms_usd.rendering.scene.models.MODELS`.
        backend: A scalar one would call Python for every scattering of ``auto``.

    Raises:
        InputError: No reflectance model has that name.
    """
    for model in MODELS:
        if model == name:
            scalar = backend.variant.startswith("scalar")
            return "preview" if model == "auto" and scalar else model
    raise InputError(
        f"unknown reflection model: {name!r}", place="bsdf", remedy=f"one of: {', '.join(MODELS)}"
    )


def report_panes(scene: Scene) -> None:
    """Say in the report how scalar backends see clear panes."""
    lost = (
        "the scalar backend tints light equally at every angle, and treats half of a solid as "
        "its pane"
    )
    panes = {id(pane.surface) for pane in scene.panes}
    scene.report.lose({path: lost for path, found in scene.owners if id(found) in panes})


def expanded_triangles(scene: Scene) -> int:
    """How many triangles instances would be for a backend that expands them; 0 where they are few.

    Then it takes longer to expand them than to render a picture of them.
    """
    parts = [part for patch in scene.patches for part in patch.triangles.parts]
    expanded = sum(len(part) for part in parts if isinstance(part, Instances))
    return expanded if expanded >= _MANY_EXPANDED_TRIANGLES else 0


def instances_advice(scene: Scene) -> str:
    """What to do where a vectorized backend expands very many instances; empty with few.

    Raises:
        RenderError: They do not fit into this machine's memory.
    """
    expanded = expanded_triangles(scene)
    if not expanded:
        return ""
    needed, there = expanded * _BYTES_EXPANDED, _memory()
    if needed > there:
        raise RenderError(
            f"instances would be expanded to {expanded / 1e6:.0f} million triangles, which need "
            f"about {needed / 1e9:.0f} GB of this machine's {there / 1e9:.0f}",
            remedy="use --variant scalar, which keeps instances as they are",
        )
    return (
        f"instances are expanded to {expanded / 1e6:.0f} million triangles; --variant scalar "
        "keeps instances: it starts sooner, needs less memory, and has fewer channels"
    )


def kept_advice(scene: Scene) -> str:
    """The remedy if instances are kept because there are so many, without a request."""
    expanded = expanded_triangles(scene)
    return (
        f"the variant scalar keeps instances of {expanded / 1e6:.0f} million triangles; --variant "
        "llvm expands them, which needs memory, and has all channels"
    )


def check_channels(request: RenderRequest, variant: str) -> None:
    """Refuse what scalar backends have not.

    Raises:
        RenderError: With the channels, and what has them.
    """
    if many := [name for name in request.channels if CHANNELS[name].extra]:
        check_vectorized(variant, f"give {', '.join(many)}")


def check_vectorized(variant: str, what: str) -> None:
    """Refuse what scalar backends cannot do.

    Raises:
        RenderError: With what can do it on this machine, or how it can be had.
    """
    if variant.startswith("scalar"):
        raise RenderError(f"the backend {variant} cannot {what}", remedy=vectorized_remedy())


def _memory() -> float:
    """Bytes of this machine's memory; endless where it does not say."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):
        return math.inf
