"""How soon light is right: ``python -m benchmarks.light``.

The sections are in `pictures` (with the cost of the rays alone), `grids` (and what fits leave of
them), `view`, and `honesty` (all channels and their estimated errors, also in the rooms of
`hard`, which are hard to light).

`rooms` opens all rooms for our integrators, `sessions` as anybody would, with what is true of them
and what shall be reached; `bias` says how far a picture is from that.
"""

from orusd_mitsuba import variants

# Which LLVM is loaded has to be chosen before any section imports Mitsuba.
variants.choose()
