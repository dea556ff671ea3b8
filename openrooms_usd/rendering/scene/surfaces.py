"""What a surface does to light: between UsdPreviewSurface and a renderer's BSDFs."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from typing import Any, Final

import numpy as np

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import luminance
from openrooms_usd.errors import InputError
from openrooms_usd.rendering.scene.codes import Known, load_picture
from openrooms_usd.rendering.scene.pictures import MAX_SIDE, Limits, Picture, Value, times
from openrooms_usd.usd.shading.surfaces import PreviewSurface, Texture, ior_of
from openrooms_usd.usd.shading.textures import texture_size

_UNIT_RANGE: Final = (0.0, 1.0)
_POSITIVE_RANGE: Final = (0.0, math.inf)
_NORMAL_RANGE: Final = (-1.0, 1.0)
_HEIGHT_RANGE: Final = (-1e6, 1e6)
_HEIGHT: Final = "displacement"
# Below the least roughness GGX is so sharp that paths hit its peak only by luck.
_ROUGHNESS_RANGE: Final = (0.01, 1.0)
# What each input of a preview surface needs of a texture.
_NEEDS: Final[dict[str, tuple[int, Limits]]] = {
    "base_color": (3, _UNIT_RANGE),
    "roughness": (1, _ROUGHNESS_RANGE),
    "metallic": (1, _UNIT_RANGE),
    "opacity": (1, _UNIT_RANGE),
    "normal": (3, _NORMAL_RANGE),
    "emissive": (3, _POSITIVE_RANGE),
    "specular": (3, _UNIT_RANGE),
    # Of these a mean is taken.
    "clearcoat": (1, _UNIT_RANGE),
    "clearcoat_roughness": (1, _UNIT_RANGE),
    _HEIGHT: (1, _HEIGHT_RANGE),
}
_MOST_IOR: Final = 20.0
# What pictures may take together, of which each channel of a texel takes a code and a half float.
_MOST_TEXEL_BYTES: Final = 2.0e9
_BYTES_OF_A_TEXEL: Final = 3
_LEAST_SIDE: Final = 256
_MOST_REFLECTANCE: Final = 0.9
_DARK: Final = (0.0, 0.0, 0.0)
_FLAT_NORMAL: Final = (0.0, 0.0, 1.0)
CLEAR: Final = "opacity lets light straight through; clear parts reflect nothing"
"""What is lost of a surface that is partly clear."""


@dataclass(frozen=True, eq=False)
class Surface:
    """The inputs of a BSDF, each a constant or a picture in linear units.

    Attributes:
        base_color: Diffuse colour of dielectrics, reflectance of metals.
        roughness: Perceptual roughness R; alpha = R^2.
        metallic: 0 dielectric to 1 metal.
        ior: Index of refraction; 1 leaves the diffuse part alone.
        specular: Reflectance of a dielectric at normal incidence, a colour; None where ``ior``
            says it.
        clearcoat: Weight of the second specular lobe.
        clearcoat_roughness: Its perceptual roughness.
        opacity: 0 absent to 1 there.
        normal: Tangent-space normals in -1..1, or None.
        emission: Radiance in nits; None where it is dark.
        primvar: Name of the texture coordinates.
        uv: (3, 3) from the primvar to the mesh's texture coordinates, common to all pictures.
        transmission: Luminous part of the light that leaves the other side like Lambert's, in the
            hue of the base colour; with the base colour at most 1.
        f0: Reflectance at normal incidence of OpenRooms' model, which it then is of; None where it
            is a UsdPreviewSurface.
        pane: What the glass of a thin clear pane lets through at normal incidence, by primary; it
            then has no matter but that and ``ior``. None where there is none.
        one_sided: Whether only its front is visible.
        losses: What could not be kept, in words.
    """

    base_color: Value = (0.18, 0.18, 0.18)
    roughness: Value = 0.5
    metallic: Value = 0.0
    ior: float = 1.5
    specular: Value | None = None
    clearcoat: float = 0.0
    clearcoat_roughness: float = 0.01
    opacity: Value = 1.0
    normal: Picture | None = None
    emission: Value | None = None
    primvar: str = names.ST
    uv: Array = field(default_factory=lambda: np.eye(3))
    transmission: float = 0.0
    f0: float | None = None
    pane: tuple[float, float, float] | None = None
    one_sided: bool = False
    losses: tuple[str, ...] = ()

    @property
    def is_diffuse(self) -> bool:
        """Whether nothing but the Lambertian part is there."""
        plain = self.ior == 1.0 and self.specular is None
        return plain and self.metallic == 0.0 and self.clearcoat == 0.0

    @property
    def dielectric(self) -> float:
        """The index of refraction, which the mean of a specular colour stands for."""
        if self.specular is None:
            return self.ior
        colors = self.specular.pixels if isinstance(self.specular, Picture) else self.specular
        return ior_of(min(float(np.mean(colors, dtype=np.float64)), _MOST_REFLECTANCE))

    @property
    def lets_through(self) -> bool:
        """Whether anything goes straight through, panes aside."""
        return self.opacity != 1.0 or self.one_sided

    @property
    def is_textured(self) -> bool:
        """Whether any input is a picture."""
        return any(isinstance(value, Picture) for value in vars(self).values())


class SurfaceReader:
    """Turns preview surfaces into `Surface`, reading each picture once.

    Args:
        side: The longest side of pictures that are kept as they are, pixels; None: so long that all
            of a stage take at most 2 GB.
    """

    def __init__(self, side: int | None = None) -> None:
        self._side, self._is_asked = side or MAX_SIDE, side is not None
        self._surfaces: dict[PreviewSurface, Surface] = {}
        self._pictures: dict[_Need, Picture] = {}
        self._codes: Known = {}

    def prefetch(self, previews: Iterable[PreviewSurface]) -> None:
        """Read the pictures of surfaces that will be read, on all cores."""
        wanted = dict.fromkeys(need for preview in previews for need in _pictures_of(preview))
        missing = [need for need in wanted if need not in self._pictures]
        if not self._is_asked:
            self._side = _affordable_side(missing)
        # One of each file at the same time; what shares its codes follows.
        files = list({(need[0].file, need[0].channel, need[1]): need for need in missing}.values())
        with ThreadPoolExecutor() as pool:
            self._pictures |= zip(files, pool.map(self._load, files), strict=True)
        self._pictures |= {need: self._load(need) for need in missing if need not in self._pictures}

    def read(self, preview: PreviewSurface) -> Surface:
        """The surface of a preview surface; equal ones share one object."""
        if preview not in self._surfaces:
            self._surfaces[preview] = self._read(preview)
        return self._surfaces[preview]

    def height(self, preview: PreviewSurface) -> Value:
        """How far it moves points along their normals, at the coordinates of its own texture."""
        return self._value(preview, _HEIGHT, np.eye(3))

    def _read(self, preview: PreviewSurface) -> Surface:
        if preview.pane is not None:
            # Its opacity stands in for it where panes are not known.
            preview = replace(preview, opacity=1.0)
        primvar, uv = _common_mapping(preview)
        emission, opacity = self._value(preview, "emissive", uv), self._opacity(preview, uv)
        absent = preview.opacity_threshold > 0.0 or preview.opacity_mode == "presence"
        if absent and emission != _DARK:
            # What is not there sends nothing; clear glass may glow.
            emission = times(emission, opacity)
        values: dict[str, Any] = {
            "base_color": self._value(preview, "base_color", uv),
            "roughness": self._value(preview, "roughness", uv),
            "metallic": self._value(preview, "metallic", uv),
            "opacity": opacity,
            "normal": self._normal(preview, uv),
            "emission": None if emission == _DARK else emission,
        }
        ior, losses = _ior(preview.ior)
        if preview.specular is not None and preview.f0 is None:
            values |= {"metallic": 0.0, "specular": self._value(preview, "specular", uv)}
        losses += [text for found, text in _LOST if found(preview)]
        values["transmission"], lost = _transmission(preview.transmission, values["base_color"])
        losses += lost
        losses += [loss for v in values.values() if isinstance(v, Picture) for loss in v.losses]
        return Surface(
            **values,
            ior=ior,
            f0=preview.f0,
            pane=preview.pane,
            clearcoat=self._mean(preview, "clearcoat", uv),
            clearcoat_roughness=self._mean(preview, "clearcoat_roughness", uv),
            primvar=primvar,
            uv=uv,
            losses=tuple(dict.fromkeys(losses)),
        )

    def _value(self, preview: PreviewSurface, name: str, uv: Array) -> Value:
        source, (channels, limits) = getattr(preview, name), _NEEDS[name]
        if isinstance(source, Texture):
            need = _need(source, name, uv)
            if need not in self._pictures:
                self._pictures[need] = self._load(need)
            return self._pictures[need]
        clipped = np.clip(np.asarray(source, dtype=np.float64), *limits)
        if channels == 1:
            return float(clipped)
        red, green, blue = np.broadcast_to(clipped, 3).tolist()
        return red, green, blue

    def _mean(self, preview: PreviewSurface, name: str, uv: Array) -> float:
        """The mean of an input; 0 if not authored."""
        if getattr(preview, name) is None:
            return 0.0
        value = self._value(preview, name, uv)
        return float(np.mean(value.pixels if isinstance(value, Picture) else value, dtype=float))

    def _normal(self, preview: PreviewSurface, uv: Array) -> Picture | None:
        """A normal map; of a constant direction one of a single texel."""
        if isinstance(preview.normal, Texture):
            found = self._value(preview, "normal", uv)
            return found if isinstance(found, Picture) else None
        length = float(np.linalg.norm(preview.normal))
        if length == 0.0 or preview.normal == _FLAT_NORMAL:
            return None
        texel = np.array(preview.normal, dtype=np.float32).reshape(1, 1, 3) / np.float32(length)
        return Picture(texel)

    def _load(self, need: "_Need") -> Picture:
        texture, channels, limits, mapping = need
        uv = np.frombuffer(mapping).reshape(3, 3)
        return load_picture(texture, channels, limits, uv, self._codes, self._side)

    def _opacity(self, preview: PreviewSurface, uv: Array) -> Value:
        opacity = self._value(preview, "opacity", uv)
        threshold = preview.opacity_threshold
        if threshold <= 0.0:
            return opacity
        if isinstance(opacity, Picture):
            mask = (opacity.pixels >= threshold).astype(np.float16)
            return Picture(mask, opacity.wrap, opacity.uv, opacity.losses)
        return float(np.asarray(opacity) >= threshold)


# A texture, the channels and limits of its input, and the bytes of the (3, 3) mapping.
_Need = tuple[Texture, int, Limits, bytes]


def _affordable_side(needs: Sequence[_Need]) -> int:
    """The longest side that pictures may have, so that all of them fit into `_MOST_TEXEL_BYTES`."""
    sizes = []
    for file, channels in {(need[0].file, need[1]) for need in needs}:
        with suppress(InputError):
            sizes.append((*texture_size(file), channels))
    side = MAX_SIDE
    while side > _LEAST_SIDE and _texel_bytes(sizes, side) > _MOST_TEXEL_BYTES:
        side //= 2
    return side


def _texel_bytes(sizes: Sequence[tuple[int, int, int]], side: int) -> float:
    total = 0.0
    for wide, high, channels in sizes:
        share = min(1.0, side / max(wide, high, 1))
        total += wide * high * share**2 * channels * _BYTES_OF_A_TEXEL
    return total


def _pictures_of(preview: PreviewSurface) -> Iterator[_Need]:
    _, uv = _common_mapping(preview)
    for name in _NEEDS:
        source = getattr(preview, name)
        if isinstance(source, Texture):
            yield _need(source, name, uv)


def _need(texture: Texture, name: str, uv: Array) -> _Need:
    # Points move before what a mesh's coordinates become for its surface.
    matrix = texture.uv_matrix if name == _HEIGHT else _relative(texture, uv)
    return texture, *_NEEDS[name], matrix.tobytes()


def _textures(preview: PreviewSurface) -> list[Texture]:
    """What is seen of textures, the normal map first: tangents hang on its coordinates."""
    seen = [item.name for item in fields(preview) if item.name != _HEIGHT]
    values = [preview.normal, *(getattr(preview, name) for name in seen)]
    return [value for value in values if isinstance(value, Texture)]


def _common_mapping(preview: PreviewSurface) -> tuple[str, Array]:
    """The texture coordinates and the transform that go into the mesh.

    Inside the mesh the transform also turns the tangent that normal maps are relative to.
    """
    for texture in _textures(preview):
        if abs(np.linalg.det(texture.uv_matrix)) > 1e-12:
            return texture.primvar, texture.uv_matrix
    return names.ST, np.eye(3)


def _relative(texture: Texture, uv: Array) -> Array:
    matrix = texture.uv_matrix
    # Exactly the identity where both are equal: a rounded one would cost a transform a lookup.
    return np.eye(3) if np.array_equal(matrix, uv) else matrix @ np.linalg.inv(uv)


def _ior(wanted: float) -> tuple[float, list[str]]:
    """An index of refraction that is one, and what was lost."""
    if wanted >= 1.0:
        return min(wanted, _MOST_IOR), []
    return 1.0, [f"ior {wanted:g} is replaced by 1"]


def _transmission(wanted: float, base_color: Value) -> tuple[float, list[str]]:
    """As much as energy conservation leaves beside the reflected part, and what was lost."""
    if wanted <= 0.0:
        return 0.0, []
    pixels = base_color.pixels if isinstance(base_color, Picture) else np.array(base_color)
    brightest, mean = float(pixels.max()), mean_luminance(base_color)
    if mean <= 0.0:
        return 0.0, ["a black surface transmits nothing"]
    most = mean * max(0.0, 1.0 / brightest - 1.0)
    if wanted <= most:
        return wanted, []
    return most, [f"transmission {wanted:g} beside its base colour is taken as {most:.3g}"]


def mean_luminance(color: Value) -> float:
    """The luminance of a colour, or the mean luminance of a picture."""
    pixels = color.pixels if isinstance(color, Picture) else np.array(color)
    return float(luminance(pixels.reshape(-1, pixels.shape[-1]).astype(np.float64).mean(axis=0)))


def _is_textured(name: str) -> Callable[[PreviewSurface], bool]:
    return lambda preview: isinstance(getattr(preview, name), Texture)


def _is_clear(preview: PreviewSurface) -> bool:
    transparent = preview.opacity_mode == "transparent" and preview.opacity_threshold <= 0.0
    return transparent and preview.opacity != 1.0


def _many_primvars(preview: PreviewSurface) -> bool:
    return len({texture.primvar for texture in _textures(preview)}) > 1


_LOST: Final[tuple[tuple[Callable[[PreviewSurface], bool], str], ...]] = (
    (_is_textured("clearcoat"), "a textured clearcoat is replaced by its mean"),
    (_is_textured("clearcoat_roughness"), "a textured clearcoatRoughness is replaced by its mean"),
    (_is_clear, CLEAR),
    (_many_primvars, "its textures use several sets of coordinates; one set is used for all"),
)
