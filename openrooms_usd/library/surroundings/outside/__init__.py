"""The world outside a room as a panorama: made by rules, lit by the sky of its moment.

- `noise`, `daylight`: fractal noise; clouds, sun and sky as what lights the land;
- `canvas`, `faces`, `shadows`: pixels of the panorama, flat faces on it, and what the sun misses;
- `facades`, `houses`, `plants`, `land`: what stands and lies there;
- `scenes`: where it stands: a street, a garden, hills, a courtyard, a city;
- `foliage`, `ledges`: plants as meshes, and what is outside at windows;
- `near`, `solid`, `site`: which of it is near a room, that as meshes, and where the room stands;
- `panorama`: all that is far.
"""

from openrooms_usd.library.surroundings.outside.panorama import outside_panorama
from openrooms_usd.library.surroundings.outside.scenes import SCENES
from openrooms_usd.library.surroundings.outside.site import Site

__all__ = ["SCENES", "Site", "outside_panorama"]
