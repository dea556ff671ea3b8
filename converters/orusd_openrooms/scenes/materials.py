"""From ``microfacet`` materials to surfaces of models and looks of the room's shell.

albedo = min(1, decoded map * albedoScale), roughness = min(1, map * roughnessScale), normal maps
with +Y up. A texture of USD has the same factors, so models keep their maps as they are. A look of
the description has none, so the shell's maps are written anew with the factors in them.
"""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import untrusted
from openrooms_usd.colorimetry import linear_from_srgb, srgb_from_linear
from openrooms_usd.errors import InputError
from openrooms_usd.library.pictures import write_png
from orusd_openrooms.scenes.records import Bsdf
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
        InputError: One of them is no picture.
    """
    return {_NAMES[kind]: _tiled(bsdf, kind, path) for kind, path in pictures.items()}


def _tiled(bsdf: Bsdf, kind: str, path: Path) -> bytes:
    if path.suffix.lower() != ".png":
        raise InputError("a map of a material is no PNG file", place=path, remedy="convert it")
    if kind in ("normal", "metallic"):
        return untrusted.read_bytes(path, "picture")
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / _NAMES[kind]
        write_png(target, _scaled(bsdf, kind, path), is_color=kind == "albedo")
        return untrusted.read_bytes(target, "picture")


def repeat_m(bsdf: Bsdf, repeats: float | None) -> float:
    """The width that one repeat covers, metres, where a metre has so many units of st."""
    return float(round(1.0 / max((repeats or USUAL_REPEATS) * bsdf.uv_scale, 1e-3), 4))


def _scaled(bsdf: Bsdf, kind: str, path: Path) -> NDArray[np.uint8]:
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
