"""The page of a stage: its surfaces as a GLB file, and what is known of its prims."""

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from openrooms_usd import names
from openrooms_usd.convert import convert_stage
from openrooms_usd.description.model import Model
from openrooms_usd.errors import InputError
from openrooms_usd.usd.diagnostics import quiet
from openrooms_usd.usd.layers import open_stage
from openrooms_usd.view.app import App, Command


class Look(Model):
    """A look that somebody wants to see."""

    path: str
    """The object's prim."""
    look: str
    """The variant."""


def room_app(path: Path, *, include_outside: bool = False) -> App:
    """The page of a stage.

    Args:
        path: The USD file.
        include_outside: Whether pictures outside its folder may be shown.

    Raises:
        InputError: It is no stage.
    """
    stage = open_stage(path)
    # Lightmaps are read once: nobody edits them.
    from openrooms_usd.view.light import light_of
    from openrooms_usd.view.tracing import PICTURE, Nothing, Trace, Tracing

    light, maps = light_of(stage)
    tracing = Tracing(path)
    looks: dict[str, str] = {}

    def look(asked: Look) -> dict[str, Any]:
        check_look(path, asked)
        looks[asked.path] = asked.look
        return {}

    edits = path.parent / names.LAYERS / f"{names.EDITS}.usda"
    return App(
        page="room",
        title=f"{path.resolve().parent.name} / {path.name}",
        state=lambda: {**room_state(path), "light": light},
        resources={
            "room.glb": lambda: room_glb(
                path, include_outside=include_outside, lit=bool(light), looks=looks
            ),
            **maps,
        },
        live={PICTURE: tracing.picture},
        commands={
            "look": Command(Look, look),
            "trace": Command(Trace, tracing.start),
            "traced": Command(Nothing, tracing.told),
            "trace_stop": Command(Nothing, tracing.stop),
        },
        watched=(path, edits),
    )


def room_state(path: Path) -> dict[str, Any]:
    """What the page is told of a stage: prims, joints, looks and cameras.

    Args:
        path: The USD file.
    """
    # Stages are of USD, whose import takes a while.
    from openrooms_usd.view.prims import cameras_of, joints_of, looks_of, prims_of, shell_of

    stage = open_stage(path)
    prims = prims_of(stage)
    return {
        "prims": prims,
        "shell": shell_of(prims),
        "joints": joints_of(stage),
        "looks": looks_of(stage),
        "cameras": cameras_of(stage),
    }


def check_look(path: Path, asked: Look) -> None:
    """Refuse a look that an object does not have.

    Raises:
        InputError: It has no such look.
    """
    from openrooms_usd.view.prims import looks_of

    offered = {one["path"]: one["looks"] for one in looks_of(open_stage(path))}.get(asked.path, [])
    if asked.look not in offered:
        raise InputError(
            f"it has no look {asked.look!r}", place=asked.path,
            remedy=f"choose {' or '.join(offered)}" if offered else "choose an object with looks",
        )  # fmt: skip


def room_glb(
    path: Path,
    *,
    include_outside: bool = False,
    lit: bool = False,
    looks: Mapping[str, str] | None = None,
) -> bytes:
    """The stage as a GLB file, by the exporter that is installed for it.

    Args:
        path: The USD file.
        include_outside: Whether pictures outside its folder may be in it.
        lit: Whether it tells where surfaces lie in the stage's lightmaps.
        looks: The look of some prims, in place of what the stage says.

    Raises:
        StageError: It needs pictures outside its folder.
    """
    with tempfile.TemporaryDirectory(prefix="orusd-view-") as folder, quiet():
        target = Path(folder) / "room.glb"
        options = {"light": "lightmaps"} if lit else {}
        convert_stage(
            path, target, to="gltf", options=options, include_outside=include_outside,
            variants={prim: {names.LOOK: look} for prim, look in (looks or {}).items()},
        )  # fmt: skip
        return target.read_bytes()
