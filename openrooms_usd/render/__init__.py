"""Renders USD stages: the contract of renderers, and the driver that writes what they give.

``contract`` is what an adapter implements; ``driver`` is the story of a run, ``plan`` what it shall
render and ``run`` what it has written; the other modules are the files: ``exr``, ``previews`` (with
``color``) and ``sheet`` (each whole), ``manifest`` and the ``folder`` of them all. ``reading`` and
``manifest_schema`` give finished renders back and trust no file.
"""

from openrooms_usd.render.contract import (
    Image,
    Renderer,
    RenderRequest,
    RenderSession,
    View,
)
from openrooms_usd.render.driver import RenderSummary, render_stage
from openrooms_usd.render.scene.legend import Legend

__all__ = [
    "Image",
    "Legend",
    "RenderRequest",
    "RenderSession",
    "RenderSummary",
    "Renderer",
    "View",
    "render_stage",
]
