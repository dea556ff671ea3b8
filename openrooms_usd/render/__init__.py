"""Renders USD stages: the contract of renderers, and the driver that writes what they give.

``driver`` is the story of a run: ``plan`` says what it shall render, ``given`` who gives which
channel, ``job`` holds both and opens the stage for them, ``scene`` translates the stage,
``frames`` are the times of one that moves, ``contract`` is what an adapter implements, ``opened``
puts its light and the core's exact channels together, ``shading``, ``friction`` and ``denoise``
(of all light: ``denoised_light``) make others of them, and ``run`` writes, beside the next view
(``writer``). The files are ``exr``, ``previews``
(with ``tone`` and ``color``), ``sheet``, ``manifest`` and the ``folder`` of them all;
``storage`` says how they hold channels (``compact``, ``restoring`` read it). ``reading``
and ``manifest_schema`` give finished renders back and trust no file; ``relight``, ``probes``,
``datasets`` and ``coco`` (``cocosets``) use them.
``bake`` writes light as textures, ``paths`` renders walks as videos, ``sensors`` makes of views
what a real camera would have made of them.

Beside these: ``labelling`` (``boxes``, ``rle``), ``estimates`` of errors by ``halves``
and ``rare_light``, ``bias``, ``fits``, ``lights`` and ``light_store``, which keeps the light of a
room beside it.
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
