"""What each light sends straight to the first surface, with and without what stands between.

- ``receiver`` is that surface, and what reaches it.
- ``lamp_faces`` samples lamps, ``rectangles`` openings.
- ``closed_form`` is the exact irradiance of a triangle, for lamps of few faces.
- ``integrator`` combines these with light of the surroundings, and ``accumulator`` sums them by
  light and path.
- ``control_variate`` makes the channels of the sums.
"""
