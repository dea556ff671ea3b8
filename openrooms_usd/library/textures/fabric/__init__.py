"""Fabrics: woven, knitted, and of standing or matted fibres.

- `dyes`: the colours of threads; `weave`: which thread lies above; `woven`: a fabric of both,
  and the families of all; `pile`: standing fibres.
"""

from openrooms_usd.library.textures.fabric.woven import FAMILIES

__all__ = ["FAMILIES"]
