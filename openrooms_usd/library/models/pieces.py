"""Pieces of foreign models: what a reader gives, and how it is mended."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from openrooms_usd.arrays import Array, Floats, Mask
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import face_vectors, with_normals
from openrooms_usd.geometry.triangulation import triangulate
from openrooms_usd.geometry.vectors import UP, unit

if TYPE_CHECKING:
    from openrooms_usd.usd.shading.materials import PreviewSurface

# Vertex colours that differ by no more are one; how rough a surface is of which they are all that
# is known.
_SAME_COLOR: Final = 0.02
_PAINTED_ROUGHNESS: Final = 0.8


@dataclass(frozen=True, eq=False)
class ModelPart:
    """One named part of a foreign model, in the file's own frame and unit.

    Attributes:
        title: Its name in the file.
        mesh: Its polygons.
        surface: The material that the file gives it.
        link: The moving part that it belongs to; empty for what does not move.
        material: What the file calls its material; empty where it does not.
    """

    title: str
    mesh: Mesh
    surface: "PreviewSurface | None" = None
    link: str = ""
    material: str = ""


@dataclass(frozen=True, eq=False)
class ForeignJoint:
    """How a part of a foreign model moves, in the file's own frame.

    Attributes:
        link: The part.
        kind: ``hinge`` turns about the axis, ``rail`` slides along it.
        origin: (3,) a point of the axis.
        axis: (3,) unit vector; hinges turn counter-clockwise about it.
        limits: The range from how it is built: degrees, or the file's unit.
    """

    link: str
    kind: Literal["hinge", "rail"]
    origin: Array
    axis: Array
    limits: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Reading:
    """What a reader found in a file.

    Attributes:
        pieces: The parts, in the file's own frame and unit.
        notes: What was left out, one sentence each.
        up: The up axis that the file states, or that its format has.
        unit: Metres for one unit, likewise.
        licence: The terms that the file states; empty where it states none.
        front: Where its front looks once the up axis is turned to Z, as its format has it.
        joints: How parts of it move.
    """

    pieces: Sequence[ModelPart]
    notes: Sequence[str] = ()
    up: Literal["Y", "Z"] = "Y"
    unit: float = 1.0
    licence: str = ""
    front: Literal["+X", "-X", "+Y", "-Y"] = "-Y"
    joints: Sequence[ForeignJoint] = ()


def colored(
    title: str, surface: "PreviewSurface | None", colors: Array, notes: list[str]
) -> "PreviewSurface | None":
    """A surface of the colour that a piece's vertices have; of their mean where they differ.

    Colours that are not numbers are ignored.

    Args:
        title: Of the piece, for notes.
        surface: The material that the file gives it; its constant base colour is a factor.
        colors: (N, 3) of the vertices, scene-linear.
        notes: Receives a sentence if the colours differ or are not numbers.
    """
    from openrooms_usd.usd.shading.materials import PreviewSurface

    sound = np.isfinite(colors).all(axis=1)
    if not sound.all():
        notes.append(f"colours of vertices of {title[:60]} are not numbers, and are not used")
        colors = colors[sound]
    if not len(colors):
        return surface
    mean = np.clip(colors.mean(axis=0), 0.0, 1.0)
    if np.ptp(colors, axis=0).max() > _SAME_COLOR:
        notes.append(f"the colours of the vertices of {title[:60]} differ: their mean is used")
    if surface is None:
        r, g, b = np.round(mean, 6).tolist()
        return PreviewSurface(base_color=(r, g, b), roughness=_PAINTED_ROUGHNESS)
    if isinstance(surface.base_color, tuple):
        r, g, b = np.round(mean * surface.base_color, 6).tolist()
        return replace(surface, base_color=(r, g, b))
    notes.append(f"the colours of the vertices of {title[:60]} are not used: it has a picture")
    return surface


def is_textured(surface: "PreviewSurface | None") -> bool:
    """Whether a surface looks up texture coordinates."""
    from openrooms_usd.usd.shading.materials import Texture

    return surface is not None and any(isinstance(v, Texture) for v in vars(surface).values())


def mended(mesh: Mesh) -> Mesh | None:
    """A mesh that is fit for use: triangles with an area, shared points, outward unit normals.

    Points at the same place become one. Faces whose normals all point the other way are flipped; if
    that holds for all faces of a solid, the normals are flipped instead. Normals that are missing,
    zero or on the wrong side of their face are computed.

    Returns:
        The mended mesh; None when no face has an area.
    """
    corners, _ = triangulate(mesh.points, mesh.counts, mesh.indices)
    if not len(corners):
        return None
    flat = corners.reshape(-1)
    used, index = np.unique(mesh.points[mesh.indices[flat]], axis=0, return_inverse=True)
    triangles = Mesh(
        points=used,
        counts=np.full(len(corners), 3, dtype=np.int32),
        indices=index.reshape(-1).astype(np.int32),
        normals=None if mesh.normals is None else mesh.normals[flat],
        st=None if mesh.st is None else mesh.st[flat],
    )
    return _with_sound_normals(_without_repeats(triangles))


def _without_repeats(mesh: Mesh) -> Mesh:
    """Drop triangles that lost a corner to welding, repeat another or have no area."""
    triangles = mesh.indices.reshape(-1, 3)
    distinct = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    distinct &= np.linalg.norm(face_vectors(mesh), axis=1) > 0.0
    _, first = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
    once = np.zeros(len(triangles), dtype=np.bool_)
    once[first] = True
    return _submesh(mesh, distinct & once)


def _submesh(mesh: Mesh, faces: Mask) -> Mesh:
    """The chosen triangles and the points that they use."""
    corners = np.repeat(faces, 3)
    used, indices = np.unique(mesh.indices[corners], return_inverse=True)
    return Mesh(
        points=mesh.points[used],
        counts=mesh.counts[faces],
        indices=indices.reshape(-1).astype(np.int32),
        normals=None if mesh.normals is None else mesh.normals[corners],
        st=None if mesh.st is None else mesh.st[corners],
    )


def _with_sound_normals(mesh: Mesh) -> Mesh | None:
    if not len(mesh.counts):
        return None
    if mesh.normals is None:
        return with_normals(mesh)
    facing = _facing(mesh, mesh.normals)
    turned = (facing.reshape(-1, 3) < 0.0).all(axis=1)
    if turned.all() and mesh.volume() > 0.0:
        # The faces bound a solid as they are: it is the normals that have the wrong sign.
        return _with_sound_normals(replace(mesh, normals=-mesh.normals))
    rows = np.arange(len(mesh.indices)).reshape(-1, 3)
    rows[turned] = rows[turned][:, ::-1]
    order = rows.reshape(-1)
    mesh = replace(
        mesh,
        indices=mesh.indices[order],
        normals=mesh.normals[order],
        st=None if mesh.st is None else mesh.st[order],
    )
    assert mesh.normals is not None
    computed = with_normals(mesh).normals
    assert computed is not None
    sound = _facing(mesh, mesh.normals) > 0.0
    length = np.linalg.norm(mesh.normals, axis=1)
    sound &= np.isfinite(length) & (length > 0.0)
    normals = np.where(sound[:, None], mesh.normals, computed)
    return replace(mesh, normals=unit(normals.astype(np.float64), UP).astype(np.float32))


def _facing(mesh: Mesh, normals: Floats) -> Array:
    """(K,) positive where a corner's normal is on the outer side of its face."""
    vectors = np.repeat(face_vectors(mesh), mesh.counts, axis=0)
    facing = np.einsum("ij,ij->i", vectors, np.nan_to_num(normals.astype(np.float64)))
    return np.asarray(facing, dtype=np.float64)


def prim_names(titles: Sequence[str]) -> list[str]:
    """A valid, unique prim name for every title, in order; numbers come after the name."""
    names: list[str] = []
    used: set[str] = set()
    for title in titles:
        plain = "".join(c if c.isascii() and c.isalnum() else "_" for c in title).strip("_")[:64]
        name = plain or "part"
        name = f"_{name}" if name[0].isdigit() else name
        number, unique = 0, name
        while unique in used:
            number += 1
            unique = f"{name}_{number}"
        used.add(unique)
        names.append(unique)
    return names
