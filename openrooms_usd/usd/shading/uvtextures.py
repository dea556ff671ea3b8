"""Reading UsdUVTexture, and the UsdTransform2d and UsdPrimvarReader that give its coordinates."""

import functools
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Final, cast

import numpy as np
from numpy.typing import NDArray
from pxr import UsdShade

from openrooms_usd import names
from openrooms_usd.errors import InputError
from openrooms_usd.usd.shading import textures, udim
from openrooms_usd.usd.shading.networks import Network
from openrooms_usd.usd.shading.surfaces import (
    NORMAL_BIAS,
    NORMAL_SCALE,
    Channel,
    ColorSpace,
    Texture,
    UvTransform,
    Wrap,
)

_CHANNELS: Final[dict[str, Channel]] = {"r": "r", "g": "g", "b": "b", "a": "a"}
# useMetadata asks the picture's file, which hardly ever says anything but "repeat".
_WRAPS: Final[dict[str, Wrap]] = {"clamp": "clamp", "mirror": "mirror", "black": "black"}
# The longest chain of transforms that is followed, so that a cycle ends.
_MAX_CHAIN: Final = 16


def read_texture_node(network: Network, node: UsdShade.Shader, output: str) -> Texture | None:
    """Read a UsdUVTexture.

    Args:
        network: Receives what is lost.
        node: The UsdUVTexture.
        output: Which of its outputs is used: rgb, r, g, b or a.

    Returns:
        The texture, or None when its file is missing.
    """
    file = picture_file(network, node)
    if file is None:
        return None
    primvar, transform = _coordinates(network, node)
    texture = Texture(
        file=file,
        channel=_CHANNELS.get(output, "rgb"),
        color_space=_color_space(network, node, file),
        scale=network.vector(node, "scale", Texture.scale),
        bias=network.vector(node, "bias", Texture.bias),
        wrap_s=_WRAPS.get(str(network.constant(node, "wrapS", "")), "repeat"),
        wrap_t=_WRAPS.get(str(network.constant(node, "wrapT", "")), "repeat"),
        primvar=primvar,
        uv_scale=transform.scale,
        uv_rotation=transform.rotation,
        uv_translation=transform.translation,
        fallback=network.vector(node, "fallback", Texture.fallback),
    )
    return over_tiles(network, node, texture)


def over_tiles(network: Network, node: UsdShade.Shader, texture: Texture) -> Texture:
    """A texture of UDIM tiles as one of a single picture; any other as it is."""
    if not udim.is_udim(texture.file):
        return texture
    columns, rows = udim.grid(texture.file)
    squeezed = np.diag([1.0 / columns, 1.0 / rows, 1.0]) @ texture.uv_matrix
    where = decomposed(network, node, squeezed)
    return replace(
        texture,
        wrap_s="clamp",
        wrap_t="clamp",
        uv_scale=where.scale,
        uv_rotation=where.rotation,
        uv_translation=where.translation,
    )


def mended_normal_map(network: Network, texture: Texture) -> Texture:
    """Mend the two usual mistakes with normal maps: decoded as sRGB, and not unpacked."""
    if texture.color_space == "sRGB":
        network.losses.append(f"{texture.file}: a normal map is never sRGB; read as raw")
    packed = (texture.scale, texture.bias) == (Texture.scale, Texture.bias)
    if not packed or texture.file.lower().rstrip("]").endswith((".exr", ".hdr")):
        return replace(texture, color_space="raw")
    network.losses.append(f"{texture.file}: a normal map without scale 2 and bias -1; added")
    return replace(texture, color_space="raw", scale=NORMAL_SCALE, bias=NORMAL_BIAS)


def picture_file(network: Network, node: UsdShade.Shader) -> str | None:
    """Where the picture of an image node lies; None where it is missing, which is told."""
    asset = network.constant(node, "file", None)
    authored = str(getattr(asset, "path", "") or "")
    resolved = str(getattr(asset, "resolvedPath", "") or "")
    if udim.is_udim(authored):
        (attribute, *_) = UsdShade.Utils.GetValueProducingAttributes(node.GetInput("file"))
        resolved = udim.resolved(attribute, authored)
    if not resolved:
        network.lost(node, "file", f"{authored} is missing" if authored else "names no file")
    else:
        return resolved
    return None


def _color_space(network: Network, node: UsdShade.Shader, file: str) -> ColorSpace:
    space = str(network.constant(node, "sourceColorSpace", "auto"))
    if space in ("sRGB", "raw"):
        return cast(ColorSpace, space)
    if space != "auto":
        network.lost(node, "sourceColorSpace", f"{space} is unknown; taken as auto")
    return usual_color_space(network, node, file)


def usual_color_space(network: Network, node: UsdShade.Shader, file: str) -> ColorSpace:
    """The colour space of a picture of which nobody says any."""
    try:
        return textures.color_space(file)
    except InputError as error:
        network.lost(node, "file", error.message)
        return "raw"


def _coordinates(network: Network, node: UsdShade.Shader) -> tuple[str, UvTransform]:
    """The primvar of a texture, and the transforms on the way from it."""
    transforms: list[UvTransform] = []
    primvar = ""
    for kind, shader in _chain(network, node):
        if kind == "UsdTransform2d":
            transforms.append(transform_of(network, shader))
        elif kind.startswith("UsdPrimvarReader"):
            primvar = str(network.constant(shader, "varname", "") or "")
            break
        elif kind.startswith("geompropvalue"):
            primvar = str(network.constant(shader, "geomprop", "") or "")
            break
        else:
            network.lost(node, "st", f"{kind or 'a shader'} cannot drive it")
            break
    if not primvar:
        network.lost(node, "st", f"no texture coordinates; {names.ST} is assumed")
    return primvar or names.ST, _combined(network, node, transforms)


def _chain(network: Network, node: UsdShade.Shader) -> Iterator[tuple[str, UsdShade.Shader]]:
    """The shaders that feed a texture's coordinates, the last one first."""
    source = network.source(node, "st")
    for _ in range(_MAX_CHAIN):
        if source.shader is None:
            return
        yield source.kind.removeprefix("ND_"), source.shader
        source = network.source(source.shader, "in")


def transform_of(network: Network, shader: UsdShade.Shader) -> UvTransform:
    """What a UsdTransform2d says."""
    return UvTransform(
        scale=network.vector(shader, "scale", UvTransform.scale),
        rotation=network.number(shader, "rotation", UvTransform.rotation),
        translation=network.vector(shader, "translation", UvTransform.translation),
    )


def _combined(
    network: Network, node: UsdShade.Shader, transforms: list[UvTransform]
) -> UvTransform:
    """One transform that does what several do, the last applied standing first."""
    if len(transforms) < 2:
        return transforms[0] if transforms else UvTransform()
    matrix = functools.reduce(np.matmul, (transform.matrix for transform in transforms))
    return decomposed(network, node, matrix)


def decomposed(network: Network, node: UsdShade.Shader, matrix: NDArray[np.float64]) -> UvTransform:
    """The transform of a (3, 3) matrix for columns (s, t, 1); its skew is left out, and told."""
    (a, b), (c, d) = matrix[:2, :2]
    angle = math.atan2(c, a)
    cos, sin = math.cos(angle), math.sin(angle)
    found = UvTransform(
        scale=(float(a * cos + c * sin), float(d * cos - b * sin)),
        rotation=math.degrees(angle),
        translation=(float(matrix[0, 2]), float(matrix[1, 2])),
    )
    if not np.allclose(found.matrix, matrix, atol=1e-6 * np.abs(matrix).max()):
        network.lost(node, "st", "its transforms skew the texture; the skew is left out")
    return found
