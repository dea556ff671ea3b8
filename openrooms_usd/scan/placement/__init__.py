"""Found objects put where they can be: upright, on what carries them, in the room, apart.

- `bodies`, `chords`, `penetration`: meshes as solids, and how deep two reach into each other;
- `enclosure`, `support`: the room around them, and what carries them;
- `arrangement`: where each one stands; `settling`: upright and flat;
- `least_motion`, `spreading`: apart by the least motion; `correcting`: all of it.
"""
