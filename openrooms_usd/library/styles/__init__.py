"""Styles of rooms: finishes, lamps, screens, and which material things are made of.

Modules: `interiors`, `ensembles`, `finishes`, `beams`, `displays`, `assignment`.
"""
