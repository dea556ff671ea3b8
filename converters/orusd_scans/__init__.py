"""Importers of scans: each turns foreign files into the neutral Capture."""
