"""Doors, windows and passages in the walls of a scan.

- `cellcounts`: the inner faces of walls, and returns over their cells;
- `wallpicture`: grids of evidence over each wall's face;
- `rectangles`, `wallholes`, `walllabels`: proposals of rectangles, from geometry and labels;
- `doorframes`: closed doors;
- `judgement`: how likely a proposal is, by weighed evidence;
- `detection`: what is kept, by labels and likelihood, and non-maximum suppression, without mirrors
  and with windows behind curtains.
"""
