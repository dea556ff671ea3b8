"""From ``microfacet`` materials to surfaces of models and looks of the room's shell.

albedo = min(1, decoded map * albedoScale), roughness = min(1, map * roughnessScale), normal maps
with +Y up. A texture of USD has the same factors, so models keep their maps as they are. A look of
the description has none, so the shell's maps are written anew with the factors in them.
"""

import hashlib
import re
from collections.abc import Callable, Iterator
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.arrays import Array, Bytes
from openrooms_usd.colorimetry import linear_from_srgb, srgb_from_linear
from openrooms_usd.errors import InputError
from openrooms_usd.library.pictures import write_png
from openrooms_usd.rendering.scene.pictures import Picture, Value
from openrooms_usd.rendering.scene.surfaces import Surface
from openrooms_usd.scratch import scratch_folder
from orusd_openrooms.scenes.records import Bsdf, Color
from orusd_openrooms.scenes.roots import Named, named
from orusd_openrooms.scenes.standins import material_name, substance_of

if TYPE_CHECKING:
    from openrooms_usd.usd.shading.materials import PreviewSurface, Texture


Find = Callable[[Named], Path | None]

PICTURES: Final = ("albedo", "normal", "roughness", "metallic")
# Names by which folders of maps are read.
_NAMES: Final = {
    "albedo": "Color.png",
    "normal": "NormalGL.png",
    "roughness": "Roughness.png",
    "metallic": "Metalness.png",
}
# Texture coordinates of the released layouts have this many units in a metre.
USUAL_REPEATS: Final = 8.952
_DIGITS: Final = 6


def pictures_of(bsdf: Bsdf, find: Find) -> dict[str, Path] | None:
    """The maps of a material that are there; None where its colour is not.

    Raises:
        InputError: A path leads out of the dataset.
    """
    place = f"bsdf {bsdf.id[:80]!r}"
    found = {kind: find(named(path, place)) for kind, path in bsdf.maps.items()}
    there = {kind: path for kind, path in found.items() if path is not None}
    return None if "albedo" in bsdf.maps and "albedo" not in there else there


def stand_in(bsdf: Bsdf) -> dict[str, Any]:
    """A look of the library for a material whose maps are not there."""
    return {"substance": substance_of(material_name(bsdf.maps["albedo"]))}


def constant(bsdf: Bsdf) -> dict[str, Any]:
    """A look of a material without maps."""
    r, g, b = _albedo(bsdf)
    return {"color": [r, g, b], "roughness": _roughness(bsdf), "metallic": round(bsdf.metallic, 6)}


def surface_of(bsdf: Bsdf, pictures: dict[str, str]) -> "PreviewSurface":
    """The same material as a surface of USD.

    Args:
        bsdf: The material.
        pictures: Asset paths of its maps.
    """
    from openrooms_usd.usd.shading.materials import PreviewSurface
    from openrooms_usd.usd.shading.surfaces import NORMAL_BIAS, NORMAL_SCALE

    def texture(kind: str, **how: Any) -> "Texture | None":
        from openrooms_usd.usd.shading.materials import Texture

        if kind not in pictures:
            return None
        return Texture(pictures[kind], uv_scale=(bsdf.uv_scale, bsdf.uv_scale), **how)

    factor = bsdf.roughness_scale
    values: dict[str, Any] = {
        "base_color": texture("albedo", color_space="sRGB", scale=(*bsdf.albedo_scale, 1.0)),
        "normal": texture("normal", scale=NORMAL_SCALE, bias=NORMAL_BIAS),
        "roughness": texture("roughness", channel="r", scale=(factor, factor, factor, 1.0)),
        "metallic": texture("metallic", channel="r"),
    }
    usual = {"base_color": _albedo(bsdf), "roughness": _roughness(bsdf), "metallic": bsdf.metallic}
    given = {kind: value for kind, value in values.items() if value is not None}
    return PreviewSurface(**{**usual, **given}, f0=bsdf.f0)


def tiled_pictures(bsdf: Bsdf, pictures: dict[str, Path]) -> dict[str, bytes]:
    """The maps of a material with its factors in them, by the names of a folder of maps.

    Raises:
        InputError: One of them is not a picture.
    """
    return {_NAMES[kind]: _tiled(bsdf, kind, path) for kind, path in pictures.items()}


def _tiled(bsdf: Bsdf, kind: str, path: Path) -> bytes:
    if path.suffix.lower() != ".png":
        raise InputError("a map of a material is not a PNG file", place=path, remedy="convert it")
    if kind in ("normal", "metallic"):
        return untrusted.read_bytes(path, "picture")
    with scratch_folder() as folder:
        target = folder / _NAMES[kind]
        write_png(target, _scaled(bsdf, kind, path), is_color=kind == "albedo")
        return untrusted.read_bytes(target, "picture")


def repeat_m(bsdf: Bsdf, repeats: float | None) -> float:
    """The width that one repeat covers, metres, where a metre has so many units of st."""
    return float(round(1.0 / max((repeats or USUAL_REPEATS) * bsdf.uv_scale, 1e-3), 4))


def _scaled(bsdf: Bsdf, kind: str, path: Path) -> Bytes:
    from openrooms_usd.usd.shading.textures import read_texture

    stored = read_texture(str(path))
    stored = np.repeat(stored[..., :1], 3, axis=2) if stored.shape[2] < 3 else stored[..., :3]
    if kind == "albedo":
        scaled = linear_from_srgb(stored) * np.array(bsdf.albedo_scale, dtype=np.float32)
        values = srgb_from_linear(np.clip(scaled, 0.0, 1.0).astype(np.float32))
    else:
        values = np.clip(stored * np.float32(bsdf.roughness_scale), 0.0, 1.0)
    return np.round(values * 255.0).astype(np.uint8)


def _albedo(bsdf: Bsdf) -> tuple[float, float, float]:
    pairs = zip(bsdf.albedo, bsdf.albedo_scale, strict=True)
    r, g, b = (round(min(1.0, value * factor), _DIGITS) for value, factor in pairs)
    return r, g, b


def _roughness(bsdf: Bsdf) -> float:
    return round(min(1.0, bsdf.roughness * bsdf.roughness_scale), _DIGITS)


# Surfaces of a stage as `microfacet` materials, their maps as the files of a folder.

_FOLDER: Final = "BRDFOriginDataset"
_FILES: Final = {
    "albedo": "diffuse_tiled.png",
    "normal": "normal_tiled.png",
    "roughness": "rough_tiled.png",
    "metallic": "metallic_tiled.png",
}
_F0: Final = 0.05


class Materials:
    """Writes the maps of surfaces, each once.

    Attributes:
        root: The dataset's folder.
        up: The way from a scene file to it.
    """

    def __init__(self, root: Path, up: str) -> None:
        self.root = root
        self.up = up
        self._names: dict[int, tuple[str, Surface]] = {}

    def bsdf(self, identifier: str, surface: Surface, name: str) -> Bsdf:
        """A surface as a material; its maps are written where they were not.

        Args:
            identifier: What ``usemtl`` will call it.
            surface: What it does to light.
            name: The prim that gives it, or what people call it.

        Raises:
            OutputError: A map cannot be written.
        """
        pictures = dict(_pictures(surface))
        folder = (
            self._folder(surface, name.rpartition("/")[2], pictures)
            if pictures
            else PurePosixPath()
        )
        maps = {kind: f"{self.up}{folder}/{_FILES[kind]}" for kind in pictures}
        return Bsdf(
            identifier,
            maps,
            albedo=_color(surface.base_color),
            roughness=_number(surface.roughness),
            metallic=_number(surface.metallic),
            f0=_F0 if surface.f0 is None else surface.f0,
        )

    def _folder(self, surface: Surface, name: str, pictures: dict[str, Picture]) -> PurePosixPath:
        if id(surface) not in self._names:
            plain = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_").lower() or "material"
            codes = {kind: _encoded(kind, picture) for kind, picture in pictures.items()}
            # Named by what it holds, so that rooms of one dataset share it.
            digest = hashlib.sha256(repr([(k, c.shape) for k, c in codes.items()]).encode())
            for values in codes.values():
                digest.update(values.tobytes())
            unique = f"{plain}_{digest.hexdigest()[:8]}"
            # The surface is kept with its name, so that its identity is not given to others.
            self._names[id(surface)] = unique, surface
            for kind, values in codes.items():
                file = self.root / self._path(unique) / _FILES[kind]
                write_png(file, values, is_color=kind == "albedo")
        return self._path(self._names[id(surface)][0])

    def _path(self, name: str) -> PurePosixPath:
        return PurePosixPath(_FOLDER, f"Material__{name}", "tiled")


def losses(surface: Surface) -> str:
    """What of a surface a material of that kind cannot say; empty for nothing."""
    found = []
    if surface.f0 is None:
        found.append("a UsdPreviewSurface is shown by OpenRooms' model with f0 = 0.05")
    if surface.clearcoat > 0.0:
        found.append("its clear coat is left out")
    if surface.opacity != 1.0:
        found.append("it is opaque there")
    if surface.transmission > 0.0:
        found.append("the light that it lets through is left out")
    pictures = [picture for _, picture in _pictures(surface)]
    if any(not np.allclose(picture.uv, pictures[0].uv) for picture in pictures):
        found.append("its maps share one placement")
    if any(picture.wrap != "repeat" for picture in pictures):
        found.append("its maps are repeated")
    return "; ".join(found)


def mapping(surface: Surface) -> Array:
    """(3, 3) from a mesh's texture coordinates to those of its maps."""
    return next((picture.uv for _, picture in _pictures(surface)), np.eye(3))


def _pictures(surface: Surface) -> Iterator[tuple[str, Picture]]:
    values: tuple[tuple[str, Value | None], ...] = (
        ("albedo", surface.base_color),
        ("normal", surface.normal),
        ("roughness", surface.roughness),
        ("metallic", surface.metallic),
    )
    for kind, value in values:
        if isinstance(value, Picture):
            yield kind, value


def _encoded(kind: str, picture: Picture) -> Bytes:
    """(H, W, 3) codes, the first row on top: pictures have it at the bottom."""
    pixels = picture.pixels[::-1].astype(np.float32)
    if kind == "albedo":
        pixels = srgb_from_linear(np.clip(pixels, 0.0, 1.0))
    elif kind == "normal":
        pixels = 0.5 * (pixels + 1.0)
    codes = np.round(np.clip(pixels, 0.0, 1.0) * 255.0).astype(np.uint8)
    return np.broadcast_to(codes, (*codes.shape[:2], 3)).copy()


def _color(value: Value) -> Color:
    if isinstance(value, Picture):
        return Bsdf("").albedo
    r, g, b = np.broadcast_to(np.asarray(value, dtype=np.float64), (3,)).tolist()
    return r, g, b


def _number(value: Value) -> float:
    if isinstance(value, Picture):
        return 0.0
    return float(np.mean(value))
