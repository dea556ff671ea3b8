"""The page of a stage: its surfaces as a GLB file, and what is known of its prims."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from pxr import Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.description.model import Model
from openrooms_usd.errors import InputError
from openrooms_usd.exporters import write_stage
from openrooms_usd.rendering.reading import RenderedScene, read_render
from openrooms_usd.scratch import scratch_folder
from openrooms_usd.usd.files.diagnostics import quiet, reading
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.places.frames import TIME, local_to_world, world_from_stage
from openrooms_usd.view.app import App, Command, Nothing

if TYPE_CHECKING:
    from pxr import Usd


# Corners of an opening in its own frame, in halves of its width and height.
_RECTANGLE = np.array([[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]])
_OF_A_BAKE: Final = (
    "show the stage that was baked: orusd view STAGE --lightmaps FOLDER; or say --include-outside"
)


class LookRequest(Model):
    """A request to show a look."""

    path: str
    """The object's prim."""
    look: str
    """The variant."""


class PrimRequest(Model):
    """A request for a prim."""

    path: str
    """Its path."""


def room_app(
    path: Path,
    *,
    light: Sequence[Path] = (),
    include_outside: bool = False,
    render: Path | None = None,
    photographs: Path | None = None,
) -> App:
    """The page of a stage.

    Args:
        path: The USD file.
        light: What `orusd bake` wrote of it; several are of moments between which it blends.
        include_outside: Whether pictures outside its folder and those of ``light`` may be shown.
        render: A finished render of it, whose pictures are shown too.
        photographs: Where those of its capture lie, if not where the capture does.

    Raises:
        InputError: It is not a stage, ``render`` is not a render, or ``light`` belongs to another
            stage.
        StageError: It needs pictures outside of these folders.
    """
    from openrooms_usd.view.light import light_of
    from openrooms_usd.view.moments import Moment, moments_of
    from openrooms_usd.view.prims import opinions_of
    from openrooms_usd.view.shots import ViewPoint, hemisphere
    from openrooms_usd.view.tracing import PICTURE, Trace, Tracing

    stage = open_stage(path)
    moments = moments_of(path, light) or (Moment("", path, stage, is_own=True),)
    shown = next(one.file for one in moments if one.is_own)
    beside = (*light, path.resolve().parent) if light else ()
    check = partial(refuse_pictures, beside=beside, include_outside=include_outside)
    for moment in moments:
        check(moment.stage)
    # Lightmaps, renders and captures are read once: pages do not edit them.
    with reading(path):
        lit, maps = light_of(moments)
    finished = None if render is None else read_render(render)
    more, taken = besides(stage, path, finished, photographs)
    tracing = Tracing(path)
    looks: dict[str, str] = {}

    def opinions(asked: PrimRequest) -> dict[str, Any]:
        return {"opinions": opinions_of(open_stage(path), asked.path)}

    def look(asked: LookRequest) -> dict[str, Any]:
        check_look(path, asked)
        looks[asked.path] = asked.look
        return {}

    edits = path.parent / names.LAYERS / f"{names.EDITS}.usda"
    return App(
        page="room",
        title=f"{path.resolve().parent.name} / {path.name}",
        state=lambda: {**room_state(path), "light": lit, **more},
        resources={
            "room.glb": lambda: room_glb(shown, check, lit=bool(lit), looks=looks),
            **maps,
            **taken,
        },
        live={PICTURE: tracing.picture},
        commands={
            "look": Command(LookRequest, look),
            "opinions": Command(PrimRequest, opinions),
            **(
                {"hemisphere": Command(ViewPoint, partial(hemisphere, finished))}
                if finished
                else {}
            ),
            "trace": Command(Trace, tracing.start),
            "traced": Command(Nothing, tracing.told),
            "trace_stop": Command(Nothing, tracing.stop),
        },
        watched=(path, edits),
    )


def besides(
    stage: "Usd.Stage", path: Path, render: RenderedScene | None, photographs: Path | None = None
) -> tuple[dict[str, Any], dict[str, Callable[[], bytes]]]:
    """The state of a render, photographs and a scan for a page, and its resources."""
    from openrooms_usd.comparison.photographs import is_captured, read_captured
    from openrooms_usd.view.prims import cameras_of
    from openrooms_usd.view.scanned import POINTS, packed
    from openrooms_usd.view.shots import has_hemispheres, photographs_of, rendered_shots

    cameras = cameras_of(stage)
    told: dict[str, dict[str, str]] = {}
    resources: dict[str, Callable[[], bytes]] = {}
    capture = cache(lambda: read_captured(stage, path, None, photographs))
    captured = is_captured(path)
    if captured and any(camera["photograph"] for camera in cameras):
        told, resources = photographs_of(capture(), cameras)
    if render is not None:
        shots, pictures = rendered_shots(render, cameras)
        told = {name: told.get(name, {}) | shots.get(name, {}) for name in {**told, **shots}}
        resources |= pictures

    def points() -> bytes:
        found = capture()
        if found.points is None:
            raise InputError("the capture of this room has no points", place=path)
        return packed(found.points, found.colors)

    if captured:
        resources[POINTS] = points
    hemispheres = has_hemispheres(render) if render is not None else []
    scan = POINTS if captured else None
    return {"shots": told, "hemispheres": hemispheres, "scan": scan, "glb": True}, resources


def room_state(path: Path) -> dict[str, Any]:
    """The state of a stage for the page: prims, joints, looks, cameras and the plan."""
    # Stages are of USD, whose import takes a while.
    from openrooms_usd.view.prims import (
        cameras_of,
        hung_of,
        joints_of,
        looks_of,
        prims_of,
        shell_of,
    )

    stage = open_stage(path)
    with reading(path):
        prims = prims_of(stage)
        return {
            "prims": prims,
            "shell": shell_of(prims),
            "hung": hung_of(prims),
            "joints": joints_of(stage),
            "looks": looks_of(stage),
            "cameras": cameras_of(stage),
            "plan": plan_of(stage),
        }


def check_look(path: Path, asked: LookRequest) -> None:
    """Refuse a look that an object does not have.

    Raises:
        InputError: It has no such look.
    """
    from openrooms_usd.view.prims import looks_of

    offered = {one["path"]: one["looks"] for one in looks_of(open_stage(path))}.get(asked.path, [])
    if asked.look not in offered:
        raise InputError(
            f"it has no look {asked.look!r}",
            place=asked.path,
            remedy=f"choose {' or '.join(offered)}" if offered else "choose an object with looks",
        )


def refuse_pictures(
    stage: "Usd.Stage", *, beside: Sequence[Path] = (), include_outside: bool = False
) -> None:
    """Refuse to show pictures from outside a stage's folder.

    Args:
        stage: The stage.
        beside: Other folders that they may lie in.
        include_outside: Whether they may lie anywhere.

    Raises:
        InputError: A file of the stage cannot be read.
        StageError: There are some.
    """
    from openrooms_usd.rendering.bake.baking import LIT
    from openrooms_usd.usd.outside import COPY_OR_TAKE_OUT, is_picture, refuse_outside

    if include_outside:
        return
    is_bake = Path(stage.GetRootLayer().realPath).name == LIT and not beside
    way = f"{COPY_OR_TAKE_OUT}; orusd view shows them with --include-outside"
    remedy = _OF_A_BAKE if is_bake else way
    refuse_outside(stage, "the page", is_picture, beside=beside, remedy=remedy)


def room_glb(
    path: Path,
    check: Callable[["Usd.Stage"], None] = refuse_pictures,
    *,
    lit: bool = False,
    looks: Mapping[str, str] | None = None,
) -> bytes:
    """The stage as a GLB file, by the exporter that is installed for it.

    Args:
        path: The USD file.
        check: Refuses pictures that may not be shown.
        lit: Whether it tells where surfaces lie in the stage's lightmaps.
        looks: The look of some prims, in place of what the stage says.

    Raises:
        StageError: It needs pictures that may not be shown.
    """
    # Stages are of USD, whose import takes a while.
    from pxr import Usd

    with scratch_folder() as folder, quiet(), reading(path):
        stage = open_stage(path)
        check(stage)
        with Usd.EditContext(stage, stage.GetSessionLayer()):
            for prim, look in (looks or {}).items():
                variants = stage.GetPrimAtPath(prim).GetVariantSet(names.LOOK)
                variants.SetVariantSelection(look)
        target = folder / "room.glb"
        write_stage(stage, target, "gltf", {"light": "lightmaps"} if lit else {})
        return target.read_bytes()


def plan_of(stage: Usd.Stage) -> list[list[float]]:
    """Ends of lines, two after the other: [x, y, z] in metres, Z up; none without a room's plan."""
    cache, to_world = UsdGeom.XformCache(TIME), world_from_stage(stage)
    loops = []
    for prim, corners in [*_floor(stage), *_openings(stage)]:
        frame = to_world @ local_to_world(prim, cache)
        loops.append(corners @ frame[:3, :3].T + frame[:3, 3])
    lines = [np.stack([loop, np.roll(loop, -1, axis=0)], axis=1).reshape(-1, 3) for loop in loops]
    found: list[list[float]] = np.concatenate([np.empty((0, 3)), *lines]).tolist()
    return found


def _floor(stage: Usd.Stage) -> list[tuple[Usd.Prim, Array]]:
    """The room with the (N, 3) corners of its floor between the walls."""
    prim = stage.GetPrimAtPath(names.ROOM)
    attribute = prim.GetAttribute(names.ROOM_FLOOR) if prim else None
    corners = np.array((attribute.Get(TIME) if attribute else None) or [], dtype=np.float64)
    if corners.ndim != 2 or not np.isfinite(corners).all():
        return []
    return [(prim, np.column_stack([corners, np.zeros(len(corners))]))]


def _openings(stage: Usd.Stage) -> list[tuple[Usd.Prim, Array]]:
    """Doors, windows and openings with their (4, 3) corners, on the inside of the wall."""
    openings = stage.GetPrimAtPath(names.OPENINGS)
    found = []
    for prim in openings.GetChildren() if openings else ():
        attributes = map(prim.GetAttribute, (names.OPENING_WIDTH, names.OPENING_HEIGHT))
        width, height = (one.Get(TIME) if one else None for one in attributes)
        if width and height:
            found.append((prim, 0.5 * _RECTANGLE * [width, 1.0, height]))
    return found
