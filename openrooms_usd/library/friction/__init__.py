"""Friction by what a material is and how it looks.

``references`` holds published coefficients, and ``disks`` what such materials look like to a
camera. ``mapping`` finds similar looks of the same substance. ``table`` is the result on a grid,
which ``make`` writes and pictures are looked up in.
"""

from openrooms_usd.library.friction.mapping import Friction
from openrooms_usd.library.friction.table import friction_of, physics_of

__all__ = ["Friction", "friction_of", "physics_of"]
