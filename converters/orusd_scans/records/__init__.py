"""Records of unknown origin, read with limits, every mistake with its place.

- `fields`: single values, checked; `jsonfile`: JSON; `table`: CSV.
"""
