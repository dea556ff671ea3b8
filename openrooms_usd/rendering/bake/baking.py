"""From a stage to its lightmaps."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd import claims, names
from openrooms_usd.arrays import Array, Mask
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError, RenderError
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.imagefile import write_png
from openrooms_usd.portable import anchored_text
from openrooms_usd.progress import Progress, nested, silent
from openrooms_usd.rendering import exr
from openrooms_usd.rendering.bake.atlases import Atlases, placed
from openrooms_usd.rendering.bake.layer import (
    AtlasFiles,
    scale_offset,
    write_layer,
    write_lit_stage,
)
from openrooms_usd.rendering.bake.pictures import Border, Pixels, known_of, picture_of
from openrooms_usd.rendering.bake.request import (
    LIFT_M,
    Irradiance,
    IrradianceRequest,
    TexelLighting,
    TexelPoints,
)
from openrooms_usd.rendering.bake.texels import Texels, find_texels
from openrooms_usd.rendering.bake.units import Reading, read_units
from openrooms_usd.rendering.manifest import write_json
from openrooms_usd.rendering.previews import preview
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.lights import LightRecord
from openrooms_usd.rendering.scene.rays import RayTracer
from openrooms_usd.version import __version__

# Rays from each point: one along the normal, the others around it.
_AROUND: Final = 5
_TILT_DEG: Final = 55.0
# So many of a buried point's rays must meet a back.
_BACKS: Final = 5
_POINTS_AT_ONCE: Final = 1 << 19
TEXEL_M: Final = 0.05
SAMPLES: Final = 256
SIDE_TEXELS: Final = 4096
MOST_TEXELS: Final = 1 << 22

MANIFEST: Final = "lightmaps.json"
_LEDGER: Final = ".orusd.bake.sha256"
LAYER: Final = "lightmaps.usda"
LIT: Final = "baked.usda"
FOLDER: Final = "lightmaps"

_CONVENTIONS: Final = {
    "texture": "irradiance in lux of each primary, scene-linear Rec.709, of the side that the "
    "mesh's winding faces, about its shading normals: what is diffuse of the picture is "
    "base colour (1 - metallic) / pi times it",
    "st1": "the place in the atlas is primvars:st1 of a mesh, times (scale s, scale t), plus "
    "(offset s, offset t), by scaleOffset of the mesh or of its instance. t = 0 is the "
    "lower edge of the picture, whose rows begin at the top",
    "sum": "irradiance is the sum of lights, texel by texel",
}


@dataclass(frozen=True)
class AtlasLayout:
    """How large texels and atlases are.

    Attributes:
        texel_m: Side of a texel on the surfaces, metres.
        side: Of an atlas at most, texels.
        most_texels: Of all atlases together; texels grow until there are no more.
    """

    texel_m: float = TEXEL_M
    side: int = SIDE_TEXELS
    most_texels: int = MOST_TEXELS


def bake_stage(
    path: Path,
    out: Path,
    settings: RenderSettings | None = None,
    layout: AtlasLayout = AtlasLayout(),
    *,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Write the light of a stage as textures, and a layer that refers to them.

    ``out`` receives ``lightmaps.usda``, the layer; ``baked.usda``, the stage under it;
    ``lightmaps.json``; and ``lightmaps/`` with the textures and the layer's arrays. The stage
    itself stays as it is.

    Args:
        path: The USD file.
        out: The folder to write.
        settings: What is asked for; its samples are paths for each texel, `SAMPLES` by default, its
            bounces the scatterings of light on its way, the one at the texel included.
        layout: Of the textures.
        progress: Called with what is done and the finished fraction.

    Returns:
        What stands in ``lightmaps.json``.

    Raises:
        InputError: There is nothing to light, or a number is absurd.
        MissingPackageError: xatlas is not installed.
        OutputError: The folder cannot be written.
        RenderError: The renderer lights no texels.
    """
    from openrooms_usd.rendering.opening import open_for_rendering

    settings = settings or RenderSettings()
    samples = settings.samples or SAMPLES
    _check(layout, settings.bounces)
    claims.check_refill(out, _LEDGER, (FOLDER, LAYER, LIT, MANIFEST))
    context = open_for_rendering(path, settings)
    stage, session = context.stage, context.session
    if not isinstance(session, TexelLighting):
        raise RenderError(
            f"the renderer {settings.renderer} cannot compute lightmaps",
            remedy="--renderer mitsuba",
        )
    # 1. What is baked, and where in which picture.
    progress("laying out", 0.0)
    reading = read_units(stage)
    if not reading.units:
        raise InputError("there is no surface to light", place=path)
    atlases = placed(
        reading.units, texel_m=layout.texel_m, side=layout.side, most=layout.most_texels
    )
    # 2. Light.
    texels = without_buried(find_texels(atlases), context.scene, context.tracer)
    lights = context.lights
    method = context.choose_method(len(texels) * samples)
    request = IrradianceRequest(texels.points, samples, settings.seed, settings.bounces, method)
    told = nested(progress, "", 0.05, 0.95)
    light = session.irradiance(request, lambda done: told(f"{len(texels)} texels", done))
    # 3. Files.
    progress("writing", 0.95)
    with claims.refilling(out, _LEDGER) as refill:
        beside = refill.folder
        (beside / FOLDER).mkdir()
        files = _write_pictures(beside, atlases, texels, light.values, lights)
        write_layer(beside / LAYER, FOLDER, stage, atlases, files, lights)
        write_lit_stage(beside / LIT, stage, f"./{LAYER}", _relative(path, out))
        entry = _manifest(path, layout, request, reading, atlases, texels, light, files, lights)
        write_json(beside / MANIFEST, entry)
    progress("writing", 1.0)
    return entry


def _check(layout: AtlasLayout, bounces: int) -> None:
    wrong = {
        f"a texel cannot be {layout.texel_m:g} m wide": not 0.0 < layout.texel_m < np.inf,
        f"light cannot be scattered {bounces} times": bounces < 1,
        f"an atlas cannot be {layout.side} texels wide": not 16 <= layout.side <= 1 << 15,
        f"a lightmap cannot have {layout.most_texels} texels": layout.most_texels < 256,
    }
    for reason, is_so in wrong.items():
        if is_so:
            raise InputError(reason, place="lightmaps", remedy="give another number")


def _relative(stage: Path, out: Path) -> str:
    """The stage as the layer beside the lightmaps refers to it."""
    return anchored_text(stage.resolve(), out.resolve())


def _write_pictures(
    out: Path, atlases: Atlases, texels: Texels, values: Pixels, lights: Sequence[LightRecord]
) -> tuple[AtlasFiles, ...]:
    """The textures of each atlas: one for each light, and their sum with a picture to look at."""
    written = []
    for atlas, total, parts in _pictures(atlases, texels, values):
        files = AtlasFiles(
            f"./{FOLDER}/atlas_{atlas}.exr",
            tuple(f"./{FOLDER}/atlas_{atlas}_{light.name}.exr" for light in lights),
        )
        for file, picture in zip(files.lights, parts, strict=True):
            exr.write_rgb(out / file, picture)
            total += picture
        exr.write_rgb(out / files.total, total.astype(np.float32))
        shown = preview("irradiance", total.astype(np.float32), tone="film").pixels
        write_png((out / files.total).with_suffix(".png"), shown)
        written.append(files)
    return tuple(written)


def _pictures(
    atlases: Atlases, texels: Texels, values: Pixels
) -> Iterator[tuple[int, Array, Iterator[Pixels]]]:
    """(number, zeros to sum up in, picture of each light) of each atlas."""
    for atlas, size in enumerate(atlases.sizes):
        here = np.flatnonzero(texels.atlas == atlas)
        place = size, texels.column[here], texels.row[here]
        border = Border(known_of(*place))
        parts = (border.filled(picture_of(*place, one[here])) for one in values)
        yield atlas, np.zeros((size[1], size[0], 3)), parts


def _manifest(
    path: Path,
    layout: AtlasLayout,
    request: IrradianceRequest,
    reading: Reading,
    atlases: Atlases,
    texels: Texels,
    light: Irradiance,
    files: Sequence[AtlasFiles],
    lights: Sequence[LightRecord],
) -> dict[str, Any]:
    return {
        "format": 1,
        "generator": f"{names.CREATOR} {__version__}",
        "stage": path.name,
        "layer": LAYER,
        "conventions": _CONVENTIONS,
        "texel": {"asked_m": layout.texel_m, "side_m": atlases.texel_m},
        "samples": light.samples,
        "seed": request.seed,
        "bounces": request.bounces,
        "method": request.method,
        "estimated_error": light.error,
        "nonfinite_texels": light.replaced,
        "atlases": [
            {
                "size": list(size),
                "lit_texels": int((texels.atlas == number).sum()),
                "irradiance": files[number].total.removeprefix("./"),
                "lights": [file.removeprefix("./") for file in files[number].lights],
            }
            for number, size in enumerate(atlases.sizes)
        ],
        "lights": [
            {"name": one.name, "kind": one.kind, "path": one.path, "on": one.on} for one in lights
        ],
        "units": [
            {
                "path": one.unit.path,
                "atlas": one.atlas,
                "scale_offset": list(scale_offset(atlases, one)),
                "meshes": len(one.unit.members),
            }
            for one in atlases.placements
        ],
        "left_out": [{"path": where, "reason": reason} for where, reason in reading.left_out],
    }


# Some texels are partly hidden: the floor below the leg of a table, a board below another one. They
# would mix the dark there with the light beside it, and their neighbours would be interpolated from
# it. From inside of a solid, nearly all that rays meet is turned away from
# them.
def without_buried(texels: Texels, scene: Scene, tracer: RayTracer) -> Texels:
    """The visible texels, by the points of them that are not inside a solid.

    Args:
        texels: All that show a surface.
        scene: What may be over it.
        tracer: Of that scene.
    """
    points = texels.points
    corners = scene.triangles.corners
    a, b, c = np.moveaxis(corners, 1, 0)
    fronts = unit(np.cross(b - a, c - a))
    chunks = range(0, len(points.triangles), _POINTS_AT_ONCE)
    buried = np.concatenate(
        [_buried(points, slice(at, at + _POINTS_AT_ONCE), fronts, tracer) for at in chunks]
    )
    texel_of = np.repeat(np.arange(len(points)), np.diff(points.first))
    left = np.bincount(texel_of[~buried], minlength=len(points))
    seen = left > 0
    if not seen.any():
        return texels
    chosen = replace(
        points,
        first=np.concatenate([[0], np.cumsum(left[seen])]),
        triangles=points.triangles[~buried],
        weights=points.weights[~buried],
    )
    return Texels(texels.atlas[seen], texels.column[seen], texels.row[seen], chosen)


def _buried(points: TexelPoints, some: slice, fronts: Array, tracer: RayTracer) -> Mask:
    """(P,) whether nearly all rays of each point meet the back of what they meet first."""
    chosen = replace(points, triangles=points.triangles[some], weights=points.weights[some])
    normals = points.normals[chosen.triangles]
    begins = chosen.positions() + LIFT_M * normals
    backs = np.zeros(len(begins), dtype=np.int64)
    for ahead in _directions(normals):
        rows = tracer.rays(begins, ahead)
        backs += (rows >= 0) & (np.einsum("ij,ij->i", fronts[rows], ahead) > 0.0)
    return np.asarray(backs >= _BACKS)


def _directions(normals: Array) -> list[Array]:
    """Unit directions about normals."""
    least = np.eye(3)[np.abs(normals).argmin(axis=1)]
    across = unit(np.cross(normals, least))
    along = np.cross(normals, across)
    tilt = np.radians(_TILT_DEG)
    turns = 2.0 * np.pi * np.arange(_AROUND) / _AROUND
    tilted = [
        np.cos(tilt) * normals + np.sin(tilt) * (np.cos(turn) * across + np.sin(turn) * along)
        for turn in turns.tolist()
    ]
    return [normals, *tilted]
