"""What was found, for people: a plan over the scan, with captions.

- `canvas`: drawing; `captions`: what colours mean; `overlay`: the whole picture.
"""
