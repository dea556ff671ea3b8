"""Composed rooms: made, opened, edited, simulated, checked and written in other forms."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from openrooms_usd.api.given import AnyPath, choice_of, path_of, room_of, usd_file
from openrooms_usd.api.scene import Scene
from openrooms_usd.progress import Progress, silent

if TYPE_CHECKING:
    from openrooms_usd.description.room import Room
    from openrooms_usd.engines import Friction
    from openrooms_usd.exporters import Report
    from openrooms_usd.simulation.settling import Settled
    from openrooms_usd.validation.model import Finding


def compose(
    room: "Room | Mapping[str, Any] | AnyPath",
    out: AnyPath,
    *,
    base: AnyPath | None = None,
    only: str | None = None,
    flatten: bool = False,
    usdz: bool = False,
    include_outside: bool = False,
    workers: int | None = None,
    progress: Progress = silent,
) -> Scene:
    """Compose a room into USD layers; what has not changed since the last time is skipped.

    Args:
        room: A `Room`, plain data as a ``room.yaml`` has it, a ``room.yaml`` or its folder.
        out: The folder for ``scene.usda`` and ``layers/``.
        base: The folder in which the names of files in the room begin: by default that of its
            ``room.yaml``, and the current folder for a room that was read from no file.
        only: Run this step alone, on the layers that are there.
        flatten: Also write ``scene.usdc``, one layer.
        usdz: Also write ``scene.usdz``, everything in one file.
        include_outside: Whether files outside ``out`` may go into these files.
        workers: Threads that a stage may use; all cores by default. The bytes never depend on it.
        progress: Called with each step's name and the finished fraction of all steps.

    Returns:
        The composed room.

    Raises:
        DescriptionError: The room has mistakes; the message lists all with their places.
        InputError: A file that the room names cannot be read.
        StageError: The composed stage has errors, or another program has saved over the scene.
        OutputError: ``out`` cannot be written.
    """
    from openrooms_usd.composing import compose_room
    from openrooms_usd.usd.files.diagnostics import quiet

    described, folder = room_of(room), path_of(out)
    with quiet():
        done = compose_room(
            described,
            folder,
            base=None if base is None else path_of(base),
            only=only,
            flatten=flatten,
            usdz=usdz,
            include_outside=include_outside,
            workers=workers,
            progress=progress,
        )
    kept = described if base is None else described.located(path_of(base))
    return Scene(done.scene, done, kept)


def open_scene(path: AnyPath) -> Scene:
    """Open a composed room by its folder, or any USD file.

    Args:
        path: The folder that compose wrote, its ``scene.usda``, or any USD file.

    Raises:
        InputError: It is missing or no readable USD.
    """
    scene = Scene(usd_file(path))
    scene.stage()
    return scene


def simulate(
    scene: AnyPath,
    *,
    engine: str = "mujoco",
    seconds: float = 2.0,
    timestep: float | None = None,
    friction: "Friction" = "static",
    look: str | None = None,
    out: AnyPath | None = None,
    progress: Progress = silent,
) -> "Settled":
    """Let a room settle under gravity, and write where everything came to rest as a layer.

    The room starts from where its description and edits have put it, whatever was simulated before.

    Args:
        scene: A composed room or any USD file with physics.
        engine: ``mujoco`` or ``pybullet``, which has wheels for Python 3.11 alone.
        seconds: How long.
        timestep: Seconds of one step; 0.002 by default.
        friction: Which coefficient of each surface counts.
        look: Choose this variant of every object that has it, for its friction.
        out: The layer; of a composed room by default ``layers/settled.usda``, a part of it.
        progress: Called with what is done and the finished fraction.

    Returns:
        How far everything has moved: ``.moved``, the farthest first.

    Raises:
        InputError: The file is not USD, no engine has that name, or a number makes no sense.
        MissingPackageError: The engine is not installed.
        StageError: The stage has no physics, or the simulation explodes.
        OutputError: The layer cannot be written.
    """
    from openrooms_usd.engines import DEFAULT_TIMESTEP, Friction
    from openrooms_usd.simulation.settling import settle
    from openrooms_usd.usd.files.diagnostics import quiet

    choice_of(friction, Friction, "friction")
    with quiet():
        return settle(
            usd_file(scene),
            engine=engine,
            seconds=seconds,
            out=None if out is None else path_of(out),
            timestep=DEFAULT_TIMESTEP if timestep is None else timestep,
            friction=friction,
            look=look,
            progress=progress,
        )


def convert(
    scene: AnyPath,
    out: AnyPath,
    *,
    to: str | None = None,
    options: Mapping[str, Any] | None = None,
    include_outside: bool = False,
    time_code: float | None = None,
) -> "Report":
    """Write a scene in a foreign form.

    Args:
        scene: A composed room or any USD file.
        out: The file or folder to write.
        to: ``mitsuba``, ``gltf``, ``usdz``, ``urdf``, ``mjcf``, ``usdphysics``, or another
            installed exporter; None for what ``out`` ends in: .glb, .usdz, or ``mitsuba`` for .xml
            and folders.
        options: What is asked of the exporter.
        include_outside: Whether pictures outside the scene's folder may be copied.
        time_code: The moment to write of a scene that moves; None for the first sample of
            everything.

    Returns:
        What became of every prim; ``.losses()`` are those that were not translated whole.

    Raises:
        InputError: The file is not USD, no exporter has that name or writes such files, or this
            exporter cannot write a single moment.
        StageError: It needs pictures outside its folder, or is not what the exporter needs.
        OutputError: The destination cannot be written, or what lies there is not ours.
    """
    from openrooms_usd.exporters import convert_stage
    from openrooms_usd.usd.files.diagnostics import quiet

    with quiet():
        return convert_stage(
            usd_file(scene),
            path_of(out),
            to=to,
            options=options,
            include_outside=include_outside,
            time_code=time_code,
        )


def validate(scene: AnyPath, *, strict: bool = False) -> "Sequence[Finding]":
    """Check a scene against USD's rules and ours.

    Args:
        scene: A composed room or any USD file.
        strict: Count warnings as errors.

    Returns:
        What is wrong, errors first; empty for a clean scene.

    Raises:
        InputError: The file is missing, is not USD, or holds what cannot be read at all.
    """
    from openrooms_usd.rules import validate_stage

    return validate_stage(usd_file(scene), strict=strict)
