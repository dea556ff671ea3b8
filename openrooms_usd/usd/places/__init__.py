"""Where things are: units, axes, transforms, poses; walls that stand free.

Modules: `frames`, `metrics`, `placements`, `partitions`, `settled`.
"""
