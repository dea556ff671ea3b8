"""Paint: what brush, roller and gun leave on sound ground, on plaster, and with age.

- `coats`: paint on sound ground; `plaster`: painted plaster, old paint, and wallpaper.
"""

from typing import Final

from openrooms_usd.library.textures.base.family import Family
from openrooms_usd.library.textures.paint import coats, plaster

FAMILIES: Final[dict[str, Family]] = {**coats.FAMILIES, **plaster.FAMILIES}
