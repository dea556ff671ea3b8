"""Stone, brick and concrete that scatter light: masonry, castings and slabs without polish.

`brick`, `masonry`: laid; `concrete`: cast and scraped; `quarried`: slabs without polish.
"""

from typing import Final

from openrooms_usd.library.textures.base.family import Family
from openrooms_usd.library.textures.rough_stone import brick, concrete, masonry, quarried

FAMILIES: Final[dict[str, Family]] = {
    **brick.FAMILIES,
    **masonry.FAMILIES,
    **concrete.FAMILIES,
    **quarried.FAMILIES,
}
