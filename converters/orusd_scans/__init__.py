"""Importers of scans: each turns foreign files into the neutral Capture.

- `roomplan`, `scan2cad`, `scannet`, `sunrgbd`, `arkitscenes`: captures of known kinds;
- `boxes`: a list of boxes; `plainscan`: any cloud or mesh, whose rooms are found later;
- `formats`: files of points, meshes, depth, text and tables, read with limits;
- `floorplan`, `plan`, `frames`, `worldframe`, `packing`, `scanned`, `surfaces`, `synsets`: what
  several of them share.
"""
