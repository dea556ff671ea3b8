"""What all substances are made with: arrays, noise, cells, and the order that a recipe gets.

From the ground up:

- `noise`: periodic noise; `maps`: a material as arrays, then as the integers of files;
- `expanse`, `wear`: small pictures laid over metres, and the marks of use;
- `family`: what a family of materials is; `recipe`, `tints`: its draws, means, colours and gloss;
- `lattice`, `cells`, `courses`: repeats, cells about sites, pieces in courses;
- `strewn`, `scales`, `fibres`, `flakes`: single things, scallops, fibres and slivers on a surface.
"""
