"""Doors, windows and passages in the walls of a scan.

- `wallfaces`, `wallvoids`, `wallpicture`: grids of evidence over each wall's face;
- `rectangles`, `wallholes`, `walllabels`: proposals of rectangles, from geometry and labels;
- `mirrors`, `curtains`, `doorframes`: false positives, hidden windows, closed doors;
- `detection`: scoring and non-maximum suppression.
"""
