"""Surfaces that show their light as it is, by KHR_materials_unlit."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.rendering.scene.surfaces import SurfaceReader, mean_luminance
from openrooms_usd.usd.shading.surfaces import PreviewSurface, Texture
from openrooms_usd.usd.shapes.meshes import PlacedMesh
from orusd_gltf.baked import BakedLight
from orusd_gltf.document import Document, Object, numbers
from orusd_gltf.geometry import Coordinates, Vertices, vertices
from orusd_gltf.materials import ReadMaterial, Rows
from orusd_gltf.pictures import encoded

EXTENSION: Final = "KHR_materials_unlit"

NO_GLOSS: Final = "its gloss is left out, and its relief where the light does not know it"
UNSEEN: Final = "its light is in the surfaces; it is not visible itself"
NO_MAP: Final = "it has no lightmap: shown in its mean colour"

# The name of the texture coordinates of lightmaps among those of a mesh.
_PLACES: Final = Coordinates("lightmap")
# What clear glass is blended with.
_GLASS_ALPHA: Final = 0.1
_CLAMP: Final = {"magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071}

_Part = tuple[Rows, ReadMaterial]


@dataclass
class UnlitSurfaces:
    """Paints the pictures of lightmaps, then gives meshes their primitives.

    Attributes:
        document: Receives materials and textures.
        light: The lightmaps.
        form: ``webp``, or else pictures are JPEG.
    """

    document: Document
    light: BakedLight
    form: str
    _reader: SurfaceReader = field(default_factory=SurfaceReader)
    _textures: dict[str, int] = field(default_factory=dict)

    def paint(self, mesh: PlacedMesh, parts: Iterable[_Part]) -> None:
        """Add a mesh's colours to the picture of its lightmap, where it has one."""
        placed = self.light.places(mesh)
        if placed is None:
            return
        name, places = placed
        for rows, look in parts:
            surface = self._reader.read(look.preview)
            st = mesh.mesh.uvs.get(surface.primvar, mesh.mesh.st)
            assert st is not None
            turned = st[rows] @ surface.uv[:2, :2].T + surface.uv[:2, 2]
            self.light.atlases[name].paint(places[rows], turned, surface)

    def finish(self) -> None:
        """Make the textures; what is painted later is not seen."""
        form = "webp" if self.form == "webp" else "jpeg"
        for name, codes in self.light.pictures().items():
            self._textures[name] = self.document.texture(*encoded(codes, form), _CLAMP)

    def primitives(
        self, mesh: PlacedMesh, parts: Iterable[_Part], radiance: tuple[float, ...] | None
    ) -> tuple[list[tuple[Vertices, int]], str]:
        """What to draw of a mesh, each with its material, and what was lost in words."""
        placed = self.light.places(mesh)
        if placed is not None and radiance is None:
            name, places = placed
            lit = replace(mesh.mesh, uvs={_PLACES.primvar: places.astype(np.float32)})
            number = self._material(mesh, {"baseColorTexture": {"index": self._textures[name]}})
            return [(vertices(lit, np.arange(len(places), dtype=np.int32), [_PLACES]), number)], ""
        drawn = []
        for rows, look in parts:
            base, alpha = self._plain(look.preview, radiance)
            drawn.append((vertices(mesh.mesh, rows, []), self._material(mesh, base, alpha)))
        return drawn, "" if radiance is not None else NO_MAP

    def _plain(
        self, preview: PreviewSurface, radiance: tuple[float, ...] | None
    ) -> tuple[Object, float]:
        """The colour of what has no lightmap, and its alpha."""
        emitted = radiance or (() if isinstance(preview.emissive, Texture) else preview.emissive)
        if any(emitted):
            codes = self.light.shown(np.array(emitted, np.float32))
            return {"baseColorFactor": numbers([*linear_from_srgb(codes / 255.0), 1.0])}, 1.0
        grey = mean_luminance(self._reader.read(preview).base_color)
        clear = isinstance(preview.opacity, Texture) or preview.opacity < 1.0
        alpha = _GLASS_ALPHA if clear else 1.0
        return {"baseColorFactor": numbers([grey, grey, grey, alpha])}, alpha

    def _material(self, mesh: PlacedMesh, base: Object, alpha: float = 1.0) -> int:
        self.document.use(EXTENSION)
        base |= {"metallicFactor": 0.0, "roughnessFactor": 0.9}
        said: Object = {"pbrMetallicRoughness": base, "extensions": {EXTENSION: {}}}
        said |= {"alphaMode": "BLEND"} if alpha < 1.0 else {}
        said |= {"doubleSided": True} if mesh.double_sided else {}
        return self.document.shared("materials", said)
