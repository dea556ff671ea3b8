"""Single files of points and pictures, of unknown origin, each read with limits.

- points: `ply`, `pcd`, `obj`, `laser` (LAS, LAZ, E57; with `laz_reader`), `arrays` (NPZ),
  `pointtext` (with `columns` and `ptx`; its `rows` serve every format that is text);
- depth and other pictures of whole numbers: `depthpicture`.
"""
