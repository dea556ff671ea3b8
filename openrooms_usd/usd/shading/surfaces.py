"""The inputs of a UsdPreviewSurface as plain data, each a constant or a texture."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Final, Literal

import numpy as np

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.geometry.rotations import in_plan

Color = tuple[float, float, float]
# One of r, g, b and a, or three of them in any order.
Channel = str
ColorSpace = Literal["sRGB", "raw"]
Wrap = Literal["repeat", "clamp", "mirror", "black"]

# An 8-bit normal map stores (n + 1) / 2.
NORMAL_SCALE: Final = (2.0, 2.0, 2.0, 1.0)
NORMAL_BIAS: Final = (-1.0, -1.0, -1.0, 0.0)


def ior_of(f0: float) -> float:
    """The index of refraction whose Fresnel reflectance at normal incidence is ``f0``.

    1.576 for OpenRooms' 0.05.
    """
    root = math.sqrt(f0)
    return (1.0 + root) / (1.0 - root)


def f0_of(ior: float) -> float:
    """The Fresnel reflectance at normal incidence of an index of refraction."""
    return ((ior - 1.0) / (ior + 1.0)) ** 2


def chosen(channel: str, channels: int) -> tuple[int, ...]:
    """Which of r, g, b and a are taken for so many channels.

    A single number that is fed by a colour takes its first channel, as Hydra does.
    """
    which = tuple(map("rgba".index, channel))
    return which[:channels] if len(which) > 1 else which * channels


@dataclass(frozen=True)
class UvTransform:
    """UsdTransform2d: scale, then rotate (degrees, counter-clockwise), then translate."""

    scale: tuple[float, float] = (1.0, 1.0)
    rotation: float = 0.0
    translation: tuple[float, float] = (0.0, 0.0)

    @property
    def matrix(self) -> Array:
        """(3, 3) for columns (s, t, 1)."""
        matrix = np.eye(3)
        matrix[:2, :2] = in_plan(math.radians(self.rotation)) @ np.diag(self.scale)
        matrix[:2, 2] = self.translation
        return matrix


@dataclass(frozen=True)
class Texture:
    """A picture that is looked up by texture coordinates (UsdUVTexture and what feeds it).

    A texel's value is ``decode(pixel) * scale + bias``, of which ``channel`` is taken.

    Attributes:
        file: Read: the absolute path, which may lie inside a package (``/x/y.usdz[0/z.png]``).
            Authored: the asset path as it shall stand in the layer.
        channel: ``rgb`` for colours and normals, or one channel, or three in another order.
        color_space: ``sRGB`` pixels are decoded to linear (alpha never is), ``raw`` ones are not.
        scale: Factor of r, g, b, a; where colours stand in another order, of what is taken.
        bias: Offset of the same.
        wrap_s: What lies beyond 0..1 in s.
        wrap_t: What lies beyond 0..1 in t.
        primvar: Name of the texture coordinates.
        uv_scale: Factor of the texture coordinates, applied first.
        uv_rotation: Rotation of the texture coordinates, degrees counter-clockwise, applied second.
        uv_translation: Offset of the texture coordinates, applied last.
        fallback: Value of the same where the picture cannot be read; None: the default of what it
            drives.
    """

    file: str
    channel: Channel = "rgb"
    color_space: ColorSpace = "raw"
    scale: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    bias: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    wrap_s: Wrap = "repeat"
    wrap_t: Wrap = "repeat"
    primvar: str = names.ST
    uv_scale: tuple[float, float] = (1.0, 1.0)
    uv_rotation: float = 0.0
    uv_translation: tuple[float, float] = (0.0, 0.0)
    fallback: tuple[float, float, float, float] | None = None

    @property
    def is_shuffled(self) -> bool:
        """Whether its colours stand in another order, which a UsdUVTexture cannot say."""
        return len(self.channel) > 1 and self.channel != "rgb"

    @property
    def uv_matrix(self) -> Array:
        """(3, 3) from the primvar's coordinates to the picture's, for columns (s, t, 1).

        s = 0 is the picture's left edge, t = 0 its lower one.
        """
        return UvTransform(self.uv_scale, self.uv_rotation, self.uv_translation).matrix


def taken(texture: Texture, numbers: Sequence[float], channels: int) -> tuple[float, ...]:
    """A texture's scale, bias or fallback, of so many channels that are taken of it."""
    which = range(channels) if texture.is_shuffled else chosen(texture.channel, channels)
    return tuple(numbers[index] for index in which)


@dataclass(frozen=True)
class PreviewSurface:
    """The inputs of a UsdPreviewSurface; the defaults are the specification's.

    Attributes:
        base_color: ``diffuseColor``, scene-linear Rec.709.
        metallic: 0 dielectric to 1 metal; without meaning when ``specular`` is given.
        roughness: Perceptual roughness; GGX alpha is its square.
        specular: ``specularColor`` of the specular workflow; None in the metallic workflow.
        opacity: 1 opaque to 0 clear.
        opacity_threshold: Above 0, opacity is a mask: at least this is opaque, the rest absent.
        opacity_mode: ``transparent`` keeps the specular reflection of clear parts, ``presence``
            does not.
        ior: Index of refraction.
        emissive: ``emissiveColor``, nits of each primary.
        normal: Tangent-space normal map or constant.
        clearcoat: Weight of a second, white specular lobe.
        clearcoat_roughness: Its perceptual roughness.
        occlusion: Baked ambient occlusion; a path tracer has no use for it.
        displacement: How far points move along their normals, in units of the stage; only for
            callers that move them.
        transmission: Part of the light that leaves the other side diffusely, in the hue of the
            base colour; ours (`names.MATERIAL_TRANSMISSION`). Above 0, ``opacity`` is 1, and what
            is authored as opacity stands in for it elsewhere.
        f0: Reflectance at normal incidence of OpenRooms' microfacet model, below 1; ours
            (`names.MATERIAL_F0`). Given, the surface is of that model, with its base colour,
            metallic, roughness, normal, opacity, emission and transmission; what else stands here
            shows it to those who do not know it, and ``ior`` is authored as `ior_of`. None: it is
            a UsdPreviewSurface.
        pane: What the glass of a thin clear pane lets through at normal incidence, by primary; ours
            (`names.MATERIAL_PANE`). Given, the surface is that pane, of ``ior``; its base colour
            and opacity, below 1, show it elsewhere. None if there is none.
        painted: (field, primvar) of those inputs that each mesh has in a primvar: ``base_color``
            of colours, others of numbers. What stands in the field is for meshes without it.
    """

    base_color: Color | Texture = (0.18, 0.18, 0.18)
    metallic: float | Texture = 0.0
    roughness: float | Texture = 0.5
    specular: Color | Texture | None = None
    opacity: float | Texture = 1.0
    opacity_threshold: float = 0.0
    opacity_mode: Literal["transparent", "presence"] = "transparent"
    ior: float = 1.5
    emissive: Color | Texture = (0.0, 0.0, 0.0)
    normal: Color | Texture = (0.0, 0.0, 1.0)
    clearcoat: float | Texture = 0.0
    clearcoat_roughness: float | Texture = 0.01
    occlusion: float | Texture = 1.0
    displacement: float | Texture = 0.0
    transmission: float = 0.0
    f0: float | None = None
    pane: Color | None = None
    painted: tuple[tuple[str, str], ...] = ()


BARE: Final = PreviewSurface(
    base_color=(0.5, 0.5, 0.5),
    painted=(("base_color", "displayColor"), ("opacity", "displayOpacity")),
)
"""What meshes show without a readable material.

Without colours of their own they are grey, as in Storm, hdEmbree and hdPrman.
"""
SHUFFLED: Final = "its channels in another order are read as r, g, b"
"""What is lost where a UsdUVTexture stands for a texture that is shuffled."""
BLACK: Final = (0.0, 0.0, 0.0, 1.0)
"""The fallback of a UsdUVTexture whose use is unknown."""


def completed(surface: PreviewSurface) -> PreviewSurface:
    """A surface whose textures fall back on the default of what they drive, if on nothing else."""
    found: dict[str, Any] = {}
    for item in fields(surface):
        value = getattr(surface, item.name)
        if isinstance(value, Texture) and value.fallback is None:
            usual = item.default if item.default is not None else BLACK[:3]
            rgba = (*usual, 1.0) if isinstance(usual, tuple) else (usual,) * 4
            found[item.name] = replace(value, fallback=rgba)
    return replace(surface, **found)
