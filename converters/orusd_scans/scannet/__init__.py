"""ScanNet: a scene becomes a Capture, also with the CADs that Scan2CAD aligned to it.

- `frames`: poses, intrinsics and depth; `labels`: classes and instances of vertices;
- `importer`, `scan2cad`: the two importers, the latter with its models in the frame of the scan.
"""
