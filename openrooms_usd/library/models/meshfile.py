"""The user's own models: OBJ, GLB, PLY, STL, URDF and USD files as parts in our object frame."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final, Literal

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.furniture.joinery.pieces import Joint, Size
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.topology import is_closed
from openrooms_usd.geometry.uv import cube_projection, metric
from openrooms_usd.geometry.uvquality import uv_quality
from openrooms_usd.library.assets import Model
from openrooms_usd.library.models.gltf import read_glb, read_ply, read_stl
from openrooms_usd.library.models.pieces import (
    ForeignJoint,
    ModelPart,
    Reading,
    is_textured,
    mended,
    prim_names,
)
from openrooms_usd.library.models.posture import Posture, Up, Usual, posture
from openrooms_usd.library.models.urdf import meshes_of, read_urdf
from openrooms_usd.library.models.usdfile import USD_SUFFIXES, layers_of, read_usd
from openrooms_usd.library.models.wavefront import libraries_of, read_obj
from openrooms_usd.library.timber import follow_grain

Front = Literal["+X", "-X", "+Y", "-Y"]

# Without a size, a longest side that is not between these (metres) means a wrong unit.
MIN_LENGTH_M: Final = 0.005
MAX_LENGTH_M: Final = 100.0

_Z_UP_FROM_Y_UP: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
# Cosine and sine of the turn about Z that brings the front to -Y.
_TURNS: Final[dict[Front, tuple[int, int]]] = {
    "-Y": (1, 0),
    "+X": (0, -1),
    "+Y": (-1, 0),
    "-X": (0, 1),
}


def read_model(
    path: Path,
    *,
    size: Size | None = None,
    up: Up | None = None,
    front: Front | None = None,
    unit: float | None = None,
    usual: Usual | None = None,
) -> Model:
    """Read a mesh file as an asset's parts.

    Args:
        path: An OBJ, GLB, PLY, STL, URDF or USD file.
        size: Width, depth and height to stretch it to, metres; by default its own size.
        up: The file's up axis; by default Y for OBJ and GLB, Z for PLY and STL, as stated in USD.
        front: Where its front looks after the up axis is turned to Z; by default -Y, in
            URDF where doors and drawers open to.
        unit: Metres for one unit of the file; by default 1, in USD as stated.
        usual: The sizes of its category: where neither the file nor the caller says them, its up
            axis and unit are those by which it differs least from them.

    Returns:
        Its parts in the object frame. Normals are computed where they are missing; texture
        coordinates are in metres except on parts with textures of their own. They are the file's
        own where `geometry.uvquality` finds no fault with them.

    Raises:
        InputError: The file is missing, broken, empty, of no known kind or absurdly large.
        MissingPackageError: It is compressed and the decoder is not installed.
    """
    suffix = path.suffix.lower()
    reader = _READERS.get(suffix)
    if reader is None:
        raise InputError(
            f"a mesh file of the kind {suffix or 'without a suffix'!r} cannot be read",
            place=path,
            remedy=f"convert it to one of: {', '.join(_READERS)}",
        )
    untrusted.checked(path, "model" if suffix not in USD_SUFFIXES else "usd")
    reading = reader(path)
    pieces = _sound(reading, path)
    stands = _posture(pieces, reading, path, usual, up, unit, size)
    turn = _turn(stands.up, front or reading.front) * stands.unit
    model = _as_model(pieces, turn, reading)
    model = replace(model, licence=reading.licence, notes=(*model.notes, *stands.notes))
    return _fitted(model, size, turn, path)


def dependencies(path: Path) -> list[Path]:
    """The files that a mesh file refers to: materials, pictures, other USD layers.

    Args:
        path: The mesh file; one that is missing or broken refers to nothing.

    Returns:
        Absolute paths of those that exist, sorted, without the file itself.
    """
    finder = _FINDERS.get(path.suffix.lower())
    try:
        if finder is None or not path.is_file():
            return []
        return sorted(set(finder(path)) - {path.resolve()})
    except (OSError, ValueError, RuntimeError, InputError):
        return []


def _posture(
    pieces: Sequence[ModelPart],
    reading: Reading,
    path: Path,
    usual: Usual | None,
    up: Up | None,
    unit: float | None,
    size: Size | None,
) -> Posture:
    """How the model stands, by what is said, its format and its category."""
    points = np.concatenate([piece.mesh.points for piece in pieces])
    suffix = path.suffix.lower()
    fixed = suffix in (*USD_SUFFIXES, _URDF)
    return posture(
        points.min(axis=0).tolist(),
        points.max(axis=0).tolist(),
        Posture(reading.up, reading.unit),
        usual,
        up=up or (reading.up if fixed else None),
        unit=unit or (reading.unit if fixed else None),
        size=size,
        stated=suffix == ".glb",
    )


def _turn(up: Up, front: Front) -> Array:
    """(3, 3) from a file's axes to ours."""
    upright = _Z_UP_FROM_Y_UP if up == "Y" else np.eye(3)
    c, s = _TURNS[front]
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(turn @ upright, dtype=np.float64)


def _sound(reading: Reading, path: Path) -> list[ModelPart]:
    """The pieces that have an area, mended."""
    if any(not np.isfinite(piece.mesh.points).all() for piece in reading.pieces):
        raise InputError(
            "the mesh has coordinates that are not finite", place=path, remedy="export it again"
        )
    sound = [
        replace(piece, mesh=mesh)
        for piece in reading.pieces
        if (mesh := mended(piece.mesh)) is not None
    ]
    if not sound:
        raise InputError(
            "the file holds no faces with an area",
            place=path,
            remedy="give a mesh, not points or curves",
        )
    return sound


def _as_model(pieces: Sequence[ModelPart], turn: Array, reading: Reading) -> Model:
    names = prim_names([piece.title for piece in pieces])
    found = list(zip(names, pieces, strict=True))
    turned = np.eye(4)
    turned[:3, :3] = turn
    return Model(
        parts={name: piece.mesh.transformed(turn) for name, piece in found},
        titles={name: piece.title for name, piece in found if piece.title not in ("", name)},
        surfaces={name: piece.surface for name, piece in found if piece.surface is not None},
        notes=tuple(reading.notes),
        joints=tuple(_under(joint, turned) for joint in _joints(reading.joints, found)),
    )


def _joints(
    joints: Sequence[ForeignJoint], found: Sequence[tuple[str, ModelPart]]
) -> Iterator[Joint]:
    """The joints of parts that are there, each named by the first of these."""
    for joint in joints:
        meshes = tuple(name for name, piece in found if piece.link == joint.link)
        if meshes:
            x, y, z = joint.origin.tolist()
            u, v, w = joint.axis.tolist()
            yield Joint(meshes[0], joint.kind, meshes, (x, y, z), (u, v, w), joint.limits)


def _under(joint: Joint, M: Array) -> Joint:
    """A joint under a (4, 4) matrix for column vectors: what slides, slides by as much more."""
    x, y, z = (M[:3, :3] @ joint.origin + M[:3, 3]).tolist()
    along = M[:3, :3] @ joint.axis
    length = float(np.linalg.norm(along))
    u, v, w = (np.round(along / length, 12) + 0.0).tolist()
    low, high = (limit * (length if joint.kind == "rail" else 1.0) for limit in joint.limits)
    return replace(joint, origin=(x, y, z), axis=(u, v, w), limits=(low, high))


def _fitted(model: Model, size: Size | None, turn: Array, path: Path) -> Model:
    """The turned model on the origin, stretched to a size if one is asked for."""
    low, high = model.extent
    own = high - low
    longest = float(own.max())
    if size is None and not MIN_LENGTH_M <= longest <= MAX_LENGTH_M:
        raise InputError(
            f"its longest side is {longest:.4g} m",
            place=path,
            remedy="give the unit of the file (unit: 1 mm), or the size of the object",
        )
    # A sheet has no thickness that could be stretched.
    scale = np.where(own > 1e-9 * longest, np.asarray(size or own) / np.maximum(own, 1e-300), 1.0)
    fit = np.eye(4)
    fit[:3, :3] = np.diag(scale)
    fit[:3, 3] = -scale * [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2]]
    turned = np.eye(4)
    turned[:3, :3] = turn
    fitted = {name: mesh.transformed(fit) for name, mesh in model.parts.items()}
    mapped = {name: _mapped(model, name, mesh) for name, mesh in fitted.items()}
    return replace(
        model,
        parts={name: mesh for name, (mesh, _) in mapped.items()},
        notes=(*model.notes, *(note for _, note in mapped.values() if note)),
        joints=tuple(_under(joint, fit) for joint in model.joints),
        # Sheets without thickness are seen from behind too.
        double_sided=not all(is_closed(mesh) for mesh in fitted.values()),
        file_from_object=np.asarray(np.linalg.inv(fit @ turned), dtype=np.float64),
    )


def _mapped(model: Model, name: str, mesh: Mesh) -> tuple[Mesh, str]:
    """The part with texture coordinates for what it wears, and what is wrong with its own.

    A part's own pictures are laid out for its own coordinates, which so stay as they are; our
    materials have a physical size, so where they go the coordinates are in metres.
    """
    title = model.titles.get(name, name)
    if mesh.st is None or not is_textured(model.surfaces.get(name)):
        mapped, fault = metric(mesh)
        if mesh.st is None:
            mapped = follow_grain(name, mapped)
        return mapped, f"texture coordinates of {title}: {fault}; projected" if fault else ""
    quality = uv_quality(mesh)
    if not quality.finite:
        return cube_projection(mesh), f"texture coordinates of {title}: {quality.fault}; projected"
    return mesh, f"texture coordinates of {title}: {quality.fault}" if quality.fault else ""


def _read_part(path: Path) -> Reading:
    """A mesh that a URDF file names."""
    reader = _READERS.get(path.suffix.lower())
    if reader is None or path.suffix.lower() == _URDF:
        known = ", ".join(suffix for suffix in _READERS if suffix != _URDF)
        raise InputError(
            "a mesh of this kind cannot be read", place=path, remedy=f"convert it to one of {known}"
        )
    untrusted.checked(path, "model" if path.suffix.lower() not in USD_SUFFIXES else "usd")
    return reader(path)


def _files_of_urdf(path: Path) -> Iterator[Path]:
    for mesh in meshes_of(path):
        yield mesh
        yield from dependencies(mesh)


_URDF: Final = ".urdf"
_READERS: Final[dict[str, Callable[[Path], Reading]]] = {
    ".obj": read_obj,
    ".glb": read_glb,
    ".ply": read_ply,
    ".stl": read_stl,
    _URDF: lambda path: read_urdf(path, _read_part),
    **dict.fromkeys(USD_SUFFIXES, read_usd),
}

_FINDERS: Final[dict[str, Callable[[Path], Iterable[Path]]]] = {
    ".obj": libraries_of,
    _URDF: _files_of_urdf,
    ".usd": layers_of,
    ".usda": layers_of,
    ".usdc": layers_of,
}
