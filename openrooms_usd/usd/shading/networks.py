"""Walking shading networks of any origin: what feeds an input, and what is lost on the way."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final, cast

import numpy as np
from pxr import Usd, UsdShade

from openrooms_usd.usd.shading.surfaces import Color

# Animated inputs are read where they begin; all others have one value anyway.
_WHEN = Usd.TimeCode.EarliestTime()


@dataclass(frozen=True)
class InputSource:
    """What feeds an input: a constant, or an output of a shader.

    Attributes:
        constant: The constant; None where a shader drives the input or nothing does.
        shader: The shader that drives it, if one does.
        output: The shader's output, without its ``outputs:`` prefix.
        space: The authored colour space of a constant; empty if not authored.
    """

    constant: Any = None
    shader: UsdShade.Shader | None = None
    output: str = ""
    space: str = ""

    @property
    def kind(self) -> str:
        """The identifier of the shader, such as UsdUVTexture; empty where it has none."""
        return str(self.shader.GetShaderId() or "") if self.shader else ""


# Nodes that give what meshes say in a primvar, and the inputs that name it and stand in for it.
_READERS: Final[Mapping[str, tuple[str, str]]] = {
    "UsdPrimvarReader_": ("varname", "fallback"),
    "ND_UsdPrimvarReader_": ("varname", "fallback"),
    "ND_geompropvalue_": ("geomprop", "default"),
}
_NUMBERS: Final = ("float", "color3", "vector3", "float3")


@dataclass
class Network:
    """Reads the inputs of shaders and notes in ``losses`` what it could not take."""

    losses: list[str] = field(default_factory=list)

    def lost(self, shader: UsdShade.Shader, name: str, what: str) -> None:
        """Note that an input could not be taken as it is."""
        self.losses.append(f"{shader.GetPath()}.{name}: {what}")

    def source(self, shader: UsdShade.Shader, name: str) -> InputSource:
        """What feeds an input, followed through node graphs and interface inputs."""
        socket = shader.GetInput(name)
        if not socket:
            return InputSource()
        attributes = UsdShade.Utils.GetValueProducingAttributes(socket)
        if not attributes:
            return _constant(socket.GetAttr())
        if len(attributes) > 1:
            self.lost(shader, name, "only its first connection is read")
        base, kind = UsdShade.Utils.GetBaseNameAndType(attributes[0].GetName())
        if kind == UsdShade.AttributeType.Output:
            return InputSource(shader=UsdShade.Shader(attributes[0].GetPrim()), output=str(base))
        return _constant(attributes[0])

    def primvar(self, source: InputSource) -> tuple[str, Any]:
        """The primvar of numbers that a source is, if it is one, and what stands in for it."""
        for begin, (name, instead) in _READERS.items():
            if source.shader and source.kind.startswith(begin):
                if source.kind.removeprefix(begin) not in _NUMBERS:
                    return "", None
                said = str(self.constant(source.shader, name, "") or "")
                return said, self.constant(source.shader, instead, None)
        return "", None

    def own_value(self, shader: UsdShade.Shader, name: str) -> Any:
        """The value authored on an input itself, whatever is connected to it."""
        socket = shader.GetInput(name)
        return socket.GetAttr().Get(_WHEN) if socket else None

    def constant(self, shader: UsdShade.Shader, name: str, default: Any) -> Any:
        """An input that only a constant may drive."""
        source = self.source(shader, name)
        if source.shader:
            self.lost(shader, name, f"{source.kind or 'a shader'} cannot drive it")
            return default
        return default if source.constant is None else source.constant

    def number(self, shader: UsdShade.Shader, name: str, default: float) -> float:
        """A finite number that only a constant may drive."""
        value = self.constant(shader, name, default)
        return cast(float, self.finite(shader, name, value, default))

    def vector(self, shader: UsdShade.Shader, name: str, default: Any) -> Any:
        """A tuple of as many finite numbers as ``default`` has, driven by a constant."""
        value = self.constant(shader, name, None)
        if value is None:
            return default
        numbers = finite_numbers(value)
        if len(numbers) != len(default):
            self.lost(shader, name, f"{value} is not {len(default)} finite numbers")
            return default
        return numbers

    def finite(
        self, shader: UsdShade.Shader, name: str, value: Any, default: float | Color | None
    ) -> float | Color | None:
        """A constant as a number or colour, as ``default`` is; the default where it is neither."""
        if value is None:
            return default
        numbers = finite_numbers(value)
        if not numbers:
            self.lost(shader, name, f"{value} is not a finite number")
            return default
        if isinstance(default, float):
            return numbers[0]
        return cast(Color, numbers[:3] if len(numbers) >= 3 else (numbers[0],) * 3)


def _constant(attribute: Usd.Attribute) -> InputSource:
    return InputSource(constant=attribute.Get(_WHEN), space=str(attribute.GetColorSpace()))


def finite_numbers(value: Any) -> tuple[float, ...]:
    """The finite numbers in a scalar or vector; none when it holds anything else."""
    try:
        numbers = np.atleast_1d(np.asarray(value, dtype=np.float64))
    except (TypeError, ValueError):
        return ()
    if numbers.ndim != 1 or not all(map(math.isfinite, numbers)):
        return ()
    return tuple(numbers.tolist())
