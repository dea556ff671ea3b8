"""Physical plausibility of aligned objects: upright, supported, inside the room, not penetrating.

- `bodies`, `penetration`: meshes as solids, and translational penetration depths;
- `enclosure`, `support`: the room's boundary, and the support relation;
- `arrangement`: the poses so far; `settling`: tilt, supports, yaw along walls, and what is still
  wrong;
- `spreading`: penetrations resolved by a quadratic program;
- `fitting`: what has no room is shortened, or left out;
- `correcting`: all, and what floats is lowered.
"""
