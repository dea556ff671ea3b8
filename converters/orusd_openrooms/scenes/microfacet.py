"""Surfaces of a stage as ``microfacet`` materials, their maps as the files of a folder."""

import hashlib
import re
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.library.pictures import write_png
from openrooms_usd.rendering.scene.pictures import Picture, Value
from openrooms_usd.rendering.scene.surfaces import Surface
from orusd_openrooms.scenes.records import Bsdf, Color

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


def _encoded(kind: str, picture: Picture) -> NDArray[np.uint8]:
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
