"""The table of ground-truth channels: what every number in a render means.

A renderer declares which of these it can give. Files, manifest, previews and documentation all
read this one table.
"""

import re
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Final, Literal

from openrooms_usd import names

Kind = Literal["light", "geometry", "material", "label", "derived"]
Scope = Literal["view", "light", "grid"]


@dataclass(frozen=True)
class Channel:
    """One channel of a render.

    Attributes:
        name: The name in files, options and the manifest.
        components: The suffixes in the EXR file (``R`` ...); their number is the channel's depth.
        storage: The sample type in the EXR file.
        unit: What one is; ``1`` for a ratio or a unit vector, ``id`` for a label.
        frame: The frame of positions and directions; empty where there is none.
        kind: Groups channels that are sampled and stored alike; ``derived`` ones no renderer gives.
        meaning: The definition, one sentence.
        scope: ``view``: one image of a view. ``light``: one for every light, whose number stands in
            the place of ``_i``. ``grid``: hemispheres about the points that a coarse grid of pixels
            sees, tiled into one image.
        extra: Whether it must be asked for.
    """

    name: str
    components: tuple[str, ...]
    storage: Literal["half", "float"]
    unit: str
    frame: str
    kind: Kind
    meaning: str
    scope: Scope = "view"
    extra: bool = False

    def as_dict(self) -> dict[str, object]:
        """The row as plain data."""
        return asdict(self)


_RGB = ("R", "G", "B")
_XYZ = ("X", "Y", "Z")
_ONE = ("Y",)


def _ids(name: str, meaning: str) -> Channel:
    return Channel(name, _ONE, "float", "id", "", "label", meaning)


def _light(
    name: str, unit: str, meaning: str, *, scope: Scope = "view", parts: tuple[str, ...] = _RGB,
    kind: Kind = "light", frame: str = "",
) -> Channel:  # fmt: skip
    return Channel(name, parts, "float", unit, frame, kind, meaning, scope, extra=True)


CHANNELS: Final[dict[str, Channel]] = {
    channel.name: channel
    for channel in (
        Channel(
            "radiance", _RGB, "float", "nit", "", "light",
            "scene-linear radiance, Rec.709 primaries, D65; 0.2126 R + 0.7152 G + 0.0722 B is "
            "luminance in cd/m2; box filter over the pixel",
        ),
        _light("emission", "nit", "the part of radiance that the first surface emits, or the sky"),
        _light("direct", "nit", "the part of radiance that was scattered once, at the first hit"),
        _light("indirect", "nit", "the part of radiance that was scattered more than once"),
        _light("irradiance", "lux", "irradiance at the first hit, on the camera's side, about the "
               "shading normal with the normal map; 0 without surface"),
        _light("irradiance_direct", "lux", "irradiance that comes straight from lights"),
        _light("irradiance_indirect", "lux", "irradiance that was scattered before"),
        _light("diffuse", "nit", "base_color (1 - metallic) / pi x irradiance, the mean over the "
               "pixel's samples; by a renderer that does not give it, of the channels"),
        _light("specular", "nit", "direct + indirect - diffuse: everything but Lambertian "
               "reflection; of OpenRooms' model the light of the lobe and transmission, evaluated "
               "separately, never negative; of other models, or from a renderer without it, "
               "a difference"),
        _light("residual", "nit", "radiance - diffuse", kind="derived"),
        _light("radiance_i", "nit", "all that light i causes, with all bounces, its own visible "
               "emission or the sky seen through its rectangle included; these sum to radiance",
               scope="light"),
        _light("direct_i", "lux", "irradiance that comes straight from light i; these sum to "
               "irradiance_direct", scope="light"),
        _light("unoccluded_i", "lux", "what direct_i would be if nothing stood between",
               scope="light"),
        _light("visibility_i", "1", "direct_i over unoccluded_i, estimated on the same samples; 0 "
               "where the latter is 0", scope="light"),
        _light("irradiance_i", "lux", "irradiance caused by light i with all bounces; these sum to "
               "irradiance", scope="light"),
        _light("irradiance_unoccluded_i", "lux", "irradiance_i - direct_i + unoccluded_i",
               scope="light", kind="derived"),
        _light("mask_i", "1", "1 where the pixel's centre sees light i: a lamp's object, or the "
               "outside through an opening", scope="light", parts=_ONE, kind="geometry"),
        _light("traced", "1", "the part of the luminance of indirect that full paths brought from "
               "the lights, the rest was looked up in the light cache; 1 where there is no "
               "indirect light, and everywhere with --method reference", parts=_ONE),
        _light("environment", "nit", "radiance that arrives at the first hit, the mean over each "
               "cell's solid angle; tiles of 16 elevations x 32 azimuths "
               "(docs/explanation/light.md)",
               scope="grid", frame="surface"),
        _light("environment_direct", "nit", "the part of environment that comes straight from "
               "lights", scope="grid", frame="surface"),
        Channel("depth", _ONE, "float", "m", "camera", "geometry",
                "planar depth along the optical axis; 0 where there is no surface"),
        Channel("distance", _ONE, "float", "m", "camera", "geometry",
                "Euclidean distance from the camera; 0 where there is no surface"),
        Channel("position", _XYZ, "float", "m", "world", "geometry",
                "first hit, in steps of 8 mm at 100 km; 0 where there is no surface"),
        Channel("normal", _XYZ, "half", "1", "world", "geometry",
                "unit shading normal with the normal map, on the camera's side; 0 without surface"),
        Channel("normal_geometric", _XYZ, "half", "1", "world", "geometry",
                "unit normal of the triangle, on the camera's side; 0 without surface"),
        Channel("normal_camera", _XYZ, "half", "1", "camera, OpenGL axes", "geometry",
                "the shading normal along right, up, backward; 0 without surface"),
        Channel("base_color", _RGB, "half", "1", "", "material",
                "scene-linear base colour of the first hit"),
        Channel("roughness", _ONE, "half", "1", "", "material",
                "perceptual roughness R of the first hit, alpha = R^2"),
        Channel("metallic", _ONE, "half", "1", "", "material", "metallic of the first hit"),
        Channel("emission_mask", _ONE, "half", "1", "", "material",
                "1 where the first hit emits light, else 0"),
        _ids("semantic", "OpenRooms' 45 classes by number; 0 unlabelled or no surface"),
        _ids("semantic_nyu40", "NYU Depth V2's 40 classes by number; 0 unlabelled or no surface"),
        _ids("semantic_ade20k", "the 150 classes of ADE20K's scene parsing benchmark by number; 0 "
             "other or no surface"),
        _ids("semantic_coco", "COCO's 80 things by the numbers of its annotations, 1 to 90; 0 none "
             "of them or no surface"),
        _ids("instance", "object number, names in the manifest; 0 without surface"),
        _ids("part", "part number, names in the manifest; 0 without surface"),
        _ids("material", "material number, names in the manifest; 0 without surface or material"),
        Channel("valid", _ONE, "half", "1", "", "geometry",
                "1 where the pixel's centre sees a surface, else 0"),
        Channel("friction", _ONE, "half", "1", "", "derived",
                "static Coulomb coefficient of the first hit, dry, by the substance of its "
                "material refined by base_color and roughness (docs/explanation/friction.md); a "
                "material with only UsdPhysicsMaterialAPI has that value, one without any the "
                "mean of all substances; 0 without surface"),
        Channel("flow", ("X", "Y"), "float", "px", "image", "derived",
                "only of a path's frames: how far what the pixel's centre sees is to the right and "
                "down in the next frame; of the surroundings as if infinitely far; 0 where it is "
                "behind the next camera", extra=True),
        Channel("flow_visible", _ONE, "half", "1", "", "derived",
                "only of a path's frames: 1 where the next frame shows that point, 0 where it is "
                "hidden or outside the picture", extra=True),
        Channel("denoised", _RGB, "float", "nit", "", "derived",
                "radiance after denoising, only with --denoise: for people, no measurement"),
    )
}  # fmt: skip

RENDERED: Final = tuple(name for name, row in CHANNELS.items() if row.kind != "derived")
"""The channels that a renderer may give, in the order of the table."""

DEFAULT: Final = tuple(name for name in RENDERED if not CHANNELS[name].extra)
"""Those of them that are rendered unless told otherwise."""

WRITTEN: Final = (*DEFAULT, "friction")
"""The channels that a run writes unless told otherwise, where the renderer gives all of its own."""


FLOWS: Final = ("flow", "flow_visible")
"""The channels that frames of a path have of the next one."""

CLASS_CHANNELS: Final = {
    names.OPENROOMS45: "semantic",
    names.NYU40: "semantic_nyu40",
    names.ADE20K: "semantic_ade20k",
    names.COCO: "semantic_coco",
}
"""The channel that holds the classes of a taxonomy."""

_NUMBERED: Final = re.compile(r"(?P<base>[a-z_]+)_(?P<light>[0-9]+)")


def definition(name: str) -> Channel:
    """The row of a channel; ``direct_3`` is one of ``direct_i``.

    Raises:
        KeyError: There is no such channel.
    """
    found = _NUMBERED.fullmatch(name)
    return CHANNELS[f"{found['base']}_i" if found and name not in CHANNELS else name]


def numbered(name: str, light: int) -> str:
    """The channel of one light: ``direct_i`` of light 3 is ``direct_3``."""
    return f"{name.removesuffix('_i')}_{light}"


def each(names: Iterable[str], lights: int) -> tuple[str, ...]:
    """Names of single images: every ``_i`` once for each light."""
    return tuple(
        single
        for name in names
        for single in (
            (numbered(name, light) for light in range(lights))
            if CHANNELS[name].scope == "light"
            else (name,)
        )
    )


def markdown_page() -> str:
    """The table as the documentation page ``docs/reference/channels.md``."""
    head = (
        "# Channels\n\n"
        "What every number in a render means: `orusd channels --json` gives the table to programs, "
        "and `manifest.json` the rows of a render. Parts in `channels.exr` are named "
        "`<channel>.<part>`. Channels of each light are in `lights.exr`, with its number for `i`; "
        "hemispheres have their own files. Channels marked `+` must be asked for. With an "
        "orthographic camera `depth` and `distance` are measured along the pixel's ray from the "
        "camera's plane ([cameras](usd.md#cameras)).\n"
        "`orusd channels --markdown` writes this page.\n\n"
        "| channel | parts | stored as | unit | frame | meaning |\n"
        "|---|---|---|---|---|---|\n"
    )
    rows = (
        f"| `{row.name}`{' +' if row.extra else ''} | {' '.join(row.components)} | {row.storage} "
        f"| {row.unit} | {row.frame or '-'} | {row.meaning} |\n"
        for row in CHANNELS.values()
    )
    return head + "".join(rows)
