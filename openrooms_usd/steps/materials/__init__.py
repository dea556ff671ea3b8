"""The materials: what every surface of the room is made of.

- `step`: all bindings, those of the shell first;
- `palette`, `appearance`: the materials of a room, as they are chosen and as prims;
- `dressing`, `looks`: what parts get, and the layers of objects' looks.
"""
