"""What drives an input of a MaterialX node: constants, and textures under affine arithmetic.

Nodes are followed as long as the result can be said by one `Texture`: images, channels, products
and sums with constants, normal maps. Everything else is procedural and reported by its name.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.library.ownmaterials.images import Images
from openrooms_usd.usd.surfaces import Channel, Texture

Constant = tuple[float, ...]
Signal = Constant | Texture | None

_MAX_CHAIN: Final = 64
_CHANNELS: Final[tuple[Channel, ...]] = ("r", "g", "b", "a")
# The channel that an output of a node with several stands for.
_OUTPUTS: Final[dict[str, Channel]] = {
    name: channel
    for channel, names in zip(
        _CHANNELS, (("r", "outr", "outx"), ("g", "outg", "outy"), ("b", "outb", "outz"),
                    ("a", "outa", "outw")), strict=True,
    )
    for name in names
}  # fmt: skip
_COLOR_TYPES: Final = ("color3", "color4")


@dataclass
class Signals:
    """Follows connections; what it cannot say lands in ``losses``.

    Attributes:
        folder: The folder of the .mtlx.
        losses: Receives one sentence for each node that is left out.
    """

    folder: Path
    losses: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Share the list of losses with what reads images."""
        self.images = Images(self.folder, self.losses, self.constant)

    def of(self, node: Any, name: str, depth: int = 0) -> Signal:
        """What drives an input; None where it is procedural, or nothing does.

        Args:
            node: The node.
            name: Its input.
            depth: How many nodes lie on the way; a cycle ends.
        """
        socket, source, output = _followed(node.getInput(name))
        if source is not None:
            return self._of_node(source, output, depth)
        if socket is None:
            definition = node.getNodeDef()
            socket = definition.getActiveInput(name) if definition else None
        return _value(socket) if socket is not None else None

    def constant(self, node: Any, name: str, default: Any) -> Any:
        """A value that only a constant may drive: numbers as a tuple, else text."""
        socket, source, _ = _followed(node.getInput(name))
        if source is not None:
            self.losses.append(f"{node.getName()}.{name}: {source.getCategory()} cannot drive it")
            return default
        if socket is None or not socket.getValueString():
            return default
        value = _value(socket)
        return socket.getResolvedValueString() if value is None else value

    def _of_node(self, node: Any, output: str, depth: int) -> Signal:
        kind = node.getCategory()
        reader = _READERS.get(kind)
        if depth > _MAX_CHAIN or reader is None:
            self.losses.append(f"{node.getName()} ({kind}): procedural; left out")
            return None
        signal = reader(self, node, depth + 1)
        channel = _OUTPUTS.get(output)
        return signal if channel is None else _picked(signal, channel)

    def _constant_node(self, node: Any, depth: int) -> Signal:
        return self.of(node, "value", depth)

    def _image(self, node: Any, depth: int) -> Signal:
        return self.images.texture(node)

    def _through(self, node: Any, depth: int) -> Signal:
        return self.of(node, "in", depth)

    def _extract(self, node: Any, depth: int) -> Signal:
        index = int(self.constant(node, "index", (0.0,))[0])
        return _picked(self.of(node, "in", depth), _CHANNELS[min(max(index, 0), 3)])

    def _invert(self, node: Any, depth: int) -> Signal:
        amount, signal = self.of(node, "amount", depth), self.of(node, "in", depth)
        return self._sum(node, amount, scaled(signal, (-1.0,)))

    def _normal_map(self, node: Any, depth: int) -> Signal:
        """Normals in 0..1 become normals in -1..1, their tilt times ``scale``."""
        signal, strength = self.of(node, "in", depth), self.constant(node, "scale", (1.0,))
        if not isinstance(signal, Texture):
            return None
        x, y = strength[0], strength[-1]
        unpacked = _shifted(scaled(signal, (2.0, 2.0, 2.0, 1.0)), (-1.0, -1.0, -1.0, 0.0))
        return scaled(unpacked, (x, y, 1.0, 1.0))

    def _add(self, node: Any, depth: int) -> Signal:
        return self._sum(node, *self._operands(node, depth))

    def _subtract(self, node: Any, depth: int) -> Signal:
        first, second = self._operands(node, depth)
        return self._sum(node, first, scaled(second, (-1.0,)))

    def _multiply(self, node: Any, depth: int) -> Signal:
        return self.product(node.getName(), *self._operands(node, depth))

    def _operands(self, node: Any, depth: int) -> tuple[Signal, Signal]:
        return self.of(node, "in1", depth), self.of(node, "in2", depth)

    def product(self, name: str, first: Signal, second: Signal) -> Signal:
        """A product of which one factor at least is a constant."""
        if isinstance(first, tuple):
            first, second = second, first
        if isinstance(second, tuple):
            return scaled(first, second)
        if None not in (first, second):
            self.losses.append(f"{name}: a product of two textures; the second is left out")
        return first if first is not None else second

    def _sum(self, node: Any, first: Signal, second: Signal) -> Signal:
        if isinstance(first, tuple):
            first, second = second, first
        if isinstance(second, tuple):
            return _shifted(first, second)
        if None not in (first, second):
            self.losses.append(f"{node.getName()}: a sum of two textures; the second is left out")
        return first if first is not None else second


_READERS: Final[dict[str, Callable[[Signals, Any, int], Signal]]] = {
    "constant": Signals._constant_node,
    "image": Signals._image,
    "tiledimage": Signals._image,
    "gltf_image": Signals._image,
    "gltf_colorimage": Signals._image,
    "UsdUVTexture": Signals._image,
    "dot": Signals._through,
    "convert": Signals._through,
    "separate2": Signals._through,
    "separate3": Signals._through,
    "separate4": Signals._through,
    "extract": Signals._extract,
    "invert": Signals._invert,
    "normalmap": Signals._normal_map,
    "gltf_normalmap": Signals._image,
    "multiply": Signals._multiply,
    "add": Signals._add,
    "subtract": Signals._subtract,
}


def _followed(socket: Any) -> tuple[Any, Any, str]:
    """Where an input's value comes from: (the input with the value, a node or None, its output)."""
    for _ in range(_MAX_CHAIN):
        if socket is None:
            return None, None, ""
        if socket.getInterfaceName():
            outer = socket.getInterfaceInput()
            if outer is None:
                return socket, None, ""
            socket = outer
            continue
        through = socket.getConnectedOutput() if socket.getNodeGraphString() else None
        end = through if through is not None else socket
        node = end.getConnectedNode()
        return socket, node, end.getOutputString() if node is not None else ""
    return None, None, ""


def _value(socket: Any) -> Constant | None:
    """The numbers of an input, colours decoded to linear; None where it holds none."""
    words = socket.getValueString().replace(",", " ").split()
    if socket.getType() == "boolean":
        return (float(words == ["true"]),)
    try:
        numbers = tuple(float(word) for word in words)
    except ValueError:
        return None
    if not all(map(math.isfinite, numbers)):
        raise ValueError(f"{socket.getNamePath()}: {socket.getValueString()} is not finite")
    if socket.getType() in _COLOR_TYPES and socket.getActiveColorSpace() == "srgb_texture":
        numbers = (*linear_from_srgb(np.array(numbers[:3])).tolist(), *numbers[3:])
    return numbers or None


def _picked(signal: Signal, channel: Channel) -> Signal:
    if isinstance(signal, Texture):
        return replace(signal, channel=channel) if signal.channel == "rgb" else signal
    if signal is None:
        return None
    return (_four(signal, 1.0)[_CHANNELS.index(channel)],)


def _four(numbers: Constant, alpha: float) -> tuple[float, float, float, float]:
    r, g, b, a = {
        1: numbers * 4,
        2: (*numbers, 0.0, alpha),
        3: (*numbers, alpha),
    }.get(len(numbers), numbers[:4])
    return r, g, b, a


def scaled(signal: Signal, factor: Constant) -> Signal:
    """A signal times a constant."""
    if isinstance(signal, Texture):
        f = _four(factor, 1.0)
        scale, bias = (
            tuple(x * y for x, y in zip(values, f, strict=True))
            for values in (signal.scale, signal.bias)
        )
        return replace(signal, scale=_four(scale, 1.0), bias=_four(bias, 0.0))
    return None if signal is None else _paired(signal, factor, lambda x, y: x * y)


def _shifted(signal: Signal, offset: Constant) -> Signal:
    if isinstance(signal, Texture):
        bias = tuple(x + y for x, y in zip(signal.bias, _four(offset, 0.0), strict=True))
        return replace(signal, bias=_four(bias, 0.0))
    return None if signal is None else _paired(signal, offset, lambda x, y: x + y)


def _paired(a: Constant, b: Constant, combine: Callable[[float, float], float]) -> Constant:
    """Combine numbers one by one; a single one goes with all of the others."""
    count = max(len(a), len(b))
    first, second = (x * count if len(x) == 1 else x for x in (a, b))
    return tuple(combine(x, y) for x, y in zip(first, second, strict=False))
