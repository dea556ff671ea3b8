"""ARKitScenes: a scan becomes a Capture.

- `path`: the camera's path, and depth of single moments; `importer`: all of it.
"""
