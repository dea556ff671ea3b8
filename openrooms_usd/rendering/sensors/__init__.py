"""What a real camera would have made of a view: applied after the truth, and written beside it.

``structured_light`` is a depth camera that projects a pattern. ``recording`` distorts as OpenCV's
model does, counts electrons and reads them out; it puts them together and
writes the files (docs/reference/sensors.md).
"""
