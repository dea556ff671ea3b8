"""The cameras: where views are taken from, and how they are exposed.

- `step`: all cameras, and how bright their pictures become;
- `selection`: the best of many views, and the cameras of a capture;
- `plates`: photographs as back plates of their cameras.
"""
