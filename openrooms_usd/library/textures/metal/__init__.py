"""Metal by its finish, its shape and its corrosion.

- `metals`: what metals reflect at normal incidence;
- `finishes`: by the tool that finished the face; `sheets`: by the press, roll or loom;
- `corroded`: what time makes of it.
"""

from typing import Final

from openrooms_usd.library.textures.base.family import Family
from openrooms_usd.library.textures.metal import corroded, finishes, sheets

FAMILIES: Final[dict[str, Family]] = {
    **finishes.FAMILIES,
    **sheets.FAMILIES,
    **corroded.FAMILIES,
}
