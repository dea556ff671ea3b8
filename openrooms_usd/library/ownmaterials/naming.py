"""Which map a picture is, by its file's name.

The last words of a name say it: ``Wood043_1K-JPG_NormalGL``, ``oak_nor_gl_2k``, ``diffuse_tiled``.
Words about resolution, file type and tiling are passed over.
"""

import re
from itertools import product
from typing import Final, Literal, NamedTuple, get_args

Map = Literal[
    "base_color",
    "normal",
    "normal_gl",
    "normal_dx",
    "roughness",
    "glossiness",
    "metallic",
    "occlusion",
    "opacity",
    "displacement",
    "specular",
    "emission",
    "occlusion_roughness_metallic",
    "roughness_metallic_occlusion",
    "metallic_roughness",
]
MAPS: Final[tuple[Map, ...]] = get_args(Map)

_NORMAL: Final = ("normal", "normals", "normalmap", "nor", "norm", "nrm", "nml")
_WORDS: Final[dict[Map, tuple[str, ...]]] = {
    "base_color": (
        "color", "colour", "col", "basecolor", "basecolour", "albedo", "diffuse", "diff",
        "diffusecolor", "diffusecolour",
    ),
    "normal": _NORMAL,
    "normal_gl": tuple(map("".join, product(_NORMAL, ("gl", "ogl", "opengl")))),
    "normal_dx": tuple(map("".join, product(_NORMAL, ("dx", "directx")))),
    "roughness": ("roughness", "rough", "rgh"),
    "glossiness": ("glossiness", "gloss", "smoothness"),
    "metallic": ("metallic", "metalness", "metal"),
    "occlusion": ("ambientocclusion", "occlusion", "ao", "occ"),
    "opacity": ("opacity", "alpha", "mask", "cutout"),
    "displacement": ("displacement", "disp", "height", "heightmap", "bump"),
    "specular": ("specular", "spec", "specularcolor", "reflection"),
    "emission": ("emission", "emissive", "emit"),
    "occlusion_roughness_metallic": ("arm", "orm", "aorm", "occlusionroughnessmetallic"),
    "roughness_metallic_occlusion": ("rma", "rmao"),
    "metallic_roughness": ("metallicroughness", "metalroughness"),
}  # fmt: skip
_MAP_OF: Final = {word: kind for kind, words in _WORDS.items() for word in words}
# The most words that one map's name has: occlusion, roughness, metallic.
_MAX_MAP_WORDS: Final = 3
_ASIDE: Final = re.compile(
    r"\d+k|\d{3,5}|\d{3,5}x\d{3,5}|\d+b(it)?|jpe?g|png|exr|tiff?|hdr|tga"
    r"|tiled|tileable|tiling|seamless|srgb|linear|raw"
)
_BORDER: Final = re.compile(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])|[^A-Za-z0-9]+")


class Named(NamedTuple):
    """What a file's name says.

    Attributes:
        map: Which map it is.
        subject: The words that are left: those of the material.
    """

    map: Map
    subject: str


def map_of(stem: str) -> Named | None:
    """Which map a picture is, or None when its name does not say.

    Args:
        stem: The file's name without its suffix.
    """
    words = [word.lower() for word in _BORDER.split(stem) if word]
    words = [word for word in words if not _ASIDE.fullmatch(word)]
    # A number at the end counts variants: oak_col_1, oak_col_2.
    counted = words[:-1] if words and words[-1].isdigit() else words
    for length in range(min(_MAX_MAP_WORDS, len(counted)), 0, -1):
        kind = _MAP_OF.get("".join(counted[-length:]))
        if kind is not None:
            rest = counted[:-length] + words[len(counted) :]
            return Named(kind, " ".join(rest))
    return None
