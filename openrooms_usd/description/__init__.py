"""room.yaml and dataset.yaml: their models, how they are read, and their JSON Schemas.

- `scalars`, `reading`: YAML with places; `units`, `moments`: single values;
- `model`, `room`: the models, by section `layout`, `trim`,
  `polygon`, `scanned`, `generate`,
  `furniture`, `materials`, `lights`, `cameras`, `physics`;
- `dataset`: the model of dataset.yaml, and its `sensor`;
- `categories`, `families`, `styles`, `substances`: the names that may be used; `naming`: of what
  has none;
- `mistakes`, `diagnosis`, `advice`: what is wrong, in words, and what to write; `files`, `data`:
  of a file, of Python;
- `rewriting`: other values for some keys, every other byte as it stands;
- `schema`: the JSON Schema.
"""

from openrooms_usd.description.dataset import Dataset
from openrooms_usd.description.files import dump_room, load_dataset, load_room, parse_room
from openrooms_usd.description.furniture import named_objects
from openrooms_usd.description.layout import named_openings
from openrooms_usd.description.room import Room, room_of

__all__ = [
    "Dataset",
    "Room",
    "dump_room",
    "load_dataset",
    "load_room",
    "named_objects",
    "named_openings",
    "parse_room",
    "room_of",
]
