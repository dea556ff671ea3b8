"""Friction by what a material is and how it looks.

``references`` holds what was published, ``disks`` what such materials look like to a
camera, ``mapping`` finds the ones that look alike among those of the same substance, and ``table``
is the result on a grid, which ``make`` makes and pictures are looked up in.
"""

from openrooms_usd.library.friction.mapping import Friction
from openrooms_usd.library.friction.table import friction_of, physics_of

__all__ = ["Friction", "friction_of", "physics_of"]
