"""Stone, brick and concrete that scatter light: masonry, castings and slabs without polish."""

from typing import Final

from openrooms_usd.library.textures import brick, concrete, masonry, quarried
from openrooms_usd.library.textures.family import Family

FAMILIES: Final[dict[str, Family]] = {
    **brick.FAMILIES,
    **masonry.FAMILIES,
    **concrete.FAMILIES,
    **quarried.FAMILIES,
}
