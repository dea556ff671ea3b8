"""Stone, ceramics and glass that shine: polished slabs, ground composites, glazed tiles.

`aggregates`: polished slabs, and composites that were ground; `tiles`: glazed and polished.
"""

from typing import Final

from openrooms_usd.library.textures.base.family import Family
from openrooms_usd.library.textures.specular_stone import aggregates, tiles

FAMILIES: Final[dict[str, Family]] = {**aggregates.FAMILIES, **tiles.FAMILIES}
