"""The layout: floor, ceiling, walls with real holes, and what fills these holes.

- `step`: the plan of a room, from a description or a capture, its shell and its partitions;
- `scanned`: what is found in a scan, or drawn over it, and the file of it;
- `openings`, `joinery`, `trim`, `beyond`: holes, what fills them, what runs along walls, and the
  hallways behind open doors.
"""
