"""Collision shapes, pushes and speed: ``python -m benchmarks.physics``; `shapes`, `push`."""
