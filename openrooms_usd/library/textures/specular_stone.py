"""Stone, ceramics and glass that shine: polished slabs, ground composites, glazed tiles."""

from typing import Final

from openrooms_usd.library.textures import aggregates, tiles, veins
from openrooms_usd.library.textures.family import Family

FAMILIES: Final[dict[str, Family]] = {**veins.FAMILIES, **aggregates.FAMILIES, **tiles.FAMILIES}
