"""Apple RoomPlan: its exports, JSON or USDZ, become Captures.

- `shapes`, `meshes`, `components`, `usdz`: the USDZ as the records that its JSON
  holds;
- `records`: these, checked one by one; `curves`: curved walls;
- `spaces`: which room is meant, and what is in it;
- `importer`: all of it.
"""
