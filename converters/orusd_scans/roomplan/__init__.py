"""Apple RoomPlan: its exports, JSON or USDZ, become Captures.

- `shapes`, `meshes`, `components`, `usdz`: the USDZ as the records that its JSON
  holds;
- `records`: these, checked one by one; `curves`: curved walls;
- `spaces`: which room is meant, and what is in it;
- `heights`: how high it is, and where its ceiling follows the walls;
- `importer`: all of it.
"""
