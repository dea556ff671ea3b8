"""How soon light is right: ``python -m benchmarks.light``.

One module a section (`section`):

- what is shown of every method: `pictures`, `grids`, `fits`, `channels`, `complete`,
  `hard_rooms`, `honesty` of estimated errors;
- what it takes: `memory`, `repeatable`;
- beside others: `radiance`, `environment` and `growth` of full paths, `cycles` (with `in_blender`,
  which Blender's Python runs).

`hard` builds the rooms that are hard to light, `rooms` all rooms, opened for our integrators,
`sessions` opens them as anybody would; `references` keeps what is true of them, `bias` says how far
a picture is from that; `casting` is the cost of the rays alone, `processes` runs commands,
`targets` is what shall be reached.
"""
