"""Boxes of the objects in a finished render: of their pixels, projected, and oriented in space."""

from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from pxr import Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array, Mask
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.rotations import about_z
from openrooms_usd.progress import Progress, each, silent
from openrooms_usd.rendering.coco import masks
from openrooms_usd.rendering.reading import RenderedScene, RenderedView, read_render
from openrooms_usd.rendering.rle import tight_box
from openrooms_usd.usd.places.ancestry import above
from openrooms_usd.usd.places.frames import local_to_world, world_from_stage
from openrooms_usd.usd.shapes.meshes import PlacedMesh, read_meshes
from openrooms_usd.version import __version__

Plain = dict[str, Any]

# Nearer to the camera's plane nothing is projected, metres.
_NEAR_PLANE_M: Final = 1e-3

CONVENTIONS: Final = {
    "box2d": "left, top, right, bottom of the pixels that show it; pixels from the upper left "
    "corner, right and bottom exclusive",
    "box2d_projected": "the same of all its surfaces, as if nothing hid them, cut off at the edges",
    "center": "metres",
    "axes": "3x3, its columns are the unit vectors of the box: of the object's own x, y, z; of the "
    "smallest upright box for a surface without a frame of its own, such as a wall",
    "size": "full lengths along the axes, metres",
}


@dataclass(frozen=True, eq=False)
class OrientedBox:
    """A box in the world that holds an object.

    Attributes:
        center: (3,) metres.
        axes: (3, 3) its unit vectors as columns: the directions of the object's x, y and z.
        size: (3,) full lengths along them, metres.
    """

    center: Array
    axes: Array
    size: Array

    def seen(self, camera_from_world: Array) -> "OrientedBox":
        """The same box in another frame, by a (4, 4) rigid transform."""
        turn, offset = camera_from_world[:3, :3], camera_from_world[:3, 3]
        return OrientedBox(turn @ self.center + offset, turn @ self.axes, self.size)

    def as_dict(self) -> Plain:
        """The box as plain data, to a micrometre."""
        values = {"center": self.center, "axes": self.axes, "size": self.size}
        return {name: np.round(value, 6).tolist() for name, value in values.items()}


@dataclass(frozen=True, eq=False)
class _Thing:
    box: OrientedBox
    edges: Array  # (E, 2, 3) of its triangles, world


def boxes(folder: Path, stage: Usd.Stage, progress: Progress = silent) -> Plain:
    """The boxes of what a render shows.

    Args:
        folder: What `orusd render` wrote.
        stage: What was rendered.
        progress: Called with each view.

    Returns:
        Plain data: the conventions, and for every view its objects.

    Raises:
        InputError: It is not a render, lacks the channel ``instance``, or shows another stage.
    """
    render = read_render(folder, ("instance",))
    things = _things(render, stage)
    views = each(progress, "view", render.each(), len(render.views))
    return {
        "generator": f"{names.CREATOR} {__version__}",
        "stage": render.manifest.stage,
        "conventions": {**render.manifest.conventions, **CONVENTIONS},
        "views": {view.name: _view(render, view, things) for view in views},
    }


def _view(render: RenderedScene, view: RenderedView, things: dict[str, _Thing]) -> Plain:
    rows = [_row(render, view, things, *seen) for seen in masks(render, view)]
    shared = view.entry.model_dump(include={"resolution", "K", "world_from_camera"})
    return {**shared, "objects": rows}


def _row(
    render: RenderedScene, view: RenderedView, things: dict[str, _Thing], instance: int, mask: Mask
) -> Plain:
    path = render.legend("instance")[instance]
    camera_from_world: Array = np.linalg.inv(view.world_from_camera).astype(np.float64)
    seen = tight_box(mask)
    thing = things.get(path)
    whole = thing and _projected(thing.edges, view.K, camera_from_world, (view.width, view.height))
    if not thing or not whole or not _encloses(whole, seen):
        raise InputError(
            f"the view {view.name!r} shows {path}, which this stage does not have",
            place=render.folder,
            remedy=f"give the stage that was rendered ({render.manifest.stage}), or render again",
        )
    return {
        "instance": instance,
        "prim": path,
        "category": render.legend("category").get(instance),
        "area": int(mask.sum()),
        "box2d": list(seen),
        "box2d_projected": whole,
        "box3d_world": thing.box.as_dict(),
        "box3d_camera": thing.box.seen(camera_from_world).as_dict(),
    }


def _encloses(whole: list[float], seen: tuple[int, int, int, int]) -> bool:
    """Whether all pixels have their centres within a box; rays and edges round apart."""
    inner = np.add(seen, (0.5, 0.5, -0.5, -0.5))
    slack = np.array([1.0, 1.0, -1.0, -1.0]) * (np.array(whole) - inner)
    return bool((slack <= 0.1).all())


def _things(render: RenderedScene, stage: Usd.Stage) -> dict[str, _Thing]:
    """The boxes and edges of the render's instances, by their paths."""
    wanted = frozenset(render.legend("instance").values())
    meshes: dict[str, list[PlacedMesh]] = defaultdict(list)
    for mesh in read_meshes(stage):
        owner = mesh.path
        while owner not in wanted and owner:
            owner = above(owner)
        if owner:
            meshes[owner].append(mesh)
    return {path: _thing(stage, path, found) for path, found in meshes.items()}


def _thing(stage: Usd.Stage, path: str, meshes: list[PlacedMesh]) -> _Thing:
    points = np.concatenate([mesh.world_points() for mesh in meshes])
    axes = _axes(_frame(stage, path, meshes))
    # Walls are meshes in the room's frame, whichever way they run.
    if meshes[0].path == path and np.allclose(axes, np.eye(3)):
        axes = _tightest(points)
    local = points @ axes
    low, high = local.min(axis=0), local.max(axis=0)
    box = OrientedBox(axes @ (0.5 * (low + high)), axes, high - low)
    edges = [
        mesh.world_points()[mesh.mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)]
        for mesh in meshes
    ]
    return _Thing(box, np.concatenate(edges))


def _frame(stage: Usd.Stage, path: str, meshes: list[PlacedMesh]) -> Array:
    """(4, 4) to the world from an object's own frame; an instancer's point has its mesh's."""
    prim = stage.GetPrimAtPath(path) if "[" not in path else None
    if not prim:
        return meshes[0].world_from_local
    cache = UsdGeom.XformCache(Usd.TimeCode.EarliestTime())
    return world_from_stage(stage) @ local_to_world(prim, cache)


def _tightest(points: Array) -> Array:
    """The upright directions of the smallest box, x within 45 degrees of the world's."""
    import shapely

    outline = shapely.oriented_envelope(shapely.MultiPoint(points[:, :2]))
    x, y = np.diff(shapely.get_coordinates(outline)[:2], axis=0)[0].tolist()
    quarter = 0.5 * np.pi
    angle = np.arctan2(y, x)
    angle -= quarter * np.round(angle / quarter)
    return about_z(angle)


def _axes(matrix: Array) -> Array:
    """The right-handed orthonormal directions nearest to a frame's, its z kept, then its x."""
    z = matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
    x = matrix[:3, 0] - (matrix[:3, 0] @ z) * z
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _projected(
    edges: Array, K: Array, camera_from_world: Array, size: tuple[int, int]
) -> list[float]:
    """Left, top, right, bottom of edges in the picture, cut off at the camera and at its edges.

    Empty where all is behind the camera.
    """
    ends = edges @ camera_from_world[:3, :3].T + camera_from_world[:3, 3]
    deep = ends[..., 2] >= _NEAR_PLANE_M
    crossing = ends[deep[:, 0] != deep[:, 1]]
    share = (_NEAR_PLANE_M - crossing[:, 0, 2]) / (crossing[:, 1, 2] - crossing[:, 0, 2])
    cut = crossing[:, 0] + share[:, None] * (crossing[:, 1] - crossing[:, 0])
    points = np.concatenate([ends[deep], cut]) @ K.T
    if not len(points):
        return []
    places = np.clip(points[:, :2] / points[:, 2:], 0.0, np.array(size, dtype=np.float64))
    box: list[float] = np.round([*places.min(axis=0), *places.max(axis=0)], 3).tolist()
    return box
