"""How near a twin is to what was captured: photographs and renders from the same cameras.

``driver`` is the story, and shows it side by side: ``photographs`` stands the capture's cameras and
points in the composed room, ``scandepth`` says how far the scan is from a camera, ``edges`` finds
edges in a photograph and in a render's geometry and counts those that meet.
"""
