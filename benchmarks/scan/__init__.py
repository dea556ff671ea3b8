"""What scans become, on simulated scans whose truth is known: ``python -m benchmarks.scan``.

- `rooms`: rooms; `scanner` with `path`, `depth`, `fusion`: their scans;
- `truth`: what is true, and what a user knows;
- `scores`, `contacts`: how far the found is from the true;
- `cases`: what is run; `sections`, `pose_sections`: the tables;
- `flat`: how long a flat of many things takes.
"""
