"""Plastic: moulded and printed parts, and sheets on floors and furniture.

- `parts`: what the mould, the tool and the printer leave; `sheets`: laminates, vinyl, foils.
"""

from typing import Final

from openrooms_usd.library.textures.base.family import Family
from openrooms_usd.library.textures.plastic import parts, sheets

FAMILIES: Final[dict[str, Family]] = {**parts.FAMILIES, **sheets.FAMILIES}
