"""Lamps in a made scene, and pictures of many seeds of what they do."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pxr import UsdGeom

from openrooms_usd.render import RenderRequest
from openrooms_usd.usd.lights import define_mesh_light
from orusd_mitsuba import MitsubaRenderer
from tests.opening import open_with

Array = NDArray[np.float64]
NITS = 40.0
SIZE = (24, 18)
SEEDS = 8


def view_of(stage: Any, *names: str, seeds: int = SEEDS, **how: Any) -> dict[str, Array]:
    """(seeds, height, width, C) by name; what is seen is the same for all."""
    session = open_with(MitsubaRenderer(), stage)
    how = {"camera": "/Camera", "width": SIZE[0], "height": SIZE[1], "samples": 16} | how
    views = [
        session.render(RenderRequest(channels=names, seed=seed, **how)) for seed in range(seeds)
    ]
    return {
        name: np.stack([view.images[name].pixels for view in views]).astype(np.float64)
        for name in views[0].images
    }


def down(half: float, z: float, x: float = 0.0, y: float = 0.0) -> Array:
    """A square that looks down."""
    return np.array([(x - half, y - half, z), (x - half, y + half, z),
                     (x + half, y + half, z), (x + half, y - half, z)])  # fmt: skip


def lamp(made: Any, corners: ArrayLike, path: str = "/Lamp", nits: float = NITS) -> UsdGeom.Mesh:
    mesh = made.quad(path, corners, material="/Grey")
    define_mesh_light(mesh.GetPrim(), nits=nits)
    return mesh


def z_of(a: Array, b: Array) -> Array:
    spread = a.var(axis=0, ddof=1) / len(a) + b.var(axis=0, ddof=1) / len(b)
    return np.asarray((a.mean(axis=0) - b.mean(axis=0)) / np.sqrt(np.maximum(spread, 1e-18)))


def blocks(pictures: Array) -> Array:
    """(seeds, 12) means of blocks of 6 by 6 pixels."""
    count = len(pictures)
    return pictures.mean(axis=-1).reshape(count, 3, 6, 4, 6).mean(axis=(2, 4)).reshape(count, -1)


def closed_room(build: Any, **material: Any) -> Any:
    """Two metres about the origin, seen from a corner."""
    made = build()
    grey = made.material("/Grey", **({"base_color": (0.5, 0.5, 0.5)} | material))
    made.box("/Room", 2.0, inside=True, material=grey)
    made.camera((-0.8, -0.9, 0.2), (0.3, 0.9, -0.3), fov=95)
    return made
