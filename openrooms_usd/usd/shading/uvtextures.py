"""Reading UsdUVTexture, and the UsdTransform2d and UsdPrimvarReader that give its coordinates."""

import functools
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Final, cast

import numpy as np
from pxr import UsdShade

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.geometry.rotations import in_plan
from openrooms_usd.usd.files.strayed import MISSING, locate
from openrooms_usd.usd.shading import textures
from openrooms_usd.usd.shading.networks import Network
from openrooms_usd.usd.shading.surfaces import (
    BLACK,
    NORMAL_BIAS,
    NORMAL_SCALE,
    ColorSpace,
    Texture,
    UvTransform,
    Wrap,
)

_SINGLE: Final = ("r", "g", "b", "a")
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
    said = network.constant(node, "fallback", None) is not None
    texture = Texture(
        file=file,
        channel=output if output in _SINGLE else "rgb",
        color_space=_color_space(network, node, file),
        scale=network.vector(node, "scale", Texture.scale),
        bias=network.vector(node, "bias", Texture.bias),
        wrap_s=_WRAPS.get(str(network.constant(node, "wrapS", "")), "repeat"),
        wrap_t=_WRAPS.get(str(network.constant(node, "wrapT", "")), "repeat"),
        primvar=primvar,
        uv_scale=transform.scale,
        uv_rotation=transform.rotation,
        uv_translation=transform.translation,
        fallback=network.vector(node, "fallback", BLACK) if said else None,
    )
    return over_tiles(network, node, texture)


def over_tiles(network: Network, node: UsdShade.Shader, texture: Texture) -> Texture:
    """A texture of UDIM tiles as one of a single picture; any other as it is."""
    if not textures.is_udim(texture.file):
        return texture
    columns, rows = textures.grid(texture.file)
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


def picture_file(network: Network, node: UsdShade.Shader, name: str = "file") -> str | None:
    """The file of an image node; None, with a report, if none can be read."""
    asset = network.constant(node, name, None)
    authored = str(getattr(asset, "path", "") or "")
    if not authored:
        network.lost(node, name, "names no file")
        return None
    (attribute, *_) = UsdShade.Utils.GetValueProducingAttributes(node.GetInput(name))
    if textures.is_udim(authored):
        file = textures.resolved(attribute, authored)
        losses = ["" if file else f"{authored} {MISSING}"]
    else:
        file, lost = locate(attribute, asset)
        losses = [lost]
    losses.append(textures.flaw(file) if file else "")
    for loss in filter(None, losses):
        network.lost(node, name, loss)
    return file if file and not losses[-1] else None


def _color_space(network: Network, node: UsdShade.Shader, file: str) -> ColorSpace:
    space = str(network.constant(node, "sourceColorSpace", "auto"))
    if space in ("sRGB", "raw"):
        return cast(ColorSpace, space)
    if space != "auto":
        network.lost(node, "sourceColorSpace", f"{space} is unknown; auto is used")
    return textures.color_space(file)


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


def decomposed(network: Network, node: UsdShade.Shader, matrix: Array) -> UvTransform:
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


# Where a node of MaterialX looks its image up: a primvar, and an affine map of it.

_Matrix = Array
_Pair = tuple[float, float]
# The longest chain of nodes that is followed, so that a cycle ends.
# Larger numbers leave no texel apart from others.
_MOST: Final = 1e6
_NONE: Final[_Pair] = (0.0, 0.0)
_WHOLE: Final[_Pair] = (1.0, 1.0)


def family(kind: str) -> str:
    """What a node does, whatever its type: ``image`` of ``ND_image_color3``."""
    words = kind.removeprefix("ND_").split("_")
    return "_".join(words[: 2 if words[0] == "gltf" else 1])


def coordinates(network: Network, node: UsdShade.Shader) -> tuple[str, _Matrix]:
    """The primvar of an image node, and what is done to it.

    Returns:
        Its name, and (3, 3) for columns (s, t, 1); by default the first set of coordinates, as in
        MaterialX.
    """
    with np.errstate(all="ignore"):
        primvar, matrix = _followed(network, node)
    if np.abs(matrix).max() < _MOST:
        return primvar, matrix
    network.lost(node, "texcoord", "the transform of its coordinates is not affine; left out")
    return primvar, np.eye(3)


def _followed(network: Network, node: UsdShade.Shader) -> tuple[str, _Matrix]:
    matrix, name = np.eye(3), "texcoord"
    for _ in range(_MAX_CHAIN):
        source = network.source(node, name)
        if source.shader is None:
            break
        node, kind = source.shader, family(source.kind)
        if kind in _READERS:
            return _READERS[kind](network, node), matrix
        if kind not in _STEPS:
            network.lost(node, name, f"{source.kind or 'a shader'} cannot place a texture")
            break
        name, step = _STEPS[kind]
        matrix = matrix @ step(network, node)
    return names.ST, matrix


def _set_of(network: Network, node: UsdShade.Shader) -> str:
    index = int(network.number(node, "index", 0.0))
    return f"{names.ST}{index}" if index else names.ST


def _named(name: str) -> Callable[[Network, UsdShade.Shader], str]:
    return lambda network, node: str(network.constant(node, name, "") or names.ST)


def _affine(linear: _Matrix, offset: _Matrix) -> _Matrix:
    matrix = np.eye(3)
    matrix[:2, :2], matrix[:2, 2] = linear, offset
    return matrix


def _turned(degrees: float) -> _Matrix:
    # MaterialX turns coordinates clockwise, so that the picture goes the other way.
    return in_plan(-math.radians(degrees))


def _place(network: Network, node: UsdShade.Shader) -> _Matrix:
    pivot, offset = (np.array(_pair(network, node, name, _NONE)) for name in ("pivot", "offset"))
    by = np.diag(1.0 / _factors(network, node, "scale"))
    turn = _turned(network.number(node, "rotate", 0.0))
    if network.number(node, "operationorder", 0.0):
        linear = by @ turn
        return _affine(linear, pivot - linear @ (pivot + offset))
    linear = turn @ by
    return _affine(linear, pivot - offset - linear @ pivot)


def _pair(network: Network, node: UsdShade.Shader, name: str, default: _Pair) -> _Pair:
    """Two numbers, or one for both."""
    value = network.constant(node, name, None)
    if isinstance(value, float | int):
        return float(value), float(value)
    found: _Pair = network.vector(node, name, default)
    return found


def _factors(network: Network, node: UsdShade.Shader, name: str) -> _Matrix:
    """What is divided by, without zeros."""
    found = np.array(_pair(network, node, name, _WHOLE))
    if not found.all():
        network.lost(node, name, "a division by zero is left out")
    return np.where(found == 0.0, 1.0, found)


def _scaled(network: Network, node: UsdShade.Shader) -> _Matrix:
    return _affine(np.diag(_pair(network, node, "in2", _WHOLE)), np.zeros(2))


def _divided(network: Network, node: UsdShade.Shader) -> _Matrix:
    return _affine(np.diag(1.0 / _factors(network, node, "in2")), np.zeros(2))


def _moved(sign: float) -> Callable[[Network, UsdShade.Shader], _Matrix]:
    return lambda network, node: _affine(
        np.eye(2), sign * np.array(_pair(network, node, "in2", _NONE))
    )


def _rotated(network: Network, node: UsdShade.Shader) -> _Matrix:
    return _affine(_turned(network.number(node, "amount", 0.0)), np.zeros(2))


_READERS: Final[Mapping[str, Callable[[Network, UsdShade.Shader], str]]] = {
    "texcoord": _set_of,
    "geompropvalue": _named("geomprop"),
    "UsdPrimvarReader": _named("varname"),
}
# The input that a step passes on, and what it does.
_STEPS: Final[Mapping[str, tuple[str, Callable[[Network, UsdShade.Shader], _Matrix]]]] = {
    "place2d": ("texcoord", _place),
    "multiply": ("in1", _scaled),
    "divide": ("in1", _divided),
    "add": ("in1", _moved(1.0)),
    "subtract": ("in1", _moved(-1.0)),
    "rotate2d": ("in", _rotated),
    "UsdTransform2d": ("in", lambda network, node: transform_of(network, node).matrix),
}
