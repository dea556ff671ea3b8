"""The matter of many surfaces in one table, so that one BSDF serves them all.

Dr.Jit traces and compiles every BSDF of a scene, and in a kernel each is a call of its own. Here a
surface is a row: the shape that was hit gives its index, its numbers and the places of its pictures
are gathered, and the texels of all pictures lie in one array. What is compiled does not grow with
the number of materials. Texels are decoded as `pictures.Coding` says and interpolated as
`pictures.Picture.lookup` does it.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Bytes
from openrooms_usd.rendering.scene.pictures import Picture, Value
from openrooms_usd.rendering.scene.surfaces import Surface
from openrooms_usd.usd.shading.surfaces import f0_of
from orusd_mitsuba.plugins.descriptions import transmitted
from orusd_mitsuba.plugins.memory import aligned
from orusd_mitsuba.plugins.openrooms_bsdf import Matter
from orusd_mitsuba.plugins.preview_bsdf import Inputs as PreviewInputs

_PICTURED: Final = ("base_color", "roughness", "metallic", "normal", "specular")
# Two bits for each direction, then whether codes are sRGB.
_WRAPS: Final = ("repeat", "mirror", "clamp")
_SRGB: Final = 16


def fits(surface: Surface) -> bool:
    """Whether a surface can be a row: of OpenRooms' model or Lambertian, with pictures of 8 bits.

    Clear ones cannot; nor Lambertian ones with relief, which Mitsuba's own BSDF bends otherwise.
    """
    return (
        (surface.f0 is not None or (surface.is_diffuse and surface.normal is None))
        and not surface.lets_through
        and all(picture.coding is not None for picture in _pictures(surface))
    )


def fits_preview(surface: Surface) -> bool:
    """Whether a surface can be a row of a `PreviewTable`: a UsdPreviewSurface, opaque, as above."""
    return (
        surface.f0 is None
        and not surface.is_diffuse
        and not surface.lets_through
        and surface.transmission == 0.0
        and all(picture.coding is not None for picture in _pictures(surface))
    )


def _pictures(surface: Surface) -> list[Picture]:
    values = (getattr(surface, name) for name in _PICTURED)
    return [value for value in values if isinstance(value, Picture)]


class MaterialTable:
    """The matter of surfaces that are all `fits`, as arrays of the active variant.

    Args:
        surfaces: One a row.
    """

    def __init__(self, surfaces: Sequence[Surface]) -> None:
        self._row_of_shape = mi.UInt32(0)
        numbers = np.array([self._row(surface) for surface in surfaces], dtype=np.float32)
        self._numbers = mi.Float(aligned(numbers))
        store = _Store(picture for surface in surfaces for picture in _pictures(surface))
        self._texels = mi.UInt32(aligned(store.words))
        self._inputs = {
            name: _Input.of([getattr(surface, name) for surface in surfaces], store)
            for name in _PICTURED
        }

    def bind(self, shapes: Iterable[Any], rows: Iterable[int]) -> None:
        """Say which row each shape of the scene shows.

        Args:
            shapes: Shapes that have the BSDF of this table.
            rows: Of each.
        """
        numbers = [shape_number(shape) for shape in shapes]
        table = np.zeros(max(numbers, default=0) + 1, dtype=np.uint32)
        table[numbers] = list(rows)
        self._row_of_shape = mi.UInt32(table)

    def __call__(self, si: Any, active: Any) -> Matter:
        """The matter at surface interactions."""
        row, base, rough, others = self._looked_up(si, 2, active)
        return Matter(
            mi.Color3f(base.x, base.y, base.z),
            rough,
            self._value("metallic", row, si.uv, mi.Vector3f(others[0].x), active).x,
            others[0].y,
            others[0].z,
            self._value("normal", row, si.uv, mi.Vector3f(0.0, 0.0, 1.0), active),
            others[0].w,
        )

    def _looked_up(self, si: Any, width: int, active: Any) -> tuple[Any, Any, Any, list[Any]]:
        """The row, its base colour and roughness, and all but the first of its fours of numbers."""
        shape: Any = dr.reinterpret_array(mi.UInt32, si.shape)
        row = dr.gather(mi.UInt32, self._row_of_shape, shape, active)
        color, *others = (
            dr.gather(mi.Vector4f, self._numbers, width * row + k, active) for k in range(width)
        )
        base = mi.Vector3f(color.x, color.y, color.z)
        base = self._value("base_color", row, si.uv, base, active)
        rough = self._value("roughness", row, si.uv, mi.Vector3f(color.w), active).x
        return row, base, rough, others

    @staticmethod
    def _row(surface: Surface) -> list[float]:
        """Eight numbers; what is a picture is 0."""
        scalars = [_constant(value, 1)[0] for value in (surface.roughness, surface.metallic)]
        lobe = 0.0 if surface.f0 is None else 1.0
        through = transmitted(surface)
        return [
            *_constant(surface.base_color, 3),
            *scalars,
            float(surface.f0 or 0.0),
            through,
            lobe,
        ]

    def traverse(self, callback: Any) -> None:
        """Show nothing to Mitsuba: rows are not parameters."""

    def _value(self, name: str, row: Any, uv: Any, constant: Any, active: Any) -> Any:
        found = self._inputs[name]
        return constant if found is None else found.value(self._texels, row, uv, constant, active)


class PreviewTable(MaterialTable):
    """The inputs of surfaces that are all `fits_preview`, likewise.

    Args:
        surfaces: One a row.
    """

    def __init__(self, surfaces: Sequence[Surface]) -> None:
        super().__init__(surfaces)
        self._colored = any(surface.specular is not None for surface in surfaces)
        self._coated = any(surface.clearcoat > 0.0 for surface in surfaces)

    def __call__(self, si: Any, active: Any) -> PreviewInputs:  # type: ignore[override]
        """The inputs at surface interactions."""
        row, base, rough, (first, second) = self._looked_up(si, 3, active)
        specular = None
        if self._colored:
            color = mi.Vector3f(second.x, second.y, second.z)
            color = self._value("specular", row, si.uv, color, active)
            specular = mi.Color3f(color.x, color.y, color.z), second.w
        return PreviewInputs(
            mi.Color3f(base.x, base.y, base.z),
            rough,
            self._value("metallic", row, si.uv, mi.Vector3f(first.x), active).x,
            first.y,
            self._value("normal", row, si.uv, mi.Vector3f(0.0, 0.0, 1.0), active),
            specular,
            (first.z, first.w) if self._coated else None,
        )

    @staticmethod
    def _row(surface: Surface) -> list[float]:
        """Twelve numbers; what is a picture is 0."""
        scalars = [_constant(value, 1)[0] for value in (surface.roughness, surface.metallic)]
        coat = surface.clearcoat, surface.clearcoat_roughness
        colored = surface.specular is not None
        color = _constant(surface.specular, 3) if surface.specular is not None else [0.0] * 3
        base = _constant(surface.base_color, 3)
        return [*base, *scalars, f0_of(surface.ior), *coat, *color, float(colored)]


def _constant(value: Value, channels: int) -> list[float]:
    if isinstance(value, Picture):
        return [0.0] * channels
    numbers: list[float] = np.broadcast_to(np.asarray(value), channels).tolist()
    return numbers


class _Store:
    """The texels of distinct pictures one after another, each in a word of 32 bits.

    Attributes:
        words: (N,) uint32, red in the lowest byte.
    """

    def __init__(self, pictures: Iterable[Picture]) -> None:
        # By the identity of their texels: equal ones were read once.
        distinct = {id(picture.texels): picture.texels for picture in pictures}
        sizes = [texels.shape[0] * texels.shape[1] for texels in distinct.values()]
        starts = np.cumsum([0, *sizes])
        self._starts = dict(zip(distinct, starts.tolist(), strict=False))
        self.words: NDArray[np.uint32] = np.zeros(int(starts[-1]) + 1, dtype=np.uint32)
        for start, size, texels in zip(starts, sizes, distinct.values(), strict=False):
            self.words[start : start + size] = _packed(texels)

    def start(self, picture: Picture) -> int:
        """The number of its first texel."""
        return int(self._starts[id(picture.texels)])


def _packed(texels: Bytes) -> NDArray[np.uint32]:
    """(N,) words; what lies above the channels has no meaning."""
    codes = np.ascontiguousarray(texels).ravel()
    if texels.shape[2] == 1:
        return codes.astype(np.uint32)
    # Words that overlap: the fourth byte of each is the first of the next one.
    padded = np.append(codes, np.uint8(0))
    count, step = texels.shape[0] * texels.shape[1], texels.shape[2]
    return np.ndarray((count,), dtype="<u4", buffer=padded, strides=(step,))


@dataclass(frozen=True, eq=False)
class _Input:
    """One input of the model, by row.

    Attributes:
        places: (4 N,) start, width, height and kind of each row's picture; a width of 0: none.
        levels: (8 N,) scale and bias, each of three channels and one limit.
        turns: (8 N,) from the mesh's texture coordinates to the picture's; None where all are the
            identity.
        wraps: Which kinds of wrapping there are.
        srgb: Whether any picture is decoded as sRGB.
    """

    places: Any
    levels: Any
    turns: Any
    wraps: frozenset[str]
    srgb: bool

    @staticmethod
    def of(values: Sequence[Any], store: _Store) -> "_Input | None":
        """The input of some values, one a row; None where none is a picture."""
        pictures = [value if isinstance(value, Picture) else None for value in values]
        present = [picture for picture in pictures if picture is not None]
        if not present:
            return None
        plain = all(picture.is_plain for picture in present)
        return _Input(
            mi.UInt32(aligned(np.array([_place(p, store) for p in pictures], dtype=np.uint32))),
            mi.Float(aligned(np.array([_level(p) for p in pictures], dtype=np.float32))),
            None
            if plain
            else mi.Float(aligned(np.array([_turn(p) for p in pictures], np.float32))),
            frozenset(way for picture in present for way in picture.ways),
            any(picture.coding is not None and picture.coding.srgb for picture in present),
        )

    def value(self, texels: Any, row: Any, uv: Any, constant: Any, active: Any) -> Any:
        """Bilinear values where the row has a picture, else the constant."""
        place = dr.gather(mi.Vector4u, self.places, row, active)
        active = active & (place.y > 0)
        if self.turns is not None:
            s, t = (dr.gather(mi.Vector4f, self.turns, 2 * row + k, active) for k in (0, 1))
            uv = mi.Point2f(s.x * uv.x + s.y * uv.y + s.z, t.x * uv.x + t.y * uv.y + t.z)
        size = mi.Vector2f(place.y, place.z)
        at = mi.Vector2f(uv) * size - 0.5
        corner = dr.floor(at)
        weight, total = at - corner, mi.Vector3f(0.0)
        scale = dr.gather(mi.Vector4f, self.levels, 2 * row, active)
        bias = dr.gather(mi.Vector4f, self.levels, 2 * row + 1, active)
        for right in (0, 1):
            for up in (0, 1):
                cell = [
                    self._wrapped(corner[k] + step, size[k], place.w >> (2 * k))
                    for k, step in enumerate((right, up))
                ]
                index = place.x + mi.UInt32(cell[1]) * place.y + mi.UInt32(cell[0])
                word = dr.gather(mi.UInt32, texels, index, active)
                share = (weight.x if right else 1 - weight.x) * (weight.y if up else 1 - weight.y)
                total += share * self._decoded(word, scale, bias, place.w)
        return dr.select(active, total, constant)

    def _decoded(self, word: Any, scale: Any, bias: Any, kind: Any) -> Any:
        codes = mi.Vector3f([mi.Float((word >> shift) & 255) for shift in (0, 8, 16)]) / 255.0
        if self.srgb:
            power = ((codes + 0.055) / 1.055) ** 2.4
            linear = dr.select(codes <= 0.04045, codes / 12.92, power)
            codes = dr.select(kind >= _SRGB, linear, codes)
        values = codes * mi.Vector3f(scale.x, scale.y, scale.z) + mi.Vector3f(
            bias.x, bias.y, bias.z
        )
        return dr.clip(values, scale.w, bias.w)

    def _wrapped(self, index: Any, size: Any, kind: Any) -> Any:
        """A column or row inside the picture, for whole numbers beyond it."""
        inside = index - dr.floor(index / size) * size
        if "mirror" in self.wraps:
            twice = index - dr.floor(index / (2 * size)) * (2 * size)
            folded = dr.minimum(twice, 2 * size - 1 - twice)
            inside = dr.select((kind & 3) == _WRAPS.index("mirror"), folded, inside)
        if "clamp" in self.wraps:
            inside = dr.select((kind & 3) == _WRAPS.index("clamp"), index, inside)
        # Also where numbers are too large to tell neighbours apart, or none at all.
        return dr.clip(inside, 0.0, dr.maximum(size - 1.0, 0.0))


def _place(picture: Picture | None, store: _Store) -> list[int]:
    if picture is None or picture.coding is None:
        return [0] * 4
    height, width, _ = picture.texels.shape
    across, up = map(_WRAPS.index, picture.ways)
    kind = across + 4 * up + _SRGB * picture.coding.srgb
    return [store.start(picture), width, height, kind]


def _level(picture: Picture | None) -> list[float]:
    if picture is None or picture.coding is None:
        return [0.0] * 8
    (low, high), coding = picture.coding.limits, picture.coding
    scale, bias = (np.resize(values, 3).tolist() for values in (coding.scale, coding.bias))
    return [*scale, low, *bias, high]


def _turn(picture: Picture | None) -> list[float]:
    matrix = np.eye(3) if picture is None else picture.uv
    rows: list[float] = np.column_stack([matrix[:2], np.zeros(2)]).ravel().tolist()
    return rows


def shape_number(shape: Any) -> int:
    """The number under which Dr.Jit knows a shape."""
    number: Any = dr.reinterpret_array(mi.UInt32, mi.ShapePtr(shape))
    return int(number.numpy()[0])
