"""How surfaces are shown where only a colour or a picture can be said."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Final, cast

import numpy as np

from openrooms_usd.arrays import Floats
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.physics.world import Visual, World
from openrooms_usd.usd.shading.surfaces import BARE, PreviewSurface, Texture

if TYPE_CHECKING:
    from pxr import Usd

Color = tuple[float, float, float]
# (prim path, outcome, reason), as `convert.Report` takes them.
Loss = tuple[str, str, str]

_WHITE: Final = (1.0, 1.0, 1.0)
# What is not shown, and how people call it.
_UNSEEN: Final = {"normal": "normal map", "emissive": "emission", "clearcoat": "clearcoat"}


@dataclass(frozen=True)
class RobotMaterial:
    """A material as robots' formats know it.

    Attributes:
        color: Red, green, blue as screens take them (sRGB); white where there is a picture.
        opacity: 1 opaque to 0 clear.
        roughness: Perceptual roughness.
        metallic: 0 dielectric to 1 metal.
        texture: The picture of its base colour, or None.
    """

    color: Color
    opacity: float = 1.0
    roughness: float = 0.5
    metallic: float = 0.0
    texture: Texture | None = None

    def coordinates(self, visual: Visual) -> Floats | None:
        """(M, 3, 2) where each corner lies in the picture, which repeats; None without one.

        Ours are in metres, and the size of the picture is in its mapping: here both are one. They
        are moved by whole repeats, near zero, where no renderer loses digits.
        """
        if self.texture is None:
            return None
        st = visual.mesh.uvs.get(self.texture.primvar, visual.mesh.st)
        if st is None:
            return None
        matrix = self.texture.uv_matrix
        placed = st.astype(np.float64) @ matrix[:2, :2].T + matrix[:2, 2]
        if self.texture.wrap_s == "repeat" and self.texture.wrap_t == "repeat":
            placed -= np.floor(placed.min(axis=(0, 1)))
        return np.asarray(placed, dtype=np.float32)


@dataclass(frozen=True)
class Looks:
    """What materials become, by the paths of their prims, and what is lost."""

    looks: Mapping[str, RobotMaterial]
    losses: tuple[Loss, ...]


def read_looks(stage: "Usd.Stage", world: World) -> Looks:
    """The looks of all visuals of a world.

    Args:
        stage: The stage that the world was read from.
        world: Its visuals name the materials.
    """
    from pxr import UsdShade

    from openrooms_usd.usd.shading.materialreader import read_preview_surface

    visuals = (v for body in world.bodies for link in body.links for v in link.visuals)
    looks: dict[str, RobotMaterial] = {}
    losses: list[Loss] = []
    for path in dict.fromkeys(visual.material for visual in visuals if visual.material):
        surface, lost = read_preview_surface(UsdShade.Material(stage.GetPrimAtPath(path)))
        looks[path] = look_of(surface)
        reasons = [*lost, *_reasons(surface)]
        losses.append(
            (path, "approximated", "; ".join(reasons)) if reasons else (path, "translated", "")
        )
    return Looks(looks, tuple(losses))


def look_of(surface: PreviewSurface) -> RobotMaterial:
    """The look of a preview surface."""
    base = surface.base_color
    color, texture = (_WHITE, base) if isinstance(base, Texture) else (_encoded(base), None)
    return RobotMaterial(
        color,
        opacity=_number(surface.opacity, 1.0),
        roughness=_number(surface.roughness, 0.5),
        metallic=_number(surface.metallic, 0.0),
        texture=texture,
    )


def _number(value: object, otherwise: float) -> float:
    return float(np.clip(value, 0.0, 1.0)) if isinstance(value, int | float) else otherwise


def _encoded(color: Color) -> Color:
    red, green, blue = srgb_from_linear(np.array(color)).tolist()
    return red, green, blue


PLAIN: Final = RobotMaterial(_encoded(cast(Color, BARE.base_color)))
"""What has no material, as screens take it."""


def _reasons(surface: PreviewSurface) -> list[str]:
    pictures = {
        item.name for item in fields(surface) if isinstance(getattr(surface, item.name), Texture)
    }
    reasons = [
        f"no picture of its {name}"
        for name in sorted(pictures & {"roughness", "metallic", "opacity"})
    ]
    for name, said in _UNSEEN.items():
        default = type(surface).__dataclass_fields__[name].default
        if getattr(surface, name) != default:
            reasons.append(f"no {said}")
    texture = surface.base_color
    if isinstance(texture, Texture) and {texture.wrap_s, texture.wrap_t} != {"repeat"}:
        reasons.append("its picture repeats")
    return reasons
