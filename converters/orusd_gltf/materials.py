"""Surfaces as glTF's metallic-roughness materials."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom, UsdShade

from openrooms_usd.usd.arrays import array_of, flattened
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import bound_material, material_key, parts_by_material
from openrooms_usd.usd.shading.surfaces import BARE, Color, PreviewSurface, Texture, completed
from openrooms_usd.usd.shapes.meshes import PlacedMesh
from orusd_gltf.document import Document, Object, number, numbers
from orusd_gltf.geometry import Coordinates
from orusd_gltf.pictures import Pictures

# Viewers that know nothing of transmission blend clear glass with this much of itself, and those
# that know it see its reflections as strong.
_GLASS_ALPHA: Final = 0.3
# What glTF takes without being told.
_IOR: Final = 1.5
# All that single precision holds.
_BRIGHTEST_NITS: Final = 3e38
# Sets of texture coordinates that every reader has.
_MOST_SETS: Final = 2


@dataclass(frozen=True)
class Material:
    """A material of the document.

    Attributes:
        number: Its number.
        sets: The texture coordinates that its primitives need, in their order.
        normal_set: Which of them its normal map is looked up by; None without one.
        losses: What could not be kept, in words.
    """

    number: int
    sets: tuple[Coordinates, ...]
    normal_set: int | None
    losses: tuple[str, ...]


@dataclass
class _Draft:
    """A material while it is made."""

    document: Document
    said: Object
    sets: list[Coordinates] = field(default_factory=list)
    losses: list[str] = field(default_factory=list)

    def info(self, number: int, texture: Texture, **more: Any) -> Object:
        """What refers to a texture: its number, and its set of coordinates."""
        wanted = coordinates(texture)
        if wanted not in self.sets:
            self.sets.append(wanted)
        place = self.sets.index(wanted)
        return {"index": number, **({"texCoord": place} if place else {}), **more}

    def extend(self, name: str, value: Object) -> None:
        self.document.use(name)
        self.said.setdefault("extensions", {})[name] = value


def coordinates(texture: Texture) -> Coordinates:
    """The coordinates that a texture is looked up by."""
    return Coordinates(texture.primvar, tuple(texture.uv_matrix.ravel().tolist()))


def add_material(
    document: Document,
    pictures: Pictures,
    preview: PreviewSurface,
    *,
    name: str,
    double_sided: bool = False,
    radiance: tuple[float, ...] | None = None,
    brighter: float = 1.0,
) -> Material:
    """Add a material to a document.

    Args:
        document: Receives it.
        pictures: Make its textures.
        preview: What the stage says.
        name: Its name.
        double_sided: Whether the back of what shows it is seen.
        radiance: Nits that it emits in place of what its surface says; None for that.
        brighter: What its emission is multiplied by.
    """
    draft = _Draft(document, {"name": name})
    _add_base(draft, pictures, preview)
    _add_normal(draft, pictures, preview)
    _add_emission(draft, pictures, preview.emissive if radiance is None else radiance, brighter)
    _add_layers(draft, preview)
    if double_sided:
        draft.said["doubleSided"] = True
    if len(draft.sets) > _MOST_SETS:
        draft.losses.append(f"more than {_MOST_SETS} sets of texture coordinates: few readers do")
    draft.losses += [said for found, said in _LOST if found(preview)]
    found = document.shared("materials", draft.said)
    normal = preview.normal
    normal_set = draft.sets.index(coordinates(normal)) if isinstance(normal, Texture) else None
    return Material(found, tuple(draft.sets), normal_set, tuple(draft.losses))


def _add_base(draft: _Draft, pictures: Pictures, preview: PreviewSurface) -> None:
    base: Object = {}
    factor, alpha = _base_color(draft, pictures, preview, base)
    base |= {"baseColorFactor": numbers([*factor, alpha])} if {*factor, alpha} != {1.0} else {}
    _add_response(draft, pictures, preview, base)
    draft.said["pbrMetallicRoughness"] = base


def _base_color(
    draft: _Draft, pictures: Pictures, preview: PreviewSurface, base: Object
) -> tuple[tuple[float, ...], float]:
    """The factors of colour and alpha; the texture goes into ``base``."""
    color, opacity = preview.base_color, preview.opacity
    textured = opacity if isinstance(opacity, Texture) else None
    (alpha,) = (1.0,) if isinstance(opacity, Texture) else _unit((opacity,))
    if preview.opacity_threshold > 0.0:
        cutoff = number(min(preview.opacity_threshold, 1.0))
        draft.said |= {"alphaMode": "MASK", "alphaCutoff": cutoff}
    elif textured is not None or alpha < 1.0:
        draft.said["alphaMode"] = "BLEND"
    if _is_glass(preview):
        draft.extend("KHR_materials_transmission", {"transmissionFactor": number(1.0 - alpha)})
        alpha = max(alpha, _GLASS_ALPHA)
    if not isinstance(color, Texture) and textured is None:
        return _unit(color), alpha
    placed = pictures.base_color(color, textured)
    draft.losses += placed.losses
    shown = color if isinstance(color, Texture) else textured
    assert shown is not None
    if textured is not None and coordinates(textured) != coordinates(shown):
        draft.losses.append("opacity takes the texture coordinates of the colour")
    base["baseColorTexture"] = draft.info(placed.number, shown)
    return placed.factor, alpha


def _unit(values: tuple[float, ...]) -> tuple[float, ...]:
    """Numbers as glTF allows them: within 0 and 1."""
    return tuple(min(max(float(value), 0.0), 1.0) for value in values)


def _is_glass(preview: PreviewSurface) -> bool:
    """Whether light passes straight through, and is reflected all the same."""
    clear = not isinstance(preview.opacity, Texture) and preview.opacity < 1.0
    solid = preview.opacity_threshold <= 0.0 and preview.opacity_mode == "transparent"
    return clear and solid


def _add_response(draft: _Draft, pictures: Pictures, preview: PreviewSurface, base: Object) -> None:
    """Roughness, metallic and occlusion."""
    # Without metals where the specular colour is given.
    metallic = 0.0 if preview.specular is not None else preview.metallic
    roughness = preview.roughness
    occlusion = preview.occlusion if isinstance(preview.occlusion, Texture) else None
    textures = [x for x in (roughness, metallic, occlusion) if isinstance(x, Texture)]
    if not textures:
        base["metallicFactor"], base["roughnessFactor"] = numbers(_unit((metallic, roughness)))  # type: ignore[arg-type]
        return
    if len({coordinates(texture) for texture in textures}) > 1:
        draft.losses.append("roughness, metallic and occlusion share one set of coordinates")
    placed = pictures.metallic_roughness(metallic, roughness, occlusion)
    draft.losses += placed.losses
    info = draft.info(placed.number, textures[0])
    _, rough, metal = placed.factor
    base["metallicRoughnessTexture"] = info
    base |= {"metallicFactor": number(metal)} if metal != 1.0 else {}
    base |= {"roughnessFactor": number(rough)} if rough != 1.0 else {}
    if occlusion is not None:
        draft.said["occlusionTexture"] = dict(info)


def _add_normal(draft: _Draft, pictures: Pictures, preview: PreviewSurface) -> None:
    if not isinstance(preview.normal, Texture):
        return
    placed = pictures.normal(preview.normal)
    draft.losses += placed.losses
    scale = {"scale": number(placed.factor[0])} if placed.factor[0] != 1.0 else {}
    draft.said["normalTexture"] = draft.info(placed.number, preview.normal, **scale)


def _add_emission(
    draft: _Draft, pictures: Pictures, emissive: tuple[float, ...] | Texture, brighter: float
) -> None:
    """Nits: a factor of at most one, and the strength that it is a part of."""
    if isinstance(emissive, Texture):
        placed = pictures.emission(emissive)
        draft.losses += placed.losses
        draft.said["emissiveTexture"] = draft.info(placed.number, emissive)
        emissive = placed.factor
    emissive = tuple(min(max(value * brighter, 0.0), _BRIGHTEST_NITS) for value in emissive)
    strength = max(emissive)
    if strength <= 0.0:
        draft.said.pop("emissiveTexture", None)
        return
    strength = max(strength, 1.0)
    draft.said["emissiveFactor"] = numbers([value / strength for value in emissive])
    if strength > 1.0:
        strong = {"emissiveStrength": number(strength)}
        draft.extend("KHR_materials_emissive_strength", strong)


def _add_layers(draft: _Draft, preview: PreviewSurface) -> None:
    """What metallic-roughness has no word for: extensions that a reader may pass over."""
    ior = number(max(preview.ior, 1.0))
    if preview.specular is None and ior != _IOR:
        draft.extend("KHR_materials_ior", {"ior": ior})
    if preview.specular is not None and not isinstance(preview.specular, Texture):
        # The colour is the reflectance at normal incidence; an ior of 0 leaves it as it is.
        color = {"specularColorFactor": numbers(_unit(preview.specular))}
        draft.extend("KHR_materials_ior", {"ior": 0.0})
        draft.extend("KHR_materials_specular", color)
    if not isinstance(preview.clearcoat, Texture) and preview.clearcoat > 0.0:
        rough = preview.clearcoat_roughness
        coat: Object = {"clearcoatFactor": number(min(preview.clearcoat, 1.0))}
        rough = 0.01 if isinstance(rough, Texture) else rough
        (coat["clearcoatRoughnessFactor"],) = numbers(_unit((rough,)))
        draft.extend("KHR_materials_clearcoat", coat)


_LOST: Final[tuple[tuple[Callable[[PreviewSurface], bool], str], ...]] = (
    (lambda p: p.transmission > 0.0, "light that it lets through diffusely is left out"),
    (lambda p: isinstance(p.clearcoat, Texture), "a textured clearcoat is left out"),
    (
        lambda p: isinstance(p.clearcoat_roughness, Texture),
        "a textured clearcoatRoughness is replaced by 0.01",
    ),
    (lambda p: isinstance(p.specular, Texture), "a textured specular colour is left out"),
    (
        lambda p: not isinstance(p.normal, Texture) and p.normal != (0.0, 0.0, 1.0),
        "a constant normal is left out",
    ),
)


Rows = NDArray[np.int32]


@dataclass(frozen=True)
class ReadMaterial:
    """A material as it is read.

    Attributes:
        key: The same for all instances of one prototype, which show it under many paths.
        name: The prim's name.
        path: The prim that showed it first; empty where there is no material.
        preview: What it says.
        losses: What could not be read, in words.
    """

    key: str
    name: str
    path: str
    preview: PreviewSurface
    losses: tuple[str, ...]


@dataclass
class Looks:
    """Reads the materials of meshes."""

    _known: dict[str, ReadMaterial] = field(default_factory=dict)

    def parts(self, mesh: PlacedMesh) -> list[tuple[Rows, ReadMaterial]]:
        """(rows of triangles, their look) for each part of a mesh with a look of its own."""
        prim = mesh.prim
        found = parts_by_material(prim, mesh.mesh.faces, bound_material(prim))
        return [(rows, self._look(prim, material)) for rows, material in found]

    def _look(self, prim: Usd.Prim, material: UsdShade.Material | None) -> ReadMaterial:
        if material is None:
            color, reason = _display_color(prim)
            preview = PreviewSurface(base_color=color)
            return ReadMaterial(f"{color}", "no_material", "", preview, (reason,))
        own, key = material.GetPrim(), material_key(material)
        if key not in self._known:
            preview, losses = read_preview_surface(material)
            surface = completed(preview)
            self._known[key] = ReadMaterial(key, own.GetName(), str(own.GetPath()), surface, losses)
        return self._known[key]


def _display_color(prim: Usd.Prim) -> tuple[tuple[float, float, float], str]:
    primvar = UsdGeom.Gprim(prim).GetDisplayColorPrimvar()
    values = array_of(flattened(primvar), np.float64, 3)
    if not len(values) or not np.isfinite(values).all():
        return cast(Color, BARE.base_color), "it has no material: grey is used"
    red, green, blue = np.clip(values.mean(axis=0), 0.0, 1.0).tolist()
    return (red, green, blue), "it has no material: its displayColor is used"
