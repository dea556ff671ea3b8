"""How soon light is right: ``python -m benchmarks.light``; `hard`: the rooms, `rooms`: opened."""
