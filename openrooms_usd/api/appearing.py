"""What rooms are made of and lit by, from photographs."""

from typing import Any

from openrooms_usd.api.given import AnyPath, path_of, usd_file
from openrooms_usd.progress import Progress, silent


def find_appearance(
    scene: AnyPath,
    photographs: AnyPath,
    out: AnyPath,
    *,
    form: str | None = None,
    scale: float | None = None,
    up: str | None = None,
    hold_out: int = 0,
    register: bool = True,
    seed: int = 0,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Find base colours, gloss, lamps and surroundings of a scene, and write them as opinions.

    Args:
        scene: A composed room or any USD file, of exact or scanned meshes; it stays as it is.
        photographs: A list of frames, ``transforms.json``, a COLMAP model or an RGB-D folder.
        out: The USD layer to write; a folder of its name receives pictures and ``report.json``.
        form: The form of the photographs, if several fit.
        scale: Metres for one unit of the cameras' world; None where that is known.
        up: The vertical of their world: ``z``, ``-y``, ``0,1,0.2``, ``cameras``; None where it is
            known.
        hold_out: Every so many-th photograph is left for measuring; 0: none is.
        register: Whether poses are checked against the geometry, and corrected.
        seed: Of random numbers.
        progress: Called with the step and the finished fraction.

    Returns:
        ``parts``, ``lamps``, ``surroundings`` and ``photographs``, each with how sure it is.

    Raises:
        InputError: A file cannot be read, or the photographs show nothing of the scene.
        OutputError: A file cannot be written, or is not ours to replace.
        RenderError: The renderer's backend is not available.
    """
    from openrooms_usd.appearance.driver import PhotographOptions, write_appearance
    from openrooms_usd.usd.files.diagnostics import quiet

    options = PhotographOptions(form, scale, up, hold_out, register)
    with quiet():
        return write_appearance(
            usd_file(scene),
            path_of(photographs, "posed photographs"),
            path_of(out),
            options,
            seed=seed,
            progress=progress,
        )
