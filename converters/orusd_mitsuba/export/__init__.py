"""A stage as a Mitsuba XML scene.

- ``exporter`` tells the story: cameras, lights, surfaces, and the files beside them.
- ``xml_text`` writes plugin descriptions as XML, ``ply`` meshes.
"""
