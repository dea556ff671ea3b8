"""Wood: pieces cut from a tree, floors laid of it, and boards made of its parts.

- `species`: what distinguishes woods; `boards`: pieces side by side;
- `timber`: the face of one piece, with its knots;
- `solid`: veneers, staves and planks; `woodbased`: floors; strands, particles, cork.
"""

from typing import Final

from openrooms_usd.library.textures.base.family import Family
from openrooms_usd.library.textures.wood import solid, woodbased

FAMILIES: Final[dict[str, Family]] = {**solid.FAMILIES, **woodbased.FAMILIES}
