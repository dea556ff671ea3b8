"""What scans become, on simulated scans whose truth is known: ``python -m benchmarks.scan``.

- `rooms`, `corridors`: rooms; `scanner` with `path`, `depth`, `fusion`, `labels`: their scans;
- `truth`, `symmetry`, `hints`: what is true, and what a user knows;
- `scores`, `pose_scores`, `contacts`: how far the found is from the true;
- `cases`, `methods`: what is run; `sections`, `pose_sections`: the tables.
"""
