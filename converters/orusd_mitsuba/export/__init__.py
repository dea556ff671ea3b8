"""A stage as a Mitsuba XML scene.

- ``exporter`` tells the story: cameras, lights, surfaces, and the files beside them;
  it writes plugin descriptions as XML and meshes as PLY.
"""
