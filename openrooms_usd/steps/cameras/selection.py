"""Views that are selected: the composed room as rays see it, and the best of many candidates."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.capture import Capture, CapturedFrame
from openrooms_usd.description.cameras import FrameCameras, SelectedCameras
from openrooms_usd.description.layout import ScanLayout
from openrooms_usd.errors import InputError
from openrooms_usd.furniture.registry import record
from openrooms_usd.geometry.composition import (
    BARE,
    NO_SUBJECT,
    Subjects,
    focus_distance,
    photographic_rating,
)
from openrooms_usd.geometry.framing import framing_view
from openrooms_usd.geometry.looks import Rating, Views
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.geometry.triangulation import TriangleMesh, bounding_box
from openrooms_usd.geometry.viewpoints import photographers_views
from openrooms_usd.geometry.views import sample_views, select_views
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.captures import capture_of, captured_section
from openrooms_usd.usd.places.frames import TIME, local_to_world
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shapes.meshes import PlacedMesh, read_meshes, world_triangles

# Above this many triangles furniture is cast as its boxes: views need no more to be chosen.
MANY_TRIANGLES: Final = 2_000_000
# Candidates for each view that is kept, and the least of them.
_CANDIDATES_PER_VIEW: Final = 48
_LEAST_CANDIDATES: Final[Mapping[str, int]] = {"photograph": 640, "paper": 192}
# Heights above the floor where the description names none, metres.
_HEIGHTS_M: Final[Mapping[str, tuple[float, float]]] = {
    "photograph": (1.2, 1.6),
    "paper": (1.4, 1.8),
}
# Where a look at an opening ends, before the inner edge of its wall, metres.
_BEFORE_OPENING_M: Final = 0.05
# Room between an eye and the ceiling, metres.
_BELOW_CEILING: Final = 0.25
Ints = NDArray[np.int32]

# Of a thing whose record says nothing, for each metre of its longest side, and at most.
_WORTH_PER_M: Final = 0.4
_MOST_WORTH_BY_SIZE: Final = 0.8
# Things shorter than this, metres, are never the subject of a view.
_SMALL_M: Final = 0.4
# Classes of NYU40 in the shell on which there is nothing to look at, tiles and panels among them.
_BARE: Final = ("wall", "ceiling", "door")
# How many subjects a room has at most, and points on each.
_MAX_SUBJECTS: Final = 16
_POINTS: Final = 20


@dataclass(frozen=True, eq=False)
class ViewCandidates:
    """The composed room, ready to be looked at.

    Attributes:
        points: (M, 3, 3) corners of everything that is drawn, metres.
        caster: The same for rays.
        polygon: (P, 2) floor.
        floor: Height of the floor.
        headroom: From the floor to a little below the ceiling, metres.
        openings: (K, 3) the middles of windows, doors and passages, on the room's side.
        subjects: What the room is photographed for.
    """

    points: Array
    caster: RayCaster
    polygon: Array
    floor: float
    headroom: float
    openings: Array
    subjects: Subjects

    @classmethod
    def of(cls, stage: Usd.Stage) -> "ViewCandidates":
        """Read a composed room."""
        meshes = read_meshes(stage, outside=False, bare=True).meshes
        light = _lightened(meshes)
        points, triangles, owners = world_triangles(light)
        shell = _points(meshes, names.ROOM)
        everything = next(found for found in (shell, points, np.zeros((1, 3))) if len(found))
        low, high = everything.min(axis=0), everything.max(axis=0)
        ground = float(_points(meshes, names.FLOOR)[:, 2].max(initial=low[2]))
        top = float(_points(meshes, names.CEILING)[:, 2].min(initial=high[2]))
        polygon = _floor_polygon(stage)
        if polygon is None:
            polygon = np.array([low[:2], [high[0], low[1]], high[:2], [low[0], high[1]]])
        caster = RayCaster(points, triangles)
        headroom = top - ground - _BELOW_CEILING
        subjects = room_subjects(light, points[triangles], owners)
        return cls(points[triangles], caster, polygon, ground, headroom, _openings(stage), subjects)

    def choose(self, context: StepContext, number: int, view: SelectedCameras) -> Array:
        """(C, 4, 4) poses of the best views."""
        width, height = context.room.cameras.resolution or (1, 1)
        chosen = select_views(
            self.caster,
            self._candidates(context.rng("cameras", "select", str(number)), view),
            view.count,
            fov_degrees=view.fov,
            aspect=width / height,
            places=self.openings,
            rating=None if view.prefer == "paper" else self._rating(),
            spare=view.spare,
        )
        if not len(chosen):
            context.notes.append("no free view along the walls: the camera frames the whole room")
            return framing_view(self.points, self.caster, width / height).poses()
        if len(chosen) < view.count:
            context.notes.append(
                f"only {len(chosen)} of {view.count} views found room along the walls"
            )
        return chosen.poses()

    def focus(self, pose: Array, fov_degrees: float) -> float:
        """Metres along the optical axis of a camera's (4, 4) pose to the subject of its picture."""
        return focus_distance(self.caster, pose[:3, 3], pose[:3, 2], fov_degrees, self.subjects)

    def _candidates(self, rng: np.random.Generator, view: SelectedCameras) -> Views:
        low, high = view.height or _HEIGHTS_M[view.prefer]
        highest = min(high, max(self.headroom, 0.1))
        count = max(_LEAST_CANDIDATES[view.prefer], _CANDIDATES_PER_VIEW * view.count)
        heights = min(low, highest), highest
        where = self.polygon, self.floor, count, rng
        if view.prefer == "paper":
            return sample_views(*where, height=heights, distance=view.distance)
        return photographers_views(
            *where,
            height=heights,
            distance=view.distance,
            doorways=self.openings,
            subjects=self.subjects.points.mean(axis=1),
        )

    def _rating(self) -> Rating:
        diagonal = float(np.hypot(*np.ptp(self.polygon, axis=0)))
        return photographic_rating(self.caster, self.subjects, floor=self.floor, diagonal=diagonal)


def _points(meshes: list[PlacedMesh], root: str) -> Array:
    """(N, 3) points in the world of all meshes at or below a path."""
    below = [m.world_points() for m in meshes if m.path == root or m.path.startswith(f"{root}/")]
    return np.concatenate([np.zeros((0, 3)), *below])


def _openings(stage: Usd.Stage) -> Array:
    """(K, 3) a little before the middle of every opening, in the world."""
    openings, cache = stage.GetPrimAtPath(names.OPENINGS), UsdGeom.XformCache(TIME)
    rows = [
        prim for prim in (openings.GetChildren() if openings else ()) if UsdGeom.Xformable(prim)
    ]
    before = np.array([0.0, -_BEFORE_OPENING_M, 0.0, 1.0])
    return np.array([(local_to_world(prim, cache) @ before)[:3] for prim in rows]).reshape(-1, 3)


def _floor_polygon(stage: Usd.Stage) -> Array | None:
    """(P, 2) as the layout step left it; None where there is no usable one."""
    room = stage.GetPrimAtPath(names.ROOM)
    attribute = room.GetAttribute(names.ROOM_FLOOR) if room else None
    corners = np.array(attribute.Get() if attribute and attribute.HasValue() else [])
    usable = corners.ndim == 2 and len(corners) >= 3 and np.isfinite(corners).all()
    return corners.astype(np.float64) if usable else None


def _lightened(meshes: list[PlacedMesh]) -> list[PlacedMesh]:
    """The meshes, or boxes for those of the furniture when there are too many triangles."""
    if sum(len(mesh.mesh.triangles) for mesh in meshes) <= MANY_TRIANGLES:
        return meshes
    boxes: dict[int, TriangleMesh] = {}
    for mesh in meshes:
        boxes.setdefault(id(mesh.mesh), bounding_box(mesh.mesh))
    return [
        PlacedMesh(mesh.path, mesh.prim, boxes[id(mesh.mesh)], mesh.world_from_local)
        if mesh.path.startswith(f"{names.FURNITURE}/")
        else mesh
        for mesh in meshes
    ]


def room_subjects(meshes: list[PlacedMesh], corners: Array, owners: Ints) -> Subjects:
    """The main things of a room.

    Args:
        meshes: All that is drawn.
        corners: (M, 3, 3) corners of their triangles in the world, metres.
        owners: (M,) the mesh of each triangle.
    """
    roots = [_root(mesh.path) for mesh in meshes]
    labels = {
        root: read_label(mesh.prim, names.CATEGORY) or ""
        for root, mesh in zip(roots, meshes, strict=True)
        if root
    }
    number = {root: row for row, root in enumerate(labels)}
    thing_of_mesh = np.array([number.get(root, NO_SUBJECT) for root in roots], dtype=np.int32)
    bare = np.array(
        [
            not root and read_label(mesh.prim, names.NYU40) in _BARE
            for root, mesh in zip(roots, meshes, strict=True)
        ],
        dtype=np.bool_,
    )
    thing = thing_of_mesh[owners] if len(roots) else np.zeros(0, dtype=np.int32)
    rows = [np.flatnonzero(thing == row) for row in range(len(labels))]
    worth = np.array(
        [_worth(label, corners[at]) for label, at in zip(labels.values(), rows, strict=True)]
    )
    main = np.argsort(-worth, kind="stable")[:_MAX_SUBJECTS]
    main = main[worth[main] > 0.0] if len(main) else main
    renamed = np.full(len(labels) + 1, NO_SUBJECT, dtype=np.int32)
    renamed[main] = np.arange(len(main))
    points = [_surface_points(corners[rows[row]]) for row in main]
    of_triangle = np.where(bare[owners], BARE, renamed[thing]) if len(bare) else renamed[thing]
    return Subjects(np.array(points).reshape(-1, _POINTS, 3), worth[main], of_triangle)


def _root(path: str) -> str:
    """The object that a mesh belongs to; nothing for those of the shell."""
    inside = path.startswith(f"{names.FURNITURE}/")
    return path[len(names.FURNITURE) + 1 :].split("/")[0] if inside else ""


def _worth(category: str, corners: Array) -> float:
    known = record(category)
    if known and known.view_importance is not None:
        return known.view_importance
    longest = float(np.ptp(corners.reshape(-1, 3), axis=0).max()) if len(corners) else 0.0
    return min(_WORTH_PER_M * longest, _MOST_WORTH_BY_SIZE) if longest > _SMALL_M else 0.0


def _surface_points(corners: Array) -> Array:
    """(P, 3) middles of triangles, spread evenly by area over the order of the mesh."""
    a, b, c = np.moveaxis(corners, 1, 0)
    areas = np.cumsum(np.linalg.norm(np.cross(b - a, c - a), axis=1))
    at = (np.arange(_POINTS) + 0.5) / _POINTS * areas[-1]
    return np.asarray(corners.mean(axis=1)[np.minimum(np.searchsorted(areas, at), len(areas) - 1)])


# The photographs of a capture as cameras, so that each view stands for one of them.


def photographs(context: StepContext) -> Capture | None:
    """The room's capture where the description asks for its cameras; None where it does not.

    Raises:
        InputError: The capture cannot be read, or knows no cameras.
    """
    if not any(isinstance(view, FrameCameras) for view in context.room.cameras.views):
        return None
    section = captured_section(context.room)
    if section is None:
        raise InputError(
            "the room does not come from a capture, so it has no captured cameras",
            place="cameras",
            remedy="describe the cameras, or select them: `from: select`",
        )
    capture = capture_of(context, section)
    if not capture.frames:
        raise InputError(
            "this capture has no cameras of photographs",
            place=context.source / section.file,
            remedy="import it with --frames where its importer has that, or describe the cameras",
        )
    if isinstance(section, ScanLayout):
        capture = replace(capture, frames=_standing(context, capture))
    return capture


def _standing(context: StepContext, capture: Capture) -> tuple[CapturedFrame, ...]:
    """The photographs of a scan, as the room stands that was found in it."""
    room = context.stage.GetPrimAtPath(names.ROOM)
    source_from_room = np.array(room.GetAttribute(names.SOURCE_FROM_WORLD).Get()).T
    room_from_scan = np.linalg.inv(source_from_room) @ capture.source_from_world
    return tuple(
        replace(frame, world_from_camera=room_from_scan @ frame.world_from_camera)
        for frame in capture.frames
    )


def frame_name(prefix: str, frame: CapturedFrame, taken: set[str]) -> str:
    """A free prim name that tells the frame's identifier: ``frame_33``."""
    name = f"{prefix}_" + re.sub(r"\W", "_", frame.id, flags=re.ASCII)
    while name in taken:
        name += "_"
    return name


def intrinsics_for(frame: CapturedFrame, resolution: tuple[int, int]) -> Array:
    """(3, 3) intrinsics of a frame for pictures of another size.

    The picture's width stays what it sees; where the shape is another, rows are added or left out
    above and below alike. Pixels are square: the horizontal focal length counts.
    """
    (width, height), (own_width, own_height) = resolution, frame.resolution
    scale = width / own_width
    K = frame.K
    cy = 0.5 * height + scale * (K[1, 2] - 0.5 * own_height)
    focal = scale * K[0, 0]
    return np.array([[focal, 0.0, scale * K[0, 2]], [0.0, focal, cy], [0.0, 0.0, 1.0]])


def name_photograph(prim: Usd.Prim, frame: CapturedFrame, capture: Capture) -> None:
    """Write on a camera which photograph it stands for."""
    prim.AddAppliedSchema(names.SOURCE_API)
    source = {names.SOURCE_FILE: frame.picture or capture.source, names.SOURCE_ID: frame.id}
    for name, value in source.items():
        prim.CreateAttribute(name, Sdf.ValueTypeNames.String, custom=False).Set(value)
