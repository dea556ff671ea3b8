"""The page of a stage: its surfaces as a GLB file, and what is known of its prims."""

import tempfile
from pathlib import Path
from typing import Any

from openrooms_usd import names
from openrooms_usd.convert import convert_stage
from openrooms_usd.usd.diagnostics import quiet
from openrooms_usd.usd.layers import open_stage
from openrooms_usd.view.app import App


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

    light, maps = light_of(stage)
    edits = path.parent / names.LAYERS / f"{names.EDITS}.usda"
    return App(
        page="room",
        title=f"{path.resolve().parent.name} / {path.name}",
        state=lambda: {**room_state(path), "light": light},
        resources={
            "room.glb": lambda: room_glb(path, include_outside=include_outside, lit=bool(light)),
            **maps,
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


def room_glb(path: Path, *, include_outside: bool = False, lit: bool = False) -> bytes:
    """The stage as a GLB file, by the exporter that is installed for it.

    Args:
        path: The USD file.
        include_outside: Whether pictures outside its folder may be in it.
        lit: Whether it tells where surfaces lie in the stage's lightmaps.

    Raises:
        StageError: It needs pictures outside its folder.
    """
    with tempfile.TemporaryDirectory(prefix="orusd-view-") as folder, quiet():
        target = Path(folder) / "room.glb"
        options = {"light": "lightmaps"} if lit else {}
        convert_stage(path, target, to="gltf", options=options, include_outside=include_outside)
        return target.read_bytes()
