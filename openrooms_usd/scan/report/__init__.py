"""What was found, for people: a plan over the scan, with captions.

- `canvas`: drawing; `overlay`: the whole picture, and what its colours mean.
"""
