"""Where things are: units, axes, transforms, poses; who stands above whom; walls that stand free.

Modules: `ancestry`, `frames`, `metrics`, `placements`, `partitions`, `settled`.
"""
