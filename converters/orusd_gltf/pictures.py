"""Textures as glTF wants them: encoded pictures whose channels stand where they are looked for.

A picture whose file already says it all goes in as it is; others are decoded, packed and encoded.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import imagefile, untrusted
from openrooms_usd.arrays import Bytes
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.errors import InputError
from openrooms_usd.rendering.scene.pictures import MAX_SIDE, Picture, load
from openrooms_usd.scratch import scratch_folder
from openrooms_usd.usd.shading.surfaces import NORMAL_BIAS, NORMAL_SCALE, Texture
from openrooms_usd.usd.shading.textures import PictureFacts, local_file, picture_facts
from orusd_gltf.document import Document, Object

Floats = NDArray[np.floating[Any]]

_UNIT: Final = (0.0, 1.0)
_POSITIVE: Final = (0.0, np.inf)
_DIRECTIONS: Final = (-1.0, 1.0)
_UNSCALED: Final = ((1.0, 1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 0.0))

# The first bytes of the formats that every glTF reader takes.
_SIGNATURES: Final = {b"\x89PNG\r\n\x1a\n": "image/png", b"\xff\xd8\xff": "image/jpeg"}
# Numbers of OpenGL: what lies beyond the edge, and how texels are mixed.
_WRAPS: Final = {"repeat": 10497, "clamp": 33071, "black": 33071, "mirror": 33648}
_LINEAR: Final = 9729
_LINEAR_MIPMAP_LINEAR: Final = 9987

# How a picture is written: its ending, its type, and the writer's options for colours and for data.
_FORMATS: Final[dict[str, tuple[str, str, Object]]] = {
    "png": (".png", "image/png", {"png:compressionLevel": 6}),
    "jpeg": (".jpg", "image/jpeg", {"Compression": "jpeg:90"}),
    "webp": (".webp", "image/webp", {"Compression": "webp:90"}),
}


@dataclass(frozen=True)
class PlacedTexture:
    """A texture of the document and the factors that it is multiplied by."""

    number: int
    factor: tuple[float, ...] = (1.0, 1.0, 1.0)
    losses: tuple[str, ...] = ()


@dataclass
class Pictures:
    """Makes the textures of a document.

    Attributes:
        document: Receives them.
        form: ``png`` keeps PNG and JPEG files as they are and writes the rest as PNG; ``jpeg`` and
            ``webp`` write pictures so, but for transparent ones as JPEG.
    """

    document: Document
    form: str = "png"
    _files: dict[str, "_File"] = field(default_factory=dict)
    _made: dict[Any, PlacedTexture] = field(default_factory=dict)

    def base_color(
        self, color: Texture | tuple[float, ...], opacity: Texture | None
    ) -> PlacedTexture:
        """Colour in sRGB, and opacity in alpha where there is a texture of it."""
        return self._once((color, opacity), lambda: self._base_color(color, opacity))

    def metallic_roughness(
        self, metallic: Texture | float, roughness: Texture | float, occlusion: Texture | None
    ) -> PlacedTexture:
        """Roughness in green, metallic in blue, occlusion in red; factors of these three."""
        key = (metallic, roughness, occlusion, "packed")
        return self._once(key, lambda: self._metallic_roughness(metallic, roughness, occlusion))

    def normal(self, texture: Texture) -> PlacedTexture:
        """A tangent-space normal map; its factor is the scale of x and y."""
        return self._once((texture, "normal"), lambda: self._normal(texture))

    def emission(self, texture: Texture) -> PlacedTexture:
        """Radiance in sRGB, relative to the greatest; the factor is that, nits."""
        return self._once((texture, "emission"), lambda: self._emission(texture))

    def _once(self, key: Any, make: Any) -> PlacedTexture:
        if key not in self._made:
            self._made[key] = make()
        return self._made[key]

    def _base_color(
        self, color: Texture | tuple[float, ...], opacity: Texture | None
    ) -> PlacedTexture:
        alone = opacity is None or (isinstance(color, Texture) and _is_alpha(opacity, color))
        if alone and isinstance(color, Texture) and self._keeps(color, "sRGB"):
            return self._kept(color, color.scale[:3])
        channels = [_picture(color, 3), _picture(opacity if opacity is not None else 1.0, 1)]
        rgb, alpha = _at_one_size(channels)
        parts = [srgb_from_linear(rgb)] + ([alpha] if opacity is not None else [])
        sources = [source for source in (color, opacity) if isinstance(source, Texture)]
        return self._written(np.concatenate(parts, axis=2), sources[0], channels)

    def _metallic_roughness(
        self, metallic: Texture | float, roughness: Texture | float, occlusion: Texture | None
    ) -> PlacedTexture:
        textures = [t for t in (roughness, metallic, occlusion) if isinstance(t, Texture)]
        if self._is_packed(metallic, roughness, occlusion):
            # Metallic is 0 where it has no texture.
            factors = (1.0, 1.0, 1.0 if isinstance(metallic, Texture) else 0.0)
            return self._kept(textures[0], factors)
        pictures = [
            _picture(1.0 if source is None else source, 1)
            for source in (occlusion, roughness, metallic)
        ]
        packed = np.concatenate(_at_one_size(pictures), axis=2)
        return self._written(packed, textures[0], pictures)

    def _is_packed(
        self, metallic: Texture | float, roughness: Texture | float, occlusion: Texture | None
    ) -> bool:
        """Whether one file holds all of them where they are looked for."""
        wanted = zip((occlusion, roughness, metallic), "rgb", strict=True)
        textures = [(t, channel) for t, channel in wanted if isinstance(t, Texture)]
        first = textures[0][0]
        # What is constant is multiplied by what is in its channel: only zero stays as it is.
        whole = isinstance(metallic, Texture) or metallic == 0.0
        whole = whole and isinstance(roughness, Texture)
        if not whole or any(t.file != first.file or t.wrap_s != first.wrap_s for t, _ in textures):
            return False
        if not all(self._keeps(t, "raw") and (t.scale, t.bias) == _UNSCALED for t, _ in textures):
            return False
        grey = self._file(first).facts.channels <= 2
        return all(t.channel == channel or (grey and t.channel != "a") for t, channel in textures)

    def _normal(self, texture: Texture) -> PlacedTexture:
        (x, y, z, _), bias = texture.scale, texture.bias
        mirrored = (-x / 2.0, -y / 2.0, -z / 2.0) == bias[:3]
        if self._keeps(texture, "raw", scaled=True) and x == y and z == 2.0 and mirrored:
            return self._kept(texture, (x / 2.0,))
        if (texture.scale, texture.bias) == _UNSCALED and self._keeps(texture, "raw", scaled=True):
            texture = replace(texture, scale=NORMAL_SCALE, bias=NORMAL_BIAS)
        picture = _loaded(texture, 3, _DIRECTIONS)
        return self._written((picture.pixels[::-1] + 1.0) / 2.0, texture, [picture])

    def _emission(self, texture: Texture) -> PlacedTexture:
        picture = _loaded(texture, 3, _POSITIVE)
        pixels = picture.pixels[::-1].astype(np.float32)
        most = float(pixels.max(initial=0.0)) or 1.0
        placed = self._written(srgb_from_linear(pixels / most), texture, [picture])
        return PlacedTexture(placed.number, (most,) * 3, placed.losses)

    # Files that are kept.

    def _keeps(self, texture: Texture, space: str, *, scaled: bool = False) -> bool:
        """Whether a texture's file can stand for it, but for a factor of at most one."""
        file = self._file(texture)
        if not file.mime or (self.form != "png" and file.mime != f"image/{self.form}"):
            return False
        if texture.color_space != space or max(file.facts.width, file.facts.height) > MAX_SIDE:
            return False
        if (space == "sRGB" and texture.channel != "rgb") or texture.is_shuffled:
            return False
        return scaled or (
            texture.bias == _UNSCALED[1] and 0.0 <= min(texture.scale) <= max(texture.scale) <= 1.0
        )

    def _file(self, texture: Texture) -> "_File":
        return self._files.setdefault(texture.file, _File(texture.file))

    def _kept(self, texture: Texture, factor: tuple[float, ...]) -> PlacedTexture:
        file = self._file(texture)
        number = self.document.texture(file.data, file.mime, _sampler(texture))
        return PlacedTexture(number, factor, _wrap_losses(texture))

    # Pictures that are written.

    def _written(
        self, values: Floats, texture: Texture, sources: Sequence[Picture]
    ) -> PlacedTexture:
        codes = np.round(np.clip(values, 0.0, 1.0).astype(np.float32) * 255.0).astype(np.uint8)
        form = "png" if self.form == "jpeg" and codes.shape[2] == 4 else self.form
        data, mime = encoded(codes, form)
        losses = dict.fromkeys(loss for picture in sources for loss in picture.losses)
        losses |= dict.fromkeys(_wrap_losses(texture))
        return PlacedTexture(
            self.document.texture(data, mime, _sampler(texture)), losses=tuple(losses)
        )


def encoded(codes: Bytes, form: str) -> tuple[bytes, str]:
    """A picture's file and its type.

    Args:
        codes: (H, W, 3 or 4), the first row on top.
        form: ``png``, ``jpeg`` or ``webp``.
    """
    ending, mime, told = _FORMATS[form]
    # The writer must not divide colours by alpha.
    told = told | {"DateTime": "", "oiio:UnassociatedAlpha": 1}
    with scratch_folder() as folder:
        path = folder / f"picture{ending}"
        imagefile.write(path, codes, "uint8", told)
        return path.read_bytes(), mime


@dataclass(frozen=True)
class _File:
    """A picture's file: its bytes and header, once they are asked for."""

    path: str

    @cached_property
    def data(self) -> bytes:
        with local_file(self.path) as file:
            return untrusted.read_bytes(file, "picture")

    @cached_property
    def facts(self) -> PictureFacts:
        return picture_facts(self.path)

    @cached_property
    def mime(self) -> str:
        """Its type, where every reader of glTF takes the file as it is; else nothing."""
        try:
            if self.facts.is_float:
                return ""
            found = (m for start, m in _SIGNATURES.items() if self.data.startswith(start))
            return next(found, "")
        except InputError:
            return ""


def _is_alpha(opacity: Texture, color: Texture) -> bool:
    """Whether opacity is the alpha of a colour's own file."""
    same = replace(opacity, channel="rgb", color_space=color.color_space, fallback=color.fallback)
    return opacity.channel == "a" and same == color and color.scale[3] == 1.0


def _picture(source: Texture | float | tuple[float, ...], channels: int) -> Picture:
    if isinstance(source, Texture):
        return _loaded(source, channels, _UNIT)
    values = np.clip(np.array(source, np.float32), 0.0, 1.0)
    return Picture(np.broadcast_to(values, (1, 1, channels)))


def _loaded(texture: Texture, channels: int, limits: tuple[float, float]) -> Picture:
    """The pixels alone: samplers say how pictures go on beyond them."""
    return load(replace(texture, wrap_s="repeat", wrap_t="repeat"), channels, limits, np.eye(3))


def _at_one_size(pictures: Sequence[Picture]) -> list[Floats]:
    """The pixels of several pictures at the size of the largest, the first row on top."""
    height, width = np.max([picture.texels.shape[:2] for picture in pictures], axis=0)
    rows, columns = (np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width
    st = np.stack(np.meshgrid(columns, rows), axis=-1)
    return [
        (p.pixels if p.texels.shape[:2] == (height, width) else p.lookup(st))[::-1]
        for p in pictures
    ]


def _sampler(texture: Texture) -> Object:
    return {
        "magFilter": _LINEAR,
        "minFilter": _LINEAR_MIPMAP_LINEAR,
        "wrapS": _WRAPS[texture.wrap_s],
        "wrapT": _WRAPS[texture.wrap_t],
    }


def _wrap_losses(texture: Texture) -> tuple[str, ...]:
    if "black" in (texture.wrap_s, texture.wrap_t):
        return (f"{texture.file}: black beyond its edge is taken as clamp",)
    return ()
