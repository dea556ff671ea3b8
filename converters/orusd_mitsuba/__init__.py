"""Mitsuba 3 as a renderer and as an export format of USD stages.

Importing this package imports no renderer: the backend's library has to be chosen before Mitsuba
is loaded (see `orusd_mitsuba.variants`).
"""

from orusd_mitsuba.adapter import MitsubaExporter, MitsubaRenderer

__all__ = ["MitsubaExporter", "MitsubaRenderer"]
