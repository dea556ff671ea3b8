"""How the surface shaders of MaterialX map to our inputs: declarative tables.

Names as in the specifications of Standard Surface (Autodesk), OpenPBR 1.1, glTF 2.0 and
UsdPreviewSurface 2.6.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final


@dataclass(frozen=True)
class Shading:
    """What becomes of the inputs of a surface shader; those that stand nowhere are reported.

    Attributes:
        inputs: The shader's input for each textured field of `PreviewSurface`.
        base_weight: Factor of the base colour.
        ior: Index of refraction.
        specular_weight: Factor of the dielectric reflection.
        groups: The weight of each lobe, by the beginning of its inputs' names: without weight, the
            other inputs of the lobe mean nothing.
        harmless: Inputs whose loss nobody can see: they turn what is left out or isotropic here.
    """

    inputs: Mapping[str, str]
    base_weight: str = ""
    ior: str = "ior"
    specular_weight: str = ""
    groups: Mapping[str, str] = field(default_factory=dict)
    harmless: frozenset[str] = frozenset()


SHADINGS: Final[dict[str, Shading]] = {
    "standard_surface": Shading(
        inputs={
            "base_color": "base_color",
            "metallic": "metalness",
            "roughness": "specular_roughness",
            "opacity": "opacity",
            "normal": "normal",
            "clearcoat": "coat",
            "clearcoat_roughness": "coat_roughness",
        },
        base_weight="base",
        ior="specular_IOR",
        specular_weight="specular",
        groups={
            "transmission": "transmission",
            "subsurface": "subsurface",
            "sheen": "sheen",
            "coat": "coat",
            "emission": "emission",
            "thin_film": "thin_film_thickness",
        },
        harmless=frozenset({"tangent", "specular_rotation", "coat_rotation"}),
    ),
    "open_pbr_surface": Shading(
        inputs={
            "base_color": "base_color",
            "metallic": "base_metalness",
            "roughness": "specular_roughness",
            "opacity": "geometry_opacity",
            "normal": "geometry_normal",
            "clearcoat": "coat_weight",
            "clearcoat_roughness": "coat_roughness",
        },
        base_weight="base_weight",
        ior="specular_ior",
        specular_weight="specular_weight",
        groups={
            "transmission": "transmission_weight",
            "subsurface": "subsurface_weight",
            "fuzz": "fuzz_weight",
            "coat": "coat_weight",
            "thin_film": "thin_film_weight",
            "emission": "emission_luminance",
        },
        harmless=frozenset({"geometry_tangent", "geometry_coat_tangent"}),
    ),
    "gltf_pbr": Shading(
        inputs={
            "base_color": "base_color",
            "metallic": "metallic",
            "roughness": "roughness",
            "opacity": "alpha",
            "normal": "normal",
            "clearcoat": "clearcoat",
            "clearcoat_roughness": "clearcoat_roughness",
            "occlusion": "occlusion",
        },
        specular_weight="specular",
        groups={
            "transmission": "transmission",
            "iridescence": "iridescence",
            "clearcoat": "clearcoat",
            "attenuation": "transmission",
        },
        harmless=frozenset({"tangent", "alpha_mode", "alpha_cutoff", "emissive_strength"}),
    ),
    "UsdPreviewSurface": Shading(
        inputs={
            "base_color": "diffuseColor",
            "metallic": "metallic",
            "roughness": "roughness",
            "opacity": "opacity",
            "normal": "normal",
            "clearcoat": "clearcoat",
            "clearcoat_roughness": "clearcoatRoughness",
            "occlusion": "occlusion",
        },
        harmless=frozenset({"opacityMode", "opacityThreshold"}),
    ),
}
