"""How soon light is right: ``python -m benchmarks.light``.

One module a section (`section`): `pictures`, `grids`, `fits`, `channels`, `complete`,
`hard_rooms`, and `honesty` of estimated errors.

`hard` builds the rooms that are hard to light, `rooms` all rooms, opened for our integrators,
`sessions` opens them as anybody would; `references` keeps what is true of them, `bias` says how far
a picture is from that; `casting` is the cost of the rays alone, `processes` runs commands,
`targets` is what shall be reached.
"""
