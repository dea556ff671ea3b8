"""A stage as one USDZ file, in profiles: what those who open it can do with.

Importing this package does not import USD. `profiles` is the table; `exporter` is registered as
entry point, and says what is left out where the layers stay; `adapting` makes one plain layer of a
stage, with its textures, for those who read no more.
"""

from orusd_usdz.exporter import UsdzExporter

__all__ = ["UsdzExporter"]
