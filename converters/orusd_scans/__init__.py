"""Importers of scans: each turns foreign files into the neutral Capture.

- `roomplan`, `scannet` (with Scan2CAD's models), `sunrgbd`, `arkitscenes`, `s3dis`: known captures;
- `boxes`: a list of boxes; `plainscan`: any cloud or mesh, whose rooms are found later,
  `segments`: a segmentation beside it, `scanaxes`: which way is up and how long its unit
  is;
- `formats`: files of points, meshes and depth; `records`: JSON and tables;
- `floorplan`, `plan`, `frames`, `worldframe`, `scanned`, `surfaces`: what several of them share.
"""
