"""Where a node of MaterialX looks its image up: a primvar, and an affine map of it."""

import math
from collections.abc import Callable, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import UsdShade

from openrooms_usd import names
from openrooms_usd.geometry.rotations import in_plan
from openrooms_usd.usd.shading.networks import Network
from openrooms_usd.usd.shading.uvtextures import transform_of

_Matrix = NDArray[np.float64]
_Pair = tuple[float, float]
# The longest chain of nodes that is followed, so that a cycle ends.
_MAX_CHAIN: Final = 16
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
        Its name, and (3, 3) for columns (s, t, 1); as MaterialX says the first set of coordinates
        where nobody says another.
    """
    with np.errstate(all="ignore"):
        primvar, matrix = _followed(network, node)
    if np.abs(matrix).max() < _MOST:
        return primvar, matrix
    network.lost(node, "texcoord", "what is done to its coordinates is no affine map; left out")
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
