"""What holds of every scene, whatever stage it was made of."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from pxr import Usd

from openrooms_usd.errors import OrusdError
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.digest import light_digest
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd.cameras import list_cameras, read_camera
from openrooms_usd.usd.files.diagnostics import quiet
from openrooms_usd.usd.moments import freeze_time


def scene_of(stage: Usd.Stage) -> Scene:
    """A stage as every renderer receives it."""
    with quiet():
        freeze_time(stage)
        return translate(stage)


def digest(scene: Scene) -> str:
    """Equal where everything of two scenes is equal, byte by byte."""
    return light_digest(scene, scene.pieces, scene.legend, scene.report)


def views(stage: Usd.Stage) -> dict[str, np.ndarray]:
    """The pictures that cameras take, by their paths; those that take none are left out."""
    found = {}
    for prim in list_cameras(stage):
        try:
            camera = read_camera(prim, 40, 30)
        except OrusdError:
            continue
        found[str(prim.GetPath())] = np.concatenate(
            [camera.K.ravel(), camera.world_from_camera.ravel()]
        )
    return found


def faults(scene: Scene) -> list[str]:
    """What is wrong with a scene in itself; nothing where all is well."""
    found = [
        f"{name} is not finite"
        for name, value in _numbers(scene, "scene", set())
        if not np.isfinite(value).all()
    ]
    rows = Counter((path, outcome) for path, outcome, _ in scene.report.rows)
    found += [f"{path} is {outcome} {n} times" for (path, outcome), n in rows.items() if n > 1]
    triangles = scene.triangles
    lengths = np.linalg.norm(triangles.normals, axis=2)
    if not np.allclose(lengths, 1.0, atol=1e-3):
        found.append(f"normals are not of unit length: {lengths.min()} to {lengths.max()}")
    if len(triangles) and triangles.pieces.max() >= len(scene.pieces):
        found.append("triangles belong to pieces that do not exist")
    return found


def _numbers(value: Any, name: str, seen: set[int]) -> Iterator[tuple[str, np.ndarray]]:
    """All numbers that a value holds, with where they stand."""
    if isinstance(value, np.ndarray | float | np.floating):
        if np.asarray(value).dtype.kind == "f":
            yield name, np.asarray(value)
    elif id(value) in seen:
        return
    elif is_dataclass(value):
        seen.add(id(value))
        for field in fields(value):
            yield from _numbers(getattr(value, field.name), f"{name}.{field.name}", seen)
    elif isinstance(value, tuple | list):
        for number, part in enumerate(value):
            yield from _numbers(part, f"{name}[{number}]", seen)
