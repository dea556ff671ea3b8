"""Metal by its finish, its shape and its corrosion.

- `metals`: what metals reflect at normal incidence;
- `finishes`: by the tool that finished the face, and what time makes of it;
- `sheets`: by the press, roll or loom.
"""

from typing import Final

from openrooms_usd.library.textures.base.family import Family
from openrooms_usd.library.textures.metal import finishes, sheets

FAMILIES: Final[dict[str, Family]] = {**finishes.FAMILIES, **sheets.FAMILIES}
