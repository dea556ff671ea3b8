"""Mitsuba 3 as a renderer of scenes and as an export format of USD stages.

``adapter`` is what is registered. From there on, in the order of a render:

- ``variants`` finds the backend that works on this machine, ``llvm`` the libraries to try for it,
- ``session`` opens a translated scene (`openrooms_usd.rendering.scene`) and renders its cameras;
  ``limits`` says what a backend cannot have of it,
- ``plugins`` makes Mitsuba's objects of it, ``tracer`` finds triangles in these,
- ``render_passes`` says which pictures give which channels of light, ``pictures`` keeps these,
- ``transport`` and ``direct`` estimate these pictures, ``complete`` all of them at once; ``cache``
  keeps what is smooth in them, and ``bias`` says how far a method is off.

``export`` writes a stage as XML instead. Importing this package imports no renderer: the backend's
library has to be chosen before Mitsuba is loaded.
"""

from orusd_mitsuba.adapter import MitsubaExporter, MitsubaRenderer

__all__ = ["MitsubaExporter", "MitsubaRenderer"]
