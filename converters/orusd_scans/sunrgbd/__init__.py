"""SUN RGB-D: one frame becomes a Capture.

- `files`: the published files; `raw`: those of a raw frame; `importer`: all of it.
"""
