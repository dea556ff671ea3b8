"""What real captures become, against truth that was traced by hand: ``python -m benchmarks.real``.

The data is not here: it lies beside the project, in folders of ``captures.json`` (what is run),
``data/`` and ``truth/`` (frames, outlines, openings, objects); `sources` names where the public
captures come from.

- `captures`, `truth`: what is run, and what is true of it; `variants`: the same scan without its
  labels, lying on its side, in millimetres;
- `running`: the commands that a newcomer would type;
- `plans`, `things`, `bodies`, `exports`: how far the found is from the true, of outlines and
  openings, of objects, of their meshes, and of RoomPlan's exports;
- `rows`, `totals`: one run, and all of them.
"""
