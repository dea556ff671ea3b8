"""Metal by its finish, its shape and its corrosion."""

from typing import Final

from openrooms_usd.library.textures import corroded, metalfinish, sheetmetal
from openrooms_usd.library.textures.family import Family

FAMILIES: Final[dict[str, Family]] = {
    **metalfinish.FAMILIES,
    **sheetmetal.FAMILIES,
    **corroded.FAMILIES,
}
