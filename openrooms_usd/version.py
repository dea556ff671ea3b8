"""The version of the package; it imports nothing, so that everything may say it."""

__version__ = "0.2.0"
