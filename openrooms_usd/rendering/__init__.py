"""Renders USD stages: the contract of renderers, and the driver that writes what they give.

``opening`` is the one way from a stage to its pictures, by the settings of
`openrooms_usd.description.rendering`. ``scene`` translates the stage, and ``contract`` is what an
adapter implements. ``context`` combines its light and the core's exact channels (``exact``), before
a ``lens`` if one is requested. ``plan`` says which cameras and channels, ``channel_plan`` which are
rendered, made of others (``shading``, ``friction``, ``denoise``, of all light) and written,
``given`` who gives them. ``driver`` renders into files: ``run`` writes a view beside the next one,
``frames`` are the times of a stage that moves. The files are ``exr``, ``previews``
(with ``tone`` and ``color``), ``sheet``, ``manifest`` and the ``folder`` of them all;
``storage`` says how they hold channels (``compact``, ``restoring`` read it). ``reading``
and ``manifest_schema`` give finished renders back and trust no file; ``relight``, ``probes``,
``datasets`` and ``coco`` (``cocosets``) use them.
``bake`` writes light as textures, ``paths`` renders walks as videos, ``sensors`` makes of views
what a real camera would have made of them.

Beside these: ``labelling`` (``boxes``, ``rle``), ``estimates`` of errors by ``halves``
and ``rare_light``, ``bias``, ``fits`` and ``light_store``, which keeps the light of a
room beside it.
"""

from openrooms_usd.rendering.contract import Image, Renderer, RenderRequest, RenderSession, View
from openrooms_usd.rendering.driver import RenderSummary, render_stage
from openrooms_usd.rendering.scene.legend import Legend

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
