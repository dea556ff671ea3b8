"""The physics step: bodies, masses, joints and collision shapes, for rooms that ask for them.

- `parts`: the parts of an object and their materials, and an object before computation;
- `cache`: collision shapes that were searched before; `ahead`: and those that will be needed, by
  several processes; `colliders`: shapes and masses of an asset;
- `objects`: all objects of a room, each of those that are alike once, and what is written of them;
- `layers`: rugs and other things that lie under others without lifting them;
- `step`: all of it, walls, floor and fixtures too.

Processes that search shapes start with this package: it imports nothing, USD least of all.
"""
