"""Single files of unknown origin, each read with limits, every mistake with its place.

- points: `ply`, `pcd` (with `lzf`), `laser` (LAS, LAZ, E57; with `laz_reader`), `pointtext`;
- meshes: `meshfile`; depth and other pictures of whole numbers: `depthpicture`;
- records: `jsonfile`, `table`, and single values of them: `fields`.
"""
