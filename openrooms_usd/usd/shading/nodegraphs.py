"""Nodes of MaterialX before an input, folded into a constant or one texture.

Affine operations on a texture go into its scale and bias, as MaterialX 1.39 defines its standard
nodes. All others are reported and left out.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, cast

import numpy as np
from pxr import UsdShade

from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.usd.shading import uvtextures
from openrooms_usd.usd.shading.networks import Network, finite_numbers
from openrooms_usd.usd.shading.surfaces import ColorSpace, Texture, Wrap
from openrooms_usd.usd.shading.textures import color_space

Numbers = tuple[float, ...]
Folded = Numbers | Texture

_SRGB: Final = ("srgb_texture", "sRGB", "srgb", "srgb_rec709_scene", "sRGB - Texture")
_RAW: Final = ("raw", "Raw", "data", "none")
_LINEAR: Final = (*_RAW, "linear", "lin_rec709", "lin_rec709_scene", "lin_srgb")
_WRAPS: Final[Mapping[str, Wrap]] = {"clamp": "clamp", "mirror": "mirror", "constant": "black"}
_PARTS: Final[Mapping[str, int]] = dict(zip("rgbaxyzw", (0, 1, 2, 3) * 2, strict=True))
_DIGITS: Final[Mapping[str, Numbers]] = {"0": (0.0,), "1": (1.0,)}
_NIL: Final[Numbers] = (0.0,)
_WHOLE: Final[Numbers] = (1.0,)
_MOST: Final = 1e30
# The longest chain of nodes that is followed, so that a cycle ends.
_DEEPEST: Final = 16


@dataclass(frozen=True)
class _Node:
    """A shader whose output is asked for."""

    network: Network
    shader: UsdShade.Shader
    kind: str
    output: str
    depth: int

    def fold(self, name: str, default: Numbers | None = None) -> Folded | None:
        found = _fold(self.network, self.shader, name, self.depth)
        return default if found is None else found

    def numbers(self, name: str, default: Numbers) -> Numbers:
        found = self.fold(name)
        if isinstance(found, Texture):
            self.lost(name, "a texture cannot drive it")
            return default
        return found or default

    def lost(self, name: str, what: str) -> None:
        self.network.lost(self.shader, name, what)


def fold(network: Network, shader: UsdShade.Shader, name: str) -> Folded | None:
    """What an input is, all nodes before it worked in.

    Args:
        network: Receives what is lost.
        shader: Whose input it is.
        name: The input's name.

    Returns:
        The numbers of a constant, a texture, or None if nothing known is authored.
    """
    # What is too large is cut to numbers that a product still holds.
    with np.errstate(all="ignore"):
        return _fold(network, shader, name, _DEEPEST)


def _fold(network: Network, shader: UsdShade.Shader, name: str, depth: int) -> Folded | None:
    source = network.source(shader, name)
    if source.shader is None:
        return _linear(finite_numbers(source.constant), source.space)
    rule = _RULES.get(uvtextures.family(source.kind))
    if rule is None or depth == 0:
        network.lost(shader, name, f"{source.kind or 'a shader'} cannot drive it")
        return None
    return rule(_Node(network, source.shader, source.kind, source.output, depth - 1))


def _linear(numbers: Numbers, space: str) -> Numbers | None:
    if space in _SRGB and len(numbers) >= 3:
        decoded = linear_from_srgb(np.array(numbers[:3], dtype=np.float64)).tolist()
        return (*decoded, *numbers[3:])
    return _bounded(np.array(numbers)) or None


def _bounded(numbers: Array) -> Numbers:
    return tuple(np.clip(np.nan_to_num(numbers), -_MOST, _MOST).tolist())


def affine(value: Folded, factor: Numbers, offset: Numbers = (0.0,)) -> Folded:
    """``value * factor + offset``; one number goes for all channels.

    Args:
        value: A constant or a texture.
        factor: Of each channel.
        offset: Of each channel.
    """
    if not isinstance(value, Texture):
        many = max(len(value), len(factor), len(offset))
        a, b, c = (_widened(numbers, many, numbers[-1]) for numbers in (value, factor, offset))
        return _bounded(a * b + c)
    by, plus = _widened(factor, 4, 1.0), _widened(offset, 4, 0.0)
    if len(value.channel) == 1:
        if np.ptp(by[:3]) or np.ptp(plus[:3]):
            # A number that is tinted is a colour.
            value = _side_by_side([value] * 3)
        else:
            by, plus = np.full(4, by[0]), np.full(4, plus[0])
    return _with_numbers(value, lambda numbers, share: np.array(numbers) * by + share * plus)


def _with_numbers(
    value: Texture, become: Callable[[Numbers, float], Sequence[float] | Array]
) -> Texture:
    """A texture with other numbers: a function of each kind, and of its share of an offset."""
    made = {"scale": become(value.scale, 0.0), "bias": become(value.bias, 1.0)}
    if value.fallback is not None:
        made["fallback"] = become(value.fallback, 1.0)
    bounded = {name: _bounded(np.array(numbers)) for name, numbers in made.items()}
    return replace(value, **cast(Any, bounded))


def part_of(value: Texture, index: int) -> Texture:
    """One channel of a texture; a single one itself."""
    if len(value.channel) == 1 or not 0 <= index < 4:
        return value
    name = f"{value.channel}a"[index]
    if value.is_shuffled:
        place = "rgba".index(name)
        value = _with_numbers(
            value, lambda numbers, _: (*numbers[:place], numbers[index], *numbers[place + 1 :])
        )
    return replace(value, channel=name)


def _side_by_side(parts: Sequence[Texture]) -> Texture:
    """Three single channels of one picture as a colour."""
    places = ["rgba".index(part.channel) for part in parts]
    kinds = {
        name: [getattr(part, name) for part in parts] for name in ("scale", "bias", "fallback")
    }
    made = {
        name: (*(numbers[place] for numbers, place in zip(found, places, strict=True)), found[0][3])
        for name, found in kinds.items()
        if None not in found
    }
    return replace(parts[0], channel="".join(part.channel for part in parts), **cast(Any, made))


def _widened(numbers: Numbers, many: int, rest: float) -> Array:
    """As many numbers; one alone stands for all."""
    if len(numbers) == 1:
        return np.full(many, numbers[0])
    return np.array([*numbers, *[rest] * many][:many], dtype=np.float64)


def product(first: Folded, second: Folded) -> Folded | None:
    """One times the other; None of two textures."""
    if not isinstance(second, Texture):
        return affine(first, second)
    return None if isinstance(first, Texture) else affine(second, first)


def _multiply(node: _Node) -> Folded | None:
    first, second = node.fold("in1", (0.0,)), node.fold("in2", (1.0,))
    assert first is not None and second is not None
    return _alone(node, product(first, second), first)


def _divide(node: _Node) -> Folded | None:
    first, by = node.fold("in1", (0.0,)), node.numbers("in2", (1.0,))
    assert first is not None
    if 0.0 in by:
        node.lost("in2", "a division by zero is left out")
        return first
    return affine(first, _bounded(1.0 / np.array(by)))


def _sum(sign: float) -> "Callable[[_Node], Folded | None]":
    def added(node: _Node) -> Folded | None:
        first, second = node.fold("in1", (0.0,)), node.fold("in2", (0.0,))
        assert first is not None and second is not None
        if not isinstance(second, Texture):
            return affine(first, (1.0,), tuple(sign * number for number in second))
        whole = None if isinstance(first, Texture) else affine(second, (sign,), first)
        return _alone(node, whole, first)

    return added


def _mix(node: _Node) -> Folded | None:
    fore, back = node.fold("fg", (0.0,)), node.fold("bg", (0.0,))
    share = node.numbers("mix", (0.0,))
    assert fore is not None and back is not None
    rest = tuple(1.0 - number for number in share)
    if set(share) in ({0.0}, {1.0}):
        return fore if share[0] else back
    for texture, other, by, left in ((fore, back, share, rest), (back, fore, rest, share)):
        if not isinstance(other, Texture):
            return affine(texture, by, cast(Numbers, affine(other, left)))
    return _alone(node, None, fore)


def _alone(node: _Node, whole: Folded | None, first: Folded) -> Folded:
    """The whole, or the first of two textures where both would be needed."""
    if whole is None:
        node.lost("in2", f"{node.kind} of two textures is replaced by the first")
    return first if whole is None else whole


def _invert(node: _Node) -> Folded | None:
    value = node.fold("in")
    return None if value is None else affine(value, (-1.0,), node.numbers("amount", (1.0,)))


def _remap(node: _Node) -> Folded | None:
    value = node.fold("in")
    low, high, start, end = (
        _widened(node.numbers(name, (default,)), 4, default)
        for name, default in (("inlow", 0.0), ("inhigh", 1.0), ("outlow", 0.0), ("outhigh", 1.0))
    )
    if value is None or not np.all(high - low):
        return value
    factor = (end - start) / (high - low)
    return affine(value, _bounded(factor), _bounded(start - low * factor))


def _clamp(node: _Node) -> Folded | None:
    value = node.fold("in")
    if value is None or isinstance(value, Texture):
        # What an input takes has limits of its own.
        return value
    low, high = (
        _widened(node.numbers(name, default), len(value), default[0])
        for name, default in (("low", _NIL), ("high", _WHOLE))
    )
    return _bounded(np.clip(value, low, high))


def _extract(node: _Node) -> Folded | None:
    return _part(node.fold("in"), int(node.numbers("index", (0.0,))[0]))


def _separate(node: _Node) -> Folded | None:
    return _part(node.fold("in"), _PARTS.get(node.output.removeprefix("out"), 0))


def _swizzle(node: _Node) -> Folded | None:
    channels = str(node.network.constant(node.shader, "channels", ""))
    value = node.fold("in")
    if value is None or not channels or not set(channels) <= {*_PARTS, *_DIGITS}:
        node.lost("channels", f"{channels!r} are not supported; the value is used unchanged")
        return value
    parts = [_DIGITS.get(name) or _part(value, _PARTS.get(name, 0)) for name in channels]
    return _together(node, parts)


def _part(value: Folded | None, index: int) -> Folded | None:
    """One channel; of a number itself."""
    if isinstance(value, Texture):
        return part_of(value, index)
    return (value[min(max(index, 0), len(value) - 1)],) if value else None


def _combine(node: _Node) -> Folded | None:
    many = int(uvtextures.family(node.kind)[-1])
    return _together(node, [node.fold(f"in{number}", _NIL) for number in range(1, many + 1)])


def _together(node: _Node, parts: Sequence[Folded | None]) -> Folded | None:
    """Numbers side by side, or channels of one texture: of more than three the first three."""
    textures = [part for part in parts if isinstance(part, Texture)]
    if not textures:
        return tuple(part[0] for part in parts if isinstance(part, tuple))
    first = textures[0]
    if len(parts) == 1:
        return first
    # Alpha says nothing to a colour.
    kept = [part_of(part, 0) for part in parts[:3] if isinstance(part, Texture)]
    if len(kept) == 3 and len({_picture_of(part) for part in kept}) == 1:
        return _side_by_side(kept)
    node.lost("in", "no single picture holds its channels; those of the first are used")
    return replace(first, channel="rgb")


def _picture_of(value: Texture) -> Texture:
    return replace(value, channel="r", scale=Texture.scale, bias=Texture.bias, fallback=None)


def _normal_map(node: _Node) -> Folded | None:
    value, strength = node.fold("in"), node.numbers("scale", (1.0,))
    if not isinstance(value, Texture):
        return None
    s, t = strength[0], strength[-1]
    return affine(value, (2.0 * s, 2.0 * t, 2.0, 1.0), (-s, -t, -1.0, 0.0))


def _image(node: _Node) -> Folded | None:
    file = uvtextures.picture_file(node.network, node.shader)
    if file is None:
        return node.fold("default", (0.0,))
    primvar, matrix = uvtextures.coordinates(node.network, node.shader)
    where = uvtextures.decomposed(node.network, node.shader, _tiling(node) @ matrix)
    constant = node.network.constant
    texture = Texture(
        file,
        "r" if node.kind.endswith("_float") else "rgb",
        _space(node, file),
        wrap_s=_WRAPS.get(str(constant(node.shader, "uaddressmode", "")), "repeat"),
        wrap_t=_WRAPS.get(str(constant(node.shader, "vaddressmode", "")), "repeat"),
        primvar=primvar,
        uv_scale=where.scale,
        uv_rotation=where.rotation,
        uv_translation=where.translation,
        fallback=cast(Any, tuple(_widened(node.numbers("default", (0.0,)), 4, 1.0).tolist())),
    )
    return uvtextures.over_tiles(node.network, node.shader, texture)


def _gltf_image(node: _Node) -> Folded | None:
    value = _image(node)
    for name, neutral in (("scale", _WHOLE), ("rotate", _NIL), ("offset", _NIL)):
        if set(node.numbers(name, neutral)) != set(neutral):
            node.lost(name, "it is left out")
    if node.kind.startswith("ND_gltf_normalmap"):
        return value and affine(value, (2.0, 2.0, 2.0, 1.0), (-1.0, -1.0, -1.0, 0.0))
    factor = node.fold("color" if "_colorimage" in node.kind else "factor", _WHOLE)
    whole = None if value is None or factor is None else product(value, factor)
    return _part(whole, 3) if node.output == "outa" else whole


def _tiling(node: _Node) -> Array:
    """(3, 3) of what a tiled image does to its coordinates."""
    matrix = np.eye(3)
    if uvtextures.family(node.kind) == "tiledimage":
        matrix[:2, :2] = np.diag(_widened(node.numbers("uvtiling", (1.0,)), 2, 1.0))
        matrix[:2, 2] = -_widened(node.numbers("uvoffset", (0.0,)), 2, 0.0)
        size, tile = (
            _widened(node.numbers(name, (1.0,)), 2, 1.0)
            for name in ("realworldimagesize", "realworldtilesize")
        )
        matrix[:2] *= (tile / np.where(size == 0.0, 1.0, size))[:, None]
    return matrix


def _space(node: _Node, file: str) -> ColorSpace:
    said = node.network.source(node.shader, "file").space
    if said in _SRGB:
        return "sRGB"
    if said and said not in _LINEAR:
        node.lost("file", f"the colour space {said} is replaced by the default")
    is_color = "_color" in node.kind and said not in _LINEAR
    return color_space(file) if is_color else "raw"


def _usd_texture(node: _Node) -> Folded | None:
    found = uvtextures.read_texture_node(node.network, node.shader, node.output)
    return node.fold("fallback") if found is None else found


_RULES: Final[Mapping[str, Callable[[_Node], Folded | None]]] = {
    "image": _image,
    "tiledimage": _image,
    **dict.fromkeys(("gltf_image", "gltf_colorimage", "gltf_normalmap"), _gltf_image),
    "UsdUVTexture": _usd_texture,
    "constant": lambda node: node.fold("value"),
    "convert": lambda node: node.fold("in"),
    "dot": lambda node: node.fold("in"),
    "multiply": _multiply,
    "divide": _divide,
    "add": _sum(1.0),
    "subtract": _sum(-1.0),
    "mix": _mix,
    "invert": _invert,
    "remap": _remap,
    "clamp": _clamp,
    "extract": _extract,
    **dict.fromkeys(("separate2", "separate3", "separate4"), _separate),
    "swizzle": _swizzle,
    **dict.fromkeys(("combine2", "combine3", "combine4"), _combine),
    "normalmap": _normal_map,
}
