"""ARKitScenes: a scan becomes a Capture.

- `importer`: the camera's path, depth of single moments, and all of it.
"""
