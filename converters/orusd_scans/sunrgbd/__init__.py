"""SUN RGB-D: one frame becomes a Capture.

- `files`: the published files; `importer`: those of a raw frame, and all of it.
"""
