"""How near a twin is to what was captured: photographs and renders from the same cameras.

``driver`` compares and draws the results side by side. ``photographs`` puts the capture's cameras
and points in the composed room. ``scandepth`` gives the distance of the scan from a camera.
``edges`` finds edges in a photograph and in a render's geometry and counts those that match.
"""
