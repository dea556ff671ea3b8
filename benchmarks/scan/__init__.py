"""What scans become, on simulated scans whose truth is known: ``python -m benchmarks.scan``.

- `rooms`, `built`, `corridors`, `hard_rooms`: rooms; `scanner` with `path`, `depth`, `fusion`,
  `labels`: how they are scanned; `hard_scans`: clouds that were spoilt;
- `truth`, `symmetry`, `hints`: what is true, and what a user knows;
- `methods`, `baselines`, `pose_baselines`: ours, and what to compare with;
- `scores`, `pose_scores`, `contacts`: how far the found is from the true;
- `cases`, `contact_cases`, `hard`, `growth`: what is run; `sections`, `pose_sections`: the tables.
"""
