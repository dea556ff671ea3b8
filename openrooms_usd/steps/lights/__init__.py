"""The lights: the world outside, lamps, screens, and what photographs say of them.

- `step`: all lights, and the glow of bulbs; `daylight`: the sky, and what stands before
  the windows; `screens`: pictures on screens.
"""
