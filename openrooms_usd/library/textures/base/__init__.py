"""What all substances are made with: arrays, noise, cells, and the order that a recipe gets.

From the ground up:

- `noise`: periodic noise; `maps`: a material as arrays, then as the integers of files;
- `family`: what a family of materials is; `recipe`: its draws, means, colours and gloss;
- `vocabulary`: all of these words in one name;
- `lattice`, `cells`, `courses`: repeats, cells about sites and scales, pieces in courses;
- `strewn`: single things, fibres and slivers on a surface.
"""
