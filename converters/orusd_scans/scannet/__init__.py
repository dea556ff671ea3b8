"""ScanNet: a scene becomes a Capture.

- `frames`, `sens`: poses, intrinsics and depth; `labels`: classes and instances of vertices;
- `importer`: all of it.
"""
