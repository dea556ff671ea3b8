"""How soon light is right: ``python -m benchmarks.light``.

One module a section (`section`): `radiance`, `channels`, `environment`, `growth`, `hard_rooms`.
`hard` builds the rooms that are hard to light, `rooms` all rooms, opened for our integrators.
"""
