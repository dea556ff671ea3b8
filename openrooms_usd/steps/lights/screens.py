"""Screens that are on: a light with a picture before the glass of each."""

import hashlib
from typing import Final

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.codedigest import code_digest
from openrooms_usd.description.lights import Screen
from openrooms_usd.imagefile import write_png
from openrooms_usd.library.styles.displays import picture
from openrooms_usd.steps.base import StepContext
from openrooms_usd.usd.places.frames import author_matrix
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shapes.meshes import PlacedMesh, read_meshes

# The part of a thing that shows pictures.
SCREEN: Final = "screen"
# Between the glass and the light before it, metres.
_BEFORE_M: Final = 0.0006
# Triangles face as the screen does within this cosine; a screen that is bent by more stays dark.
_FACING_COSINE: Final = 0.95
_MOST_BENT_M: Final = 0.006
# What is shown where the description does not say.
_SHOWS: Final = {"television": "film"}
_USUAL: Final = "desktop"


def author_screens(context: StepContext) -> None:
    """Write a light for each screen that the description switches on.

    Raises:
        DescriptionError: A screen is named that is not there.
        OutputError: A picture cannot be written.
    """
    wanted = {name: screen for name, screen in context.room.lights.screens.items() if screen.on}
    if not context.room.lights.screens:
        return
    found = _screens(context.stage)
    context.check_named("lights.screens", found, "so its screen is dark", "screen")
    UsdGeom.Scope.Define(context.stage, names.SCREENS)
    for name, screen in wanted.items():
        if name not in found:
            continue
        face = _face(found[name])
        if face is None:
            context.notes.append(f"{name}: its screen is curved, so it stays dark")
        else:
            _author(context, name, screen, found[name], *face)


def _screens(stage: Usd.Stage) -> dict[str, PlacedMesh]:
    """The parts of objects that are screens, by the object's name."""
    return {
        mesh.path[len(names.FURNITURE) + 1 :].split("/")[0]: mesh
        for mesh in read_meshes(stage, outside=False, bare=True).meshes
        if mesh.path.startswith(f"{names.FURNITURE}/")
        and read_label(mesh.prim, names.PART) == SCREEN
    }


def _face(mesh: PlacedMesh) -> tuple[Array, float, float] | None:
    """The frame of a screen's light in the world, (4, 4), and its width and height, metres.

    Light leaves along -Z of the frame; Y is up on the picture. None for a screen that is bent.
    """
    corners = mesh.world_points()[mesh.mesh.triangles]
    if mesh.mirrored:
        corners = corners[:, ::-1]
    crossed = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(crossed, axis=1)
    normals = crossed / np.maximum(areas, 1e-12)[:, None]
    # Things face along their own -Y.
    front = -mesh.world_from_local[:3, 1]
    front = front / np.linalg.norm(front)
    ahead = normals[np.argmax(areas * (normals @ front > 0.3))]
    facing = corners[normals @ ahead > _FACING_COSINE].reshape(-1, 3)
    away = facing @ ahead
    across = np.cross(ahead, (0.0, 0.0, 1.0))
    if np.ptp(away) > _MOST_BENT_M or not np.linalg.norm(across) > 1e-6:
        return None
    # Seen from the front of the screen, its +X is to the left.
    across = across / np.linalg.norm(across)
    upright = np.cross(across, ahead)
    spans = [(facing @ axis) for axis in (across, upright)]
    middles = [0.5 * (float(span.min()) + float(span.max())) for span in spans]
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 1], frame[:3, 2] = across, upright, -ahead
    frame[:3, 3] = (
        middles[0] * across + middles[1] * upright + (float(away.max()) + _BEFORE_M) * ahead
    )
    width, height = (float(np.ptp(span)) for span in spans)
    return (frame, width, height) if min(width, height) > 0.0 else None


def _author(
    context: StepContext,
    name: str,
    screen: Screen,
    mesh: PlacedMesh,
    frame: Array,
    width: float,
    height: float,
) -> None:
    category = read_label(mesh.prim, names.CATEGORY) or ""
    shows = screen.shows or _SHOWS.get(category, _USUAL)
    aspect = round(width / height, 3)
    key = f"{code_digest(__name__)} {context.room.seed} {name} {shows} {aspect}"
    file = f"screen_{hashlib.sha256(key.encode()).hexdigest()[:8]}.png"
    target = context.keep(file)
    if not target.is_file():
        target.parent.mkdir(parents=True, exist_ok=True)
        write_png(target, picture(shows, aspect, context.rng("lights", "screens", name)))
    light = UsdLux.RectLight.Define(context.stage, f"{names.SCREENS}/{name}")
    light.CreateWidthAttr(width)
    light.CreateHeightAttr(height)
    light.CreateTextureFileAttr(context.asset(file))
    light.CreateIntensityAttr(screen.nits)
    light.CreateNormalizeAttr(False)
    prim = light.GetPrim()
    author_matrix(prim, frame)
    prim.SetAssetInfoByKey(names.LICENCE_KEY, names.LICENCE)
    low = Gf.Vec3f(-0.5 * width, -0.5 * height, 0.0)
    light.CreateExtentAttr([low, -low])
    # Pixels of the light are pixels of the thing.
    prim.CreateRelationship(names.SURFACE_OF, custom=True).SetTargets([Sdf.Path(mesh.path)])
