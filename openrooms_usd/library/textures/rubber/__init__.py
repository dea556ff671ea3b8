"""Rubber: compounds as they are, and mats and treads that are moulded of them.

- `compound`: skins, granules and foams;
- `sheets`: studs, ribs, holes and treads, and the families of all.
"""

from openrooms_usd.library.textures.rubber.sheets import FAMILIES

__all__ = ["FAMILIES"]
