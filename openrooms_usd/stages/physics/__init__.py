"""The physics stage: bodies, masses, joints and collision shapes, for rooms that ask for them.

- `parts`: the parts of an object, their materials and masses; `shapes`: their collision shapes;
- `cache`: shapes that were searched before; `objects`: each object's layer, published once;
- `room`: walls, floor and fixtures; `authoring`: what is written; `stage`: all of it.
"""

from openrooms_usd.stages.physics.stage import PhysicsStage

__all__ = ["PhysicsStage"]
