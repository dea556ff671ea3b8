"""How near a twin is to what was captured: photographs and renders from the same cameras.

``driver`` compares and draws the results side by side. ``photographs`` puts the capture's cameras
and points in the composed room. ``scandepth`` gives the distance of the scan from a camera.
``appearance.edges`` counts edges of a render's geometry that a photograph has.
"""
