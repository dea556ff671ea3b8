"""Doors, windows and passages in the walls of a scan.

- `cellcounts`: the inner faces of walls, and returns over their cells;
- `wallpicture`: grids of evidence over each wall's face;
- `rectangles`, `wallholes`: proposals of rectangles from geometry;
- `judgement`: those from labels and of closed doors, and how likely each is, by weighed evidence;
- `detection`: what is kept, by labels and likelihood, and non-maximum suppression, without mirrors
  and with windows behind curtains.
"""
