"""Parts of buildings as meshes: what a room is closed by, what stands in it, what it wears.

- `faces`, `walls`, `partitions`, `openings`, `shell`, `roofs`: the shell of a room;
- `leaves`, `doors`, `windows`, `hallways`: what stands in its openings, and behind them;
- `wallruns`, `mouldings`, `claddings`, `ceilings`: what it wears.
"""
