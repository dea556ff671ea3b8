"""Image nodes of MaterialX: file, colour space, wrapping, and where they lie on the surface."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.library.ownmaterials.mtlxtext import located
from openrooms_usd.usd.surfaces import (
    NORMAL_BIAS,
    NORMAL_SCALE,
    Channel,
    ColorSpace,
    Texture,
    UvTransform,
    Wrap,
)

_WRAPS: Final[dict[str, Wrap]] = {
    "periodic": "repeat", "clamp": "clamp", "mirror": "mirror", "constant": "black",
    "black": "black", "repeat": "repeat",
}  # fmt: skip
_ENCODED: Final = ("srgb_texture", "srgb", "sRGB")
_LINEAR: Final = ("lin_rec709", "lin_rec709_scene", "none", "raw", "data", "Raw")
# Close enough to sRGB that its decoding is taken; said, because it is not the same.
_NEARLY: Final = ("g22_rec709", "g18_rec709", "rec709_display", "gamma22", "srgb_displayp3")
_METRES: Final = {
    "nanometer": 1e-9, "micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "inch": 0.0254,
    "foot": 0.3048, "yard": 0.9144, "meter": 1.0, "kilometer": 1e3, "mile": 1609.344,
}  # fmt: skip
_ONE: Final = (1.0, 1.0)
_COORDINATES: Final = ("texcoord", "geompropvalue", "UsdPrimvarReader")


@dataclass
class Images:
    """Reads image nodes.

    Attributes:
        folder: The folder of the .mtlx.
        losses: Receives what is lost.
        constant: Reads an input that only a constant may drive: (node, name, default).
        missing: Receives a sentence for each file that is not there.
        size: Metres of one tile, where a node states them.
    """

    folder: Path
    losses: list[str]
    constant: Callable[[Any, str, Any], Any]
    missing: list[str] = field(default_factory=list)
    size: tuple[float, float] | None = None

    def texture(self, node: Any) -> Texture | None:
        """The texture of an image node; None where its file is missing or cannot be one file."""
        file = self._file(node)
        if file is None:
            return None
        place = self._placement(node)
        pair = (
            "wrapS wrapT" if node.getCategory() == "UsdUVTexture" else "uaddressmode vaddressmode"
        )
        wrap_s, wrap_t = (
            _WRAPS.get(str(self.constant(node, name, "periodic")), "repeat")
            for name in pair.split()
        )
        scale, bias = self._affine(node)
        kind = node.getType()
        channel: Channel = "r" if kind == "float" else "rgb"
        return Texture(
            str(file), channel, self._color_space(node), scale, bias, wrap_s, wrap_t,
            uv_scale=place.scale, uv_rotation=place.rotation, uv_translation=place.translation,
        )  # fmt: skip

    def _file(self, node: Any) -> Path | None:
        name = str(self.constant(node, "file", "") or "")
        where = node.getNamePath()
        if "<" in name or "{" in name:
            self.losses.append(f"{where}: {name}: tiles and frames are not read; left out")
            return None
        target = located(name, self.folder) if name else None
        if not name:
            self.missing.append(f"{where} names no file")
        elif target is None:
            self.missing.append(
                f"{where} names {name[:200]}, which lies outside the material's folder"
            )
        elif not target.is_file():
            self.missing.append(f"{where} names {name}, which is missing")
        else:
            untrusted.checked(target, "picture")
            return target.absolute()
        return None

    def _affine(self, node: Any) -> tuple[Any, Any]:
        """Scale and bias that the node itself applies."""
        kind = node.getCategory()
        if kind == "gltf_normalmap":
            return NORMAL_SCALE, NORMAL_BIAS
        name = {"gltf_image": "factor", "gltf_colorimage": "color"}.get(kind, "scale")
        if kind in ("image", "tiledimage"):
            return Texture.scale, Texture.bias
        scale = self.constant(node, name, Texture.scale)
        alpha = (scale * 4 if len(scale) == 1 else (*scale, 1.0))[:4]
        return alpha, self.constant(node, "bias", Texture.bias)

    def _color_space(self, node: Any) -> ColorSpace:
        if node.getType() not in ("color3", "color4", "multioutput"):
            return "raw"
        socket = node.getInput("file")
        stated = socket.getActiveColorSpace() if socket else ""
        if stated in _ENCODED:
            return "sRGB"
        if stated in _NEARLY:
            self.losses.append(f"{node.getName()}: colour space {stated} is taken as sRGB")
            return "sRGB"
        if stated not in _LINEAR:
            what = f"colour space {stated}" if stated else "a picture without colour space"
            self.losses.append(f"{node.getName()}: {what} is taken as linear Rec.709")
        return "raw"

    def _placement(self, node: Any) -> UvTransform:
        """From coordinates in tiles to those of the picture."""
        if node.getCategory().startswith("gltf_"):
            for name, default in (("scale", _ONE), ("rotate", (0.0,)), ("offset", (0.0, 0.0))):
                if self.constant(node, name, default) != default:
                    self.losses.append(f"{node.getName()}.{name}: left out")
        name = "st" if node.getCategory() == "UsdUVTexture" else "texcoord"
        return self._tiled(node, self._coordinates(node, name))

    def _tiled(self, node: Any, inner: UvTransform) -> UvTransform:
        """What tiledimage does: ``(st * uvtiling - uvoffset) / imagesize * tilesize``."""
        if node.getCategory() != "tiledimage":
            return inner
        tiling = np.array(self.constant(node, "uvtiling", _ONE)) * _ONE
        offset = np.array(self.constant(node, "uvoffset", (0.0, 0.0)))
        image, tile = (
            self._metres(node, "realworldimagesize"),
            self._metres(node, "realworldtilesize"),
        )
        if image is not None or tile is not None:
            self.size = tile or _ONE
        factor = np.array(tile or _ONE) / np.array(image or _ONE)
        return self._composed(node, tiling * factor, -offset * factor, inner)

    def _metres(self, node: Any, name: str) -> tuple[float, float] | None:
        given = self.constant(node, name, None)
        if given is None:
            return None
        unit = node.getInput(name).getUnit()
        s, t = (np.array(given) * _METRES.get(unit, 1.0) * _ONE).tolist()
        return (s, t) if s > 0 and t > 0 else None

    def _composed(self, node: Any, scale: Any, move: Any, inner: UvTransform) -> UvTransform:
        """Scale and move coordinates that have been transformed before."""
        if inner.rotation and scale[0] != scale[1]:
            self.losses.append(f"{node.getName()}: its placement skews the texture; not turned")
            inner = UvTransform(inner.scale, 0.0, inner.translation)
        s, t = (scale * inner.scale).tolist()
        x, y = (scale * inner.translation + move).tolist()
        return UvTransform((s, t), inner.rotation, (x, y))

    def _coordinates(self, node: Any, name: str) -> UvTransform:
        """The transform on the way from the texture coordinates to an input."""
        socket = node.getInput(name)
        source = socket.getConnectedNode() if socket is not None else None
        kind = source.getCategory() if source is not None else ""
        if source is None or kind in _COORDINATES:
            return UvTransform()
        if kind == "place2d":
            return self._place2d(source)
        self.losses.append(f"{source.getName()} ({kind}): its texture coordinates are left out")
        return UvTransform()

    def _place2d(self, node: Any) -> UvTransform:
        """``R (st - pivot) / scale - offset + pivot``, R clockwise by ``rotate`` degrees."""
        if self.constant(node, "operationorder", (0.0,)) != (0.0,):
            self.losses.append(f"{node.getName()}: its order of operations is left out")
        scale = np.array(self.constant(node, "scale", _ONE)) * _ONE
        pivot, offset = (np.array(self.constant(node, n, (0.0, 0.0))) for n in ("pivot", "offset"))
        (turn,) = self.constant(node, "rotate", (0.0,))
        s, t = (1.0 / np.where(scale == 0.0, 1.0, scale)).tolist()
        matrix = UvTransform((s, t), -turn).matrix[:2, :2]
        x, y = (pivot - offset - matrix @ pivot).tolist()
        return UvTransform((s, t), -turn + 0.0, (x, y))
