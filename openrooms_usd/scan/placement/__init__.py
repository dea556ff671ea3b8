"""Physical plausibility of aligned objects: upright, supported, inside the room, not penetrating.

- `bodies`, `chords`, `penetration`: meshes as solids, and translational penetration depths;
- `elsewhere`: things of other rooms; `enclosure`, `support`: the room's boundary, and the support
  relation;
- `arrangement`: the poses so far; `settling`: tilt, supports, and yaw along walls;
- `least_motion`, `spreading`: penetrations resolved by a quadratic program;
- `violations`: what is still wrong; `landing`, `fitting`: what floats is lowered, and what has no
  room is shortened; `leavingout`: without which objects nothing is wrong; `correcting`: all.
"""
