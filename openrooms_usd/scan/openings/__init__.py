"""Doors, windows and passages in the walls of a scan.

- `wallfaces`, `wallvoids`, `wallpicture`: a wall seen from inside as a picture;
- `rectangles`, `wallholes`: proposals in it; `walllabels`: what labels say;
- `mirrors`, `curtains`, `doorframes`: what deceives, and what hides;
- `detection`: the openings that remain.
"""
