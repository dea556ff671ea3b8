"""Leathers: hides by their grain, and what is sewn, woven or punched of them.

- `hide`: the grain of leather, creases, pores and nap;
- `grains`: scales, quills and beads, and the families of all.
"""

from openrooms_usd.library.textures.leather.grains import FAMILIES

__all__ = ["FAMILIES"]
