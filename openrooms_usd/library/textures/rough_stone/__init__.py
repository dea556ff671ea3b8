"""Stone, brick and concrete that scatter light: masonry, castings and slabs without polish.

`masonry`: laid; `quarried`: cast, scraped, and slabs without polish.
"""

from typing import Final

from openrooms_usd.library.textures.base.family import Family
from openrooms_usd.library.textures.rough_stone import masonry, quarried

FAMILIES: Final[dict[str, Family]] = {**masonry.FAMILIES, **quarried.FAMILIES}
