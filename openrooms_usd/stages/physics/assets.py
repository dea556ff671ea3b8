"""What an object is for physics before anything is computed; equal objects share one."""

import hashlib
import json
from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import Sdf

from openrooms_usd.arrays import Array
from openrooms_usd.description.physics import Shapes
from openrooms_usd.stages.physics.parts import RigidLink


@dataclass(frozen=True)
class ColliderSettings:
    """How collision shapes are made.

    Attributes:
        shapes: By which method.
        tolerance: How far they may lie from what is seen, metres.
    """

    shapes: Shapes
    tolerance: float


@dataclass(frozen=True, eq=False)
class RigidAsset:
    """An object as physics has it; equal ones share all of it.

    Attributes:
        root: The root of one of those that are alike.
        title: What its layer is called after.
        category: What it is.
        fixed: Whether it never moves.
        mass: Its mass where somebody says it, kilograms.
        friction: Likewise the static coefficient of all of it.
        scale: (3,) of its root, as `usd.bodies.frame_and_scale` gives it.
        looks: The names of its looks; one without a name where it has no choice.
        links: What it consists of.
        settings: How its collision shapes are made.
    """

    root: Sdf.Path
    title: str
    category: str
    fixed: bool
    mass: float | None
    friction: float | None
    scale: Array
    looks: tuple[str, ...]
    links: tuple[RigidLink, ...]
    settings: ColliderSettings

    def digest(self, code: str) -> str:
        """8 hexadecimal digits of all that its layer depends on.

        Args:
            code: The digest of the code that writes the layer.
        """
        parts: list[Any] = [
            code,
            self.category,
            self.fixed,
            self.mass,
            self.friction,
            self.scale.tolist(),
            self.looks,
            vars(self.settings),
        ]
        content = hashlib.sha256()
        for link in self.links:
            parts.append([link.path, link.built.tolist(), repr(link.joint)])
            for solid in link.solids:
                parts.append([solid.path, solid.name, [repr(s) for s in solid.substances]])
                content.update(np.ascontiguousarray(solid.mesh.points).tobytes())
                content.update(np.ascontiguousarray(solid.mesh.triangles).tobytes())
        content.update(json.dumps(parts, sort_keys=True).encode())
        return content.hexdigest()[:8]
