"""Folders of maps in the naming of ambientCG, Poly Haven, OpenRooms and most others."""

import re
from collections.abc import Iterable
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any, Final, Literal, NamedTuple, get_args

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.library.ownmaterials.material import (
    F0,
    OwnMaterial,
    licence_files,
    licence_in,
    proportions,
    tile_size,
)
from openrooms_usd.library.ownmaterials.normalmaps import Green, Relief, read_relief
from openrooms_usd.portable import in_order
from openrooms_usd.tables import read_table
from openrooms_usd.usd.shading.surfaces import Channel, PreviewSurface, Texture
from openrooms_usd.usd.shading.textures import picture_facts

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

_WORDS: Final[dict[Map, tuple[str, ...]]] = read_table(__file__, "maps.toml")  # type: ignore[assignment]
_NORMALS_OF: Final[dict[Map, tuple[str, ...]]] = {
    "normal_gl": tuple(map("".join, product(_WORDS["normal"], ("gl", "ogl", "opengl")))),
    "normal_dx": tuple(map("".join, product(_WORDS["normal"], ("dx", "directx")))),
}
_MAP_OF: Final = {word: kind for kind, words in (_WORDS | _NORMALS_OF).items() for word in words}
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


# What is read, and which type is taken where two files differ in nothing else.
_SUFFIXES: Final = (
    ".png",
    ".exr",
    ".tif",
    ".tiff",
    ".jpg",
    ".jpeg",
    ".hdr",
    ".tga",
    ".bmp",
    ".webp",
)
_INVERTED: Final = ((-1.0, -1.0, -1.0, 1.0), (1.0, 1.0, 1.0, 0.0))


class _Way(NamedTuple):
    """One way to get an input: which map, which channel of it, and whether it is inverted."""

    map: Map
    channel: Channel
    inverted: bool = False


# The ways to each input that is one number, the preferred one first.
_WAYS: Final[dict[str, tuple[_Way, ...]]] = {
    "roughness": (
        _Way("roughness", "r"),
        _Way("glossiness", "r", inverted=True),
        _Way("occlusion_roughness_metallic", "g"),
        _Way("metallic_roughness", "g"),
        _Way("roughness_metallic_occlusion", "r"),
    ),
    "metallic": (
        _Way("metallic", "r"),
        _Way("occlusion_roughness_metallic", "b"),
        _Way("metallic_roughness", "b"),
        _Way("roughness_metallic_occlusion", "g"),
    ),
    "occlusion": (
        _Way("occlusion", "r"),
        _Way("occlusion_roughness_metallic", "r"),
        _Way("roughness_metallic_occlusion", "b"),
    ),
    "opacity": (_Way("opacity", "r"),),
}
# The normal maps, the preferred one first, and where their green points.
_NORMALS: Final[tuple[tuple[Map, Green | None], ...]] = (
    ("normal_gl", "up"),
    ("normal", None),
    ("normal_dx", "down"),
)
_LEFT_OUT: Final[dict[Map, str]] = {
    "displacement": "surfaces are not displaced",
    "specular": "the specular workflow is not supported: dielectrics get the default "
    "reflectance, and metals need a metallic map",
    "emission": "describe light sources as lamps",
}


def read_folder(
    folder: Path, *, physical_size: float | tuple[float, float] | None = None
) -> OwnMaterial:
    """Read a folder of maps.

    Of two files for one map that differ in resolution or type only, the larger one is used, then
    PNG before EXR, TIFF and JPEG. A separate map comes before a packed one, roughness before
    glossiness, and OpenGL normals before DirectX ones.

    Args:
        folder: The folder; its subfolders are not read.
        physical_size: As `read_material` has it.

    Raises:
        InputError: It has no base colour, two different pictures for one map, or a picture that
            cannot be read.
    """
    losses: list[str] = []
    maps = _maps_of(folder, losses)
    if "base_color" not in maps:
        there = ", ".join(sorted(path.name for path in maps.values())) or "none of its pictures"
        raise InputError(
            f"no base colour among its maps (recognised by name: {there})",
            place=folder,
            remedy="name it ..._Color, ..._diff, ..._albedo or ..._basecolor",
        )
    surface = PreviewSurface(
        base_color=_base_color(maps["base_color"], losses),
        normal=_normal(maps, losses),
        f0=F0,
        **_numbers(maps, losses),
    )
    losses += [f"{maps[k].name}: left out; {why}" for k, why in _LEFT_OUT.items() if k in maps]
    material = OwnMaterial(folder.resolve().name, surface, licence=licence_in(folder))
    ratio = proportions(material.textures, losses)
    size = tile_size(physical_size, ratio, None, folder, losses)
    return replace(material, size=size, losses=tuple(losses))


def files_in(folder: Path) -> list[Path]:
    """The files of a folder that `read_folder` reads; sorted."""
    return sorted([*_pictures_in(folder), *licence_files(folder)])


def _pictures_in(folder: Path) -> Iterable[Path]:
    try:
        found = in_order(path for path in folder.iterdir() if path.suffix.lower() in _SUFFIXES)
    except OSError as error:
        raise InputError(
            f"cannot be listed: {error.strerror}", place=folder, remedy="check its permissions"
        ) from error
    return [path for path in found if path.is_file() and not path.name.startswith(".")]


def _maps_of(folder: Path, losses: list[str]) -> dict[Map, Path]:
    """The file of each map."""
    candidates: dict[Map, list[tuple[str, Path]]] = {}
    for path in _pictures_in(folder):
        named = map_of(path.stem)
        if named is None:
            losses.append(f"{path.name}: left out; its name says no map")
        else:
            candidates.setdefault(named.map, []).append((named.subject, path))
    return {kind: _choose_map(folder, kind, found, losses) for kind, found in candidates.items()}


def _choose_map(folder: Path, kind: Map, found: list[tuple[str, Path]], losses: list[str]) -> Path:
    if len({subject for subject, _ in found}) > 1:
        raise InputError(
            f"two pictures for the map {kind}: {', '.join(path.name for _, path in found)}",
            place=folder,
            remedy="keep one of them, or give each material its own folder",
        )
    ranked = sorted((path for _, path in found), key=_rank)
    losses.extend(f"{path.name}: left out; {ranked[0].name} is taken" for path in ranked[1:])
    _check_inside(folder, kind, ranked[0])
    return ranked[0]


def _rank(path: Path) -> tuple[int, int, str]:
    untrusted.checked(path, "picture")
    facts = picture_facts(str(path))
    return -facts.width * facts.height, _SUFFIXES.index(path.suffix.lower()), path.name


def _check_inside(folder: Path, kind: Map, path: Path) -> None:
    if not path.resolve().is_relative_to(folder.resolve()):
        raise InputError(
            f"the map {kind} is a link to outside its folder",
            place=path,
            remedy="copy the picture into the folder",
        )


def color_texture(file: Path) -> Texture:
    """A picture of colours: whole numbers are sRGB, floating point numbers are linear."""
    is_float = picture_facts(str(file)).is_float
    return Texture(str(file.absolute()), "rgb", "raw" if is_float else "sRGB")


def _base_color(file: Path, losses: list[str]) -> Texture:
    if picture_facts(str(file)).has_alpha:
        losses.append(f"{file.name}: its alpha channel is left out; opacity is a map of its own")
    return color_texture(file)


def _normal(maps: dict[Map, Path], losses: list[str]) -> Any:
    for kind, green in _NORMALS:
        if kind not in maps:
            continue
        file = maps[kind]
        relief = read_relief(str(file), green, _heights(maps))
        if isinstance(relief, Relief):
            losses += [f"{file.name}: {loss}" for loss in relief.losses]
            return Texture(str(file.absolute()), scale=relief.scale, bias=relief.bias)
        losses.append(f"{file.name}: left out; {relief}")
    return PreviewSurface.normal


def _heights(maps: dict[Map, Path]) -> str | None:
    return str(maps["displacement"]) if "displacement" in maps else None


def _numbers(maps: dict[Map, Path], losses: list[str]) -> dict[str, Any]:
    """The inputs that are one number, from the preferred map that is there."""
    values: dict[str, Any] = {}
    for name, ways in _WAYS.items():
        way = next((way for way in ways if way.map in maps), None)
        if way is not None:
            values[name] = _number(maps[way.map], way)
    if "opacity" in values:
        values["opacity_mode"] = "presence"
    if "roughness" not in values:
        losses.append(f"no roughness map; {PreviewSurface.roughness:g} everywhere")
    return values


def _number(file: Path, way: _Way) -> Texture:
    texture = Texture(str(file.absolute()), way.channel)
    return replace(texture, scale=_INVERTED[0], bias=_INVERTED[1]) if way.inverted else texture
