"""The files beside an exported scene: meshes, materials and pictures, each written once."""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Final

import numpy as np

from openrooms_usd import atomic
from openrooms_usd.colorimetry import linear_from_srgb, srgb_from_linear
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.world import Visual
from openrooms_usd.scratch import scratch_folder
from orusd_urdf import objfile
from orusd_urdf.looks import PLAIN, Loss, RobotMaterial
from orusd_urdf.naming import Names

if TYPE_CHECKING:
    from openrooms_usd.usd.shading.surfaces import Texture

MESHES: Final = PurePosixPath("meshes")
TEXTURES: Final = PurePosixPath("textures")


@dataclass
class Assets:
    """Writes files into a folder; equal contents share the first one's name.

    Attributes:
        folder: Where ``meshes`` and ``textures`` shall lie.
        losses: What could not be kept.
    """

    folder: Path
    losses: list[Loss] = field(default_factory=list)
    _names: Names = field(default_factory=Names)
    _files: dict[tuple[str, bytes], PurePosixPath] = field(default_factory=dict)
    _pictures: "dict[Texture, PurePosixPath | None]" = field(default_factory=dict)
    _materials: dict[RobotMaterial, str] = field(default_factory=dict)

    @property
    def materials(self) -> Iterator[tuple[str, RobotMaterial, PurePosixPath | None]]:
        """Name, look and picture of every material that was used, in that order."""
        for look, name in self._materials.items():
            yield name, look, self._pictures[look.texture] if look.texture else None

    def collision(self, stem: str, mesh: TriangleMesh) -> PurePosixPath:
        """Write a convex shape."""
        return self._write(MESHES, f"{stem}_collision", ".obj", objfile.collision_text(mesh))

    def visual(self, stem: str, visual: Visual, look: RobotMaterial = PLAIN) -> PurePosixPath:
        """Write a surface and its material."""
        name = self.material(look, PurePosixPath(visual.material).name or "plain")
        st = look.coordinates(visual)
        if st is None and look.texture is not None:
            reason = "it has no texture coordinates: no picture"
            self.losses.append((visual.material, "approximated", reason))
        text = objfile.visual_text(visual.mesh, st, name, f"{name}.mtl")
        return self._write(MESHES, stem, ".obj", text)

    def material(self, look: RobotMaterial, name: str) -> str:
        """The name of a look's material, whose MTL file is written with the first use."""
        if look not in self._materials:
            picture = self._picture(look.texture) if look.texture else None
            chosen = self._materials[look] = self._names.unique(name)
            relative = f"../{picture}" if picture else None
            text = objfile.material_text(chosen, look.color, look.opacity, relative)
            atomic.write_text(self.folder / MESHES / f"{chosen}.mtl", text)
        return self._materials[look]

    def _picture(self, texture: "Texture") -> PurePosixPath | None:
        if texture not in self._pictures:
            try:
                data = picture_bytes(texture)
            except InputError as error:
                self.losses.append((texture.file, "skipped", error.message))
                self._pictures[texture] = None
            else:
                stem = Path(texture.file.rstrip("]")).stem
                self._pictures[texture] = self._write(TEXTURES, stem, ".png", data)
        return self._pictures[texture]

    def _write(
        self, place: PurePosixPath, stem: str, suffix: str, data: str | bytes
    ) -> PurePosixPath:
        content = data.encode() if isinstance(data, str) else data
        key = suffix, hashlib.sha256(content).digest()
        if key not in self._files:
            file = self._files[key] = place / f"{self._names.unique(stem)}{suffix}"
            atomic.write_bytes(self.folder / file, content)
        return self._files[key]


def picture_bytes(texture: "Texture") -> bytes:
    """A picture of base colour as an 8-bit sRGB PNG; one that is so already is kept as it is.

    Raises:
        InputError: It cannot be read.
    """
    from openrooms_usd.usd.shading.textures import local_file, picture_facts, read_texture

    plain = texture.scale == (1.0,) * 4 and texture.bias == (0.0,) * 4 and texture.channel == "rgb"
    facts = picture_facts(texture.file)
    eight_bits = facts.channels >= 3 and not facts.is_float
    if plain and eight_bits and texture.color_space == "sRGB":
        with local_file(texture.file) as file:
            if file.suffix.lower() == ".png":
                return file.read_bytes()
    return _encoded(_linear(read_texture(texture.file), texture))


def _linear(stored: np.ndarray, texture: "Texture") -> np.ndarray:
    """(H, W, 3) linear values of a picture as its texture takes them."""
    from openrooms_usd.usd.shading.surfaces import chosen, taken

    color = stored[..., :3] if stored.shape[2] >= 3 else np.repeat(stored[..., :1], 3, axis=2)
    if texture.color_space == "sRGB":
        color = linear_from_srgb(color)
    alpha = stored[..., -1:] if stored.shape[2] in (2, 4) else np.ones_like(stored[..., :1])
    rgba = np.concatenate([color, alpha], axis=2)[..., list(chosen(texture.channel, 3))]
    return rgba * taken(texture, texture.scale, 3) + taken(texture, texture.bias, 3)


def _encoded(linear: np.ndarray) -> bytes:
    from openrooms_usd.imagefile import write_png

    codes = np.round(srgb_from_linear(np.nan_to_num(linear)) * 255.0).astype(np.uint8)
    with scratch_folder() as folder:
        file = folder / "picture.png"
        write_png(file, codes)
        return file.read_bytes()
