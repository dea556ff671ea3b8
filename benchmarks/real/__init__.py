"""What real captures become, against truth that was traced by hand: ``python -m benchmarks.real``.

The data is not here: it lies beside the project, in folders of ``captures.json`` (what is run),
``data/`` and ``truth/`` (frames, outlines, openings, objects).

- `captures`, `truth`: what is run and where it comes from, and what is true of it;
- `running`: the commands that a newcomer would type, also for the same scan without its labels,
  lying on its side, in millimetres;
- `plans`, `things`, `bodies`: how far the found is from the true, of outlines and openings, of
  objects, and of their meshes and RoomPlan's exports;
- `rows`: one run.
"""
