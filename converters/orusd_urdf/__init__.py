"""Rooms for robots: URDF, MJCF and UsdPhysics as export formats of USD stages, and two engines.

Importing this package imports neither USD nor an engine.

- `checking`, `naming`, `frames`, `boxes`, `looks`, `assets`, `objfile`: what the formats
  share; `reports`: what became of every prim;
- `robot`, `urdf`; `tree`, `springs`, `mjcf`; `usdphysics`: the three formats;
- `exporters`: as entry points; `packages`, `loading`, `bullet`, `mujoco_engine`: the engines.
"""

from orusd_urdf.exporters import MjcfExporter, UrdfExporter, UsdPhysicsExporter

__all__ = ["MjcfExporter", "UrdfExporter", "UsdPhysicsExporter"]
