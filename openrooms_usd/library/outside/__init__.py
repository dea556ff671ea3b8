"""The world outside a room as a panorama: made by rules, lit by the sky of its moment.

- `noise`, `clouds`, `daylight`: fractal noise; clouds; sun and sky as what lights the land;
- `canvas`, `faces`, `shadows`: pixels of the panorama, flat faces on it, and what the sun misses;
- `facades`, `houses`, `sprites`, `plants`, `land`: what stands and lies there;
- `scenes`: where it stands: a street, a garden, hills, a courtyard, a city;
- `panorama`: all of it.
"""

from openrooms_usd.library.outside.panorama import outside_panorama
from openrooms_usd.library.outside.scenes import SCENES

__all__ = ["SCENES", "outside_panorama"]
