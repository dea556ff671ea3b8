"""Rooms from nothing: pure functions of a room type, a seed and a few wishes.

- `boxes`, `polygons`, `shell`, `openings`, `finishing`: the empty room; `sizes`, `shapes`, `items`,
  `kit`: what may stand in it; `groups`, `programs`: what belongs together, and what rooms want;
- `floor`, `placement`, `walls`, `coatracks`, `curtains`, `fittings`: where it stands and
  hangs; `rooms`: all of it;
- `moments`, `environments`, `lighting`: when it is seen, where it lies, and which lamps are on;
- `clutter`: what lies about; `describing`, `writing`, `folders`: as text;
  `expansion`: inside a description; `statistics`.
"""

from openrooms_usd.generation.expansion import expanded
from openrooms_usd.generation.rooms import Generated, generate
from openrooms_usd.generation.writing import write

__all__ = ["Generated", "expanded", "generate", "write"]
