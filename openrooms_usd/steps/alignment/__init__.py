"""The alignment: furniture as references to published assets, each at its place.

- `step`: all objects, their prims, and what follows when people move something;
- `catalogue`, `surroundings`, `placement`, `poses`: assets, the room as it stands, what carries
  what, and how a pose is written;
- `captured`, `aligned`, `apart`: boxes and CADs of captures, and what stands in another;
- `furnished`, `instances`, `shelf`: the things of a scan, and what stands for them.
"""
