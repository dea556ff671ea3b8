"""What a real camera would have made of a view: applied after the truth, and written beside it.

``lens`` distorts as OpenCV's model does, ``photons`` counts electrons and reads them out, and
``structured_light`` is a depth camera that projects a pattern. ``recording`` puts them together and
writes the files (docs/sensors.md).
"""
