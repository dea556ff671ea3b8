"""Physical plausibility of aligned objects: upright, supported, inside the room, not penetrating.

- `bodies`, `chords`, `penetration`: meshes as solids, and translational penetration depths;
- `enclosure`, `support`: the room's boundary, and the support
  relation;
- `arrangement`: the poses so far; `settling`: tilt, supports, and yaw along walls;
- `spreading`: penetrations resolved by a quadratic program;
- `violations`: what is still wrong; `fitting`: what has no room is shortened; `leavingout`:
  without which objects nothing is wrong; `correcting`: all, and what floats is lowered.
"""
