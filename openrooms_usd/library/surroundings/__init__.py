"""Sun, sky, environments, and the world outside.

Modules: `sunlight`, `sky`, `skycache`, `environments`, `outside`.
"""
