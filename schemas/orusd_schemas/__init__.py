"""The codeless USD schemas of openrooms_usd; importing this package registers them with USD.

Registration is a convenience for readers (fallbacks, allowed values, documentation) and never a
precondition: what the stages author is the same with and without it. It must happen before USD
looks up the first prim definition. Other tools find the schemas by ``PXR_PLUGINPATH_NAME``, set to
`PATH`.
"""

from pathlib import Path
from typing import Final

from pxr import Plug

PATH: Final = Path(__file__).resolve().parent
"""The folder with plugInfo.json and generatedSchema.usda."""

__all__ = ["PATH"]

Plug.Registry().RegisterPlugins([str(PATH)])
