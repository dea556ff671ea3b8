"""A stage as one USDZ file, in profiles: what those who open it can do with.

Importing this package does not import USD. `profiles` is the table; `exporter` is registered as
entry point; `adapting` makes one plain layer of a stage for those who read no more, with its
`textures`; `leaving` says what is left out where the layers stay.
"""

from orusd_usdz.exporter import UsdzExporter

__all__ = ["UsdzExporter"]
