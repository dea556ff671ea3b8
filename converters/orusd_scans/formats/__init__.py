"""Single files of points and pictures, of unknown origin, each read with limits.

- points: `ply`, `pcd`, `laser` (LAS, LAZ, E57; with `laz_reader`), `pointtext`;
- depth and other pictures of whole numbers: `depthpicture`.
"""
