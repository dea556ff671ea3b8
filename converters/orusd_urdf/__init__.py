"""Rooms for robots: URDF, MJCF and UsdPhysics as export formats of USD stages, and two engines.

Importing this package imports neither USD nor an engine.
"""

from orusd_urdf.exporters import MjcfExporter, UrdfExporter, UsdPhysicsExporter

__all__ = ["MjcfExporter", "UrdfExporter", "UsdPhysicsExporter"]
