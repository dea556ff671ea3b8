"""Writes what photographs say of a stage's materials and lights as a layer of opinions."""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd import atomic, claims, names
from openrooms_usd.appearance.authoring import PartLook, material_names, write_opinions
from openrooms_usd.appearance.photographs import metric, read_posed
from openrooms_usd.appearance.pictures import TakenPicture, read_pictures
from openrooms_usd.appearance.recovery import Appearance, recover
from openrooms_usd.appearance.registration import register
from openrooms_usd.appearance.textures import Painted
from openrooms_usd.appearance.views import Photograph, geometry_in
from openrooms_usd.arrays import Array
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError
from openrooms_usd.imagefile import write_png
from openrooms_usd.progress import Progress, nested, silent
from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.opening import open_for_rendering
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.shading.surfaces import Texture

_LEDGER: Final = ".orusd.appearance.sha256"
_REPORT: Final = "report.json"
SKY: Final = "sky.exr"
TEXTURES: Final = "textures"
# Colours less certain than this share of themselves are not written.
_LEAST_SURE: Final = 1.0


@dataclass(frozen=True)
class PhotographOptions:
    """How photographs are read.

    Attributes:
        form: The name of their reader; None: their contents decide.
        scale: Metres for one unit of their world; None where that is known.
        up: The vertical of their world; None where Z is.
        hold_out: Every so many-th photograph is left for measuring; 0: none is.
        register: Whether poses are checked against the geometry, and corrected.
    """

    form: str | None = None
    scale: float | None = None
    up: str | None = None
    hold_out: int = 0
    register: bool = True


def write_appearance(
    stage: Path,
    photographs: Path,
    layer: Path,
    options: PhotographOptions | None = None,
    *,
    seed: int = 0,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Find what a stage is made of and lit by, and write it as opinions.

    ``layer`` receives materials, lamps and surroundings. A folder of its name beside it receives
    the pictures that it refers to, and ``report.json``: each part, light and photograph with how
    sure it is.

    Args:
        stage: A composed room or any USD file, of exact or scanned meshes; it stays as it is.
        photographs: A file or folder of posed photographs.
        layer: The USD layer to write.
        options: How the photographs are read.
        seed: Of random numbers.
        progress: Called with the step and the finished fraction.

    Returns:
        The report.

    Raises:
        InputError: A file cannot be read, or the photographs show nothing of the stage.
        OutputError: A file cannot be written, or is not ours to replace.
        RenderError: The renderer's backend is not available.
    """
    options = options or PhotographOptions()
    if layer.suffix not in {".usda", ".usdc"}:
        raise InputError(
            "opinions are written to a USD layer",
            place=layer,
            remedy="choose a name that ends in .usda or .usdc",
        )
    folder = layer.with_suffix("")
    claims.check_output(layer)
    claims.check_refill(folder, _LEDGER, (_REPORT, SKY))
    posed = metric(read_posed(photographs, options.form), scale=options.scale, up=options.up)
    used = tuple(f for i, f in enumerate(posed.frames) if not _is_held_out(i, options.hold_out))
    turn = _world_from_source(stage)
    taken = [replace(one, frame=_moved(one.frame, turn)) for one in read_pictures(posed, used)]
    progress("translating", 0.0)
    context = open_for_rendering(stage, RenderSettings())
    told: dict[str, Any] = {}
    if options.register:
        progress("checking poses", 0.05)
        twin = not np.array_equal(turn, np.eye(4))
        taken, told = _registered(context, taken, photographs, exact=not twin)
    found = recover(
        context,
        [one.frame for one in taken],
        [one.pixels for one in taken],
        seed,
        nested(progress, "", 0.2, 1.0),
    )
    telling = {frame.id for frame in found.frames}
    blind = [one.frame.id for one in taken if one.frame.id not in telling]
    held_out = [f.id for i, f in enumerate(posed.frames) if _is_held_out(i, options.hold_out)]
    report = found.as_dict() | {"registration": told, "held_out": held_out}
    report["notes"] = [*posed.notes, *map(_left_out, blind)]
    with claims.refilling(folder, _LEDGER) as refill, claims.output(layer):
        (refill.folder / TEXTURES).mkdir()
        for one in found.painted:
            write_png(refill.folder / _picture_name(found, one), one.pixels)
        report["notes"] += write_opinions(
            stage,
            layer,
            looks_of(found, folder.name),
            lamps_of(found),
            found.sky,
            refill.folder / SKY,
            f"./{folder.name}/{SKY}",
        )
        text = json.dumps(report, indent=2, ensure_ascii=False, allow_nan=False)
        atomic.write_text(refill.folder / _REPORT, text + "\n")
    return report


def looks_of(found: Appearance, folder: str) -> list[PartLook]:
    """What parts are made of, of which that is known well enough.

    Args:
        found: The appearance.
        folder: Name of the folder beside the layer that holds pictures.
    """
    solution, problem = found.solution, found.problem
    named = material_names(found.parts.values())
    pictures = {
        one.chart.part: Texture(
            f"./{folder}/{_picture_name(found, one)}",
            color_space="sRGB",
            wrap_s="clamp",
            wrap_t="clamp",
            primvar=one.chart.primvar,
            uv_scale=(float(one.chart.scale[0]), float(one.chart.scale[1])),
            uv_translation=(float(one.chart.offset[0]), float(one.chart.offset[1])),
        )
        for one in found.painted
    }
    return [
        PartLook(
            path,
            named[path],
            solution.base[number],
            float(problem.roughness[number]),
            float(problem.metallic[number]),
            pictures.get(number),
        )
        for number, path in found.parts.items()
        if solution.base_sd[number].max() < _LEAST_SURE
    ]


def _picture_name(found: Appearance, painted: Painted) -> str:
    named = material_names(found.parts.values())
    return f"{TEXTURES}/{named[found.parts[painted.chart.part]]}.png"


def lamps_of(found: Appearance) -> dict[str, Array]:
    """(3,) nits by the prim of each emitting mesh."""
    return {
        emitter: found.solution.strengths[index]
        for index, emitters in enumerate(found.emitters)
        for emitter in emitters
    }


def _registered(
    context: RenderContext, taken: list[TakenPicture], place: Path, *, exact: bool
) -> tuple[list[TakenPicture], dict[str, Any]]:
    """Photographs with corrected poses, and what was corrected.

    Twins of scans have other furniture: where photographs do not fit these, poses stay as they are.

    Raises:
        InputError: They do not show this stage.
    """
    shown = [
        Photograph(one.pixels, one.frame.K, one.frame.world_from_camera, one.depth) for one in taken
    ]
    found = register(shown, geometry_in(context.scene, context.tracer))
    if found.verdict == "refused" and not exact:
        return taken, {"verdict": "unclear", "sentence": found.sentence, "photographs": []}
    if found.verdict == "refused":
        raise InputError(
            found.sentence,
            place=place,
            remedy="check that they are of this room; --no-register takes poses as they are",
        )
    moved = [
        replace(one, frame=replace(one.frame, world_from_camera=pose))
        for one, pose in zip(taken, found.poses(shown), strict=True)
    ]
    rows = [
        {"id": one.frame.id, "before": row.before, "after": row.after, "unit": row.unit}
        for one, row in zip(taken, found.frames, strict=True)
    ]
    return moved, {"verdict": found.verdict, "sentence": found.sentence, "photographs": rows}


def _left_out(name: str) -> str:
    return f"photograph {name} is left out: all it shows of the stage is dark or saturated"


def _is_held_out(index: int, every: int) -> bool:
    return every > 0 and index % every == every - 1


def _world_from_source(stage: Path) -> Array:
    """(4, 4) from the frame of a capture to the stage that was composed from it."""
    opened = open_stage(stage)
    prim = opened.GetPrimAtPath(names.ROOM)
    attribute = prim.GetAttribute(names.SOURCE_FROM_WORLD) if prim else None
    if not attribute or not attribute.HasValue():
        return np.eye(4)
    return np.asarray(np.linalg.inv(np.array(attribute.Get()).T))


def _moved(frame: CapturedFrame, turn: Array) -> CapturedFrame:
    return replace(frame, world_from_camera=turn @ frame.world_from_camera)
