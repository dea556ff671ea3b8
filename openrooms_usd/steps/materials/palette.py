"""The palette: all swatches of a room as textures in files and as materials in USD."""

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Final

from pxr import Gf, Sdf, Usd, UsdShade

from openrooms_usd import names
from openrooms_usd.description.substances import Substance
from openrooms_usd.errors import InputError
from openrooms_usd.library import textures
from openrooms_usd.library.friction import physics_of
from openrooms_usd.library.ownmaterials import OwnMaterial, publish, read_material
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.materials.appearance import Appearance, Color, appearance_of
from openrooms_usd.threads import mapped
from openrooms_usd.usd.shading import physics
from openrooms_usd.usd.shading.materials import PreviewSurface, Texture, define_preview_surface
from openrooms_usd.usd.shading.surfaces import NORMAL_BIAS, NORMAL_SCALE

# Soda-lime glass (M. Rubin, Solar Energy Materials 12, 1985).
_GLASS_IOR: Final = 1.52
TEXTURES: Final = "textures"
_Types = Sdf.ValueTypeNames
# OpenRooms' reflectance at normal incidence.
F0: Final = 0.05
# Families of more than this length have twice the texels along each side, metres, and those of no
# more than that half as many, unless they show threads: a texel is then about a millimetre.
_LARGE_FAMILY_M: Final = 1.0
_SMALL_FAMILY_M: Final = 0.3
# A pattern needs that many, however small the family.
_FEWEST_TEXELS: Final = 256


@dataclass(frozen=True)
class Swatch:
    """A material, by all that determines it.

    Attributes:
        substance: What it is.
        family: The family of its textures; None for a constant and for the user's own.
        number: Which material of the family.
        title: How it is called where it has no family, for people.
        color: Mean base colour, scene-linear Rec.709; None: the material's own.
        roughness: Mean perceptual roughness; None: the material's own.
        metallic: Of a constant.
        size: Width that one repeat of the textures covers, metres; None: the usual one.
        file: The user's own material, relative to the description.
        across: Whether its grain runs along s rather than t.
        transmission: Part of the light that passes diffusely.
        pane: Transmittance of a clear pane's glass, by primary; None if it is not a clear pane.
        tint: Factors of the base colour.
        wear: Factor of the roughness.
        place: Where on the material it is cut from, in repeats along s and t.
    """

    substance: Substance
    family: str | None = None
    number: int = 0
    title: str = ""
    color: Color | None = None
    roughness: float | None = None
    metallic: float = 0.0
    size: float | None = None
    file: str | None = None
    across: bool = False
    transmission: float = 0.0
    pane: Color | None = None
    tint: Color = (1.0, 1.0, 1.0)
    wear: float = 1.0
    place: tuple[float, float] = (0.0, 0.0)

    @property
    def turned(self) -> "Swatch":
        """The same with its grain along s, where it has a grain."""
        grain = self.family is not None and textures.family_of(self.family).grain
        return replace(self, across=True) if grain else self

    def cut(self, place: tuple[float, float], tint: Color) -> "Swatch":
        """The same of another piece: cut from elsewhere, a little lighter or redder."""
        if self.family is None:
            return self
        red, green, blue = (round(a * b, 4) for a, b in zip(self.tint, tint, strict=True))
        return replace(self, place=place, tint=(red, green, blue))

    @property
    def is_scaled(self) -> bool:
        """Whether it is brighter, tinted or rougher than it was made."""
        return self.tint != (1.0, 1.0, 1.0) or self.wear != 1.0

    def textures(self, resolution: int) -> textures.Material | None:
        """Its textures in the library.

        Args:
            resolution: Texels along each side; large families have twice as many, small ones half.
        """
        if self.family is None:
            return None
        size = self.size or textures.family_of(self.family).repeat
        texels = resolution * 2 if size > _LARGE_FAMILY_M else resolution
        if size <= _SMALL_FAMILY_M and self.substance != "fabric":
            texels = min(resolution, max(resolution // 2, _FEWEST_TEXELS))
        return textures.Material(self.family, self.number, self.color, self.roughness, texels, size)

    @property
    def digest(self) -> str:
        """8 hexadecimal digits of what is said of it, which other code does not change.

        Prims are named by it, and people's edits by prims; so nothing that is left as it is counts.
        """
        said = {
            item.name: value
            for item in fields(self)
            if (value := getattr(self, item.name)) != item.default
        }
        text = json.dumps(said, sort_keys=True, default=float)
        return hashlib.sha256(text.encode()).hexdigest()[:8]


class Palette:
    """Names, publishes and defines the swatches of a room, each once."""

    def __init__(self, context: StepContext) -> None:
        self._context = context
        self._resolution = context.room.materials.resolution
        self._own: dict[tuple[str, float | None], OwnMaterial] = {}
        self._seen: dict[Swatch, Appearance] = {}

    def name(self, swatch: Swatch) -> str:
        """The name of its Material prim: the same whatever its textures have become."""
        if swatch.file is not None:
            own = self._own_material(swatch)
            title = "".join(c if c.isascii() and c.isalnum() else "_" for c in own.name)
            return f"own_{title}_{swatch.digest}"
        if swatch.family is None:
            return f"{swatch.title or swatch.substance}_{swatch.digest}"
        return f"{swatch.family}_{swatch.number}_{swatch.digest}"

    def content(self, swatch: Swatch) -> str:
        """What its Material holds that its name does not say, in few letters."""
        if swatch.file is not None:
            return self._own_material(swatch).identifier
        sets = swatch.textures(self._resolution)
        return sets.digest if sets else ""

    def publish(self, swatches: Iterable[Swatch]) -> None:
        """Write the textures that are not there yet, each once.

        Raises:
            InputError: A material of the user's own cannot be read.
            OutputError: A file cannot be written.
        """
        distinct = list(dict.fromkeys(swatches))
        for swatch in distinct:
            if swatch.file is not None:
                publish(self._own_material(swatch), self._context.keep, TEXTURES)
        sets = {s for swatch in distinct if (s := swatch.textures(self._resolution))}
        missing = [s for s in sorted(sets, key=_stem) if not self._keep_files(s)]
        folder = self._context.folder / TEXTURES
        for _ in mapped(
            lambda s: textures.cached(s, folder, _stem(s)), missing, self._context.workers
        ):
            pass

    def _keep_files(self, wanted: textures.Material) -> bool:
        """Name the files of a set as needed; whether all of them are there."""
        files = [
            textures.map_file(Path(TEXTURES), _stem(wanted), item)
            for item in textures.rendered_maps(wanted.name)
        ]
        kept = [self._context.keep(file.as_posix()) for file in files]
        return all(file.is_file() for file in kept)

    def _own_material(self, swatch: Swatch) -> OwnMaterial:
        key = (str(swatch.file), swatch.size)
        if key not in self._own:
            try:
                found = read_material(self._context.source / key[0], physical_size=swatch.size)
            except InputError as error:
                error.place = error.place or "materials"
                raise
            self._context.notes.extend(f"{key[0]}: {loss}" for loss in found.losses)
            self._own[key] = found
        return self._own[key]

    def define(
        self, stage: Usd.Stage, path: Sdf.Path, swatch: Swatch, folder: str
    ) -> UsdShade.Material:
        """Define the Material of a swatch.

        Args:
            stage: Where; its edit target receives everything.
            path: The Material's path.
            swatch: What it is; it must be published.
            folder: The textures' folder, relative to the layer that is written.
        """
        material = define_preview_surface(stage, path, self._surface(swatch, folder))
        prim = material.GetPrim()
        # Without the plugin of our schemas this is what applying one writes.
        prim.AddAppliedSchema(names.MATERIAL_API)
        _set(prim, names.MATERIAL_CATEGORY, _Types.Token, swatch.substance)
        if swatch.family is not None:
            _set(prim, names.MATERIAL_FAMILY, _Types.Token, swatch.family)
            _set(prim, names.MATERIAL_NUMBER, _Types.Int, swatch.number)
        own = swatch.file is not None
        terms = self._own_material(swatch).licence if own else names.LICENCE
        prim.SetAssetInfoByKey(names.LICENCE_KEY, terms)
        if (size := self._size(swatch)) is not None:
            _set(prim, names.MATERIAL_SIZE, _Types.Float2, Gf.Vec2f(*size))
        seen = self._appearance(swatch)
        physics.author(prim, physics_of(swatch.substance, seen.albedo, seen.roughness))
        return material

    def _size(self, swatch: Swatch) -> tuple[float, float] | None:
        if swatch.file is not None:
            own = self._own_material(swatch)
            return own.size if own.textures else None
        sets = swatch.textures(self._resolution)
        return (sets.size or 1.0,) * 2 if sets else None

    def _appearance(self, swatch: Swatch) -> Appearance:
        alike = replace(swatch, across=False, place=(0.0, 0.0))
        if alike not in self._seen:
            self._seen[alike] = self._looked_at(alike)
        return self._seen[alike]

    def _looked_at(self, swatch: Swatch) -> Appearance:
        if swatch.is_scaled:
            plain = self._appearance(replace(swatch, tint=(1.0, 1.0, 1.0), wear=1.0))
            return plain.times(*_factors(swatch, plain))
        return appearance_of(self._surface(swatch, str(self._context.folder / TEXTURES)))

    def _surface(self, swatch: Swatch, folder: str) -> PreviewSurface:
        if swatch.is_scaled:
            plain = replace(swatch, tint=(1.0, 1.0, 1.0), wear=1.0)
            return _scaled(self._surface(plain, folder), swatch, self._appearance(plain))
        if swatch.file is not None:
            return _ours(self._own_material(swatch).in_metres(folder, across=swatch.across))
        sets = swatch.textures(self._resolution)
        return _constant(swatch) if sets is None else _textured(swatch, sets, folder)


def _stem(wanted: textures.Material) -> str:
    """How the files of a set begin: rooms that have the same set have the same files."""
    return f"{wanted.name}_{wanted.number}_{wanted.digest[:8]}"


def _constant(swatch: Swatch) -> PreviewSurface:
    usual = PreviewSurface()
    return PreviewSurface(
        base_color=usual.base_color if swatch.color is None else swatch.color,
        roughness=usual.roughness if swatch.roughness is None else swatch.roughness,
        metallic=swatch.metallic,
        transmission=swatch.transmission,
        f0=F0 if swatch.pane is None else None,
        ior=PreviewSurface.ior if swatch.pane is None else _GLASS_IOR,
        pane=swatch.pane,
    )


def _textured(swatch: Swatch, sets: textures.Material, folder: str) -> PreviewSurface:
    repeats = 1.0 / (sets.size or 1.0)
    maps = {
        item: Texture(
            # The folder is anchored, which a path would forget.
            f"{folder}/{textures.map_file(Path(), _stem(sets), item).name}",
            uv_scale=(repeats, repeats),
            uv_rotation=90.0 if swatch.across else 0.0,
            uv_translation=swatch.place,
        )
        for item in textures.rendered_maps(sets.name)
    }
    even = textures.family_of(sets.name).metallic
    return PreviewSurface(
        base_color=replace(maps["albedo"], color_space="sRGB"),
        roughness=replace(maps["roughness"], channel="r"),
        normal=replace(maps["normal"], scale=NORMAL_SCALE, bias=NORMAL_BIAS),
        metallic=replace(maps["metallic"], channel="r") if even is None else even,
        transmission=swatch.transmission,
        f0=F0,
    )


def _ours(own: PreviewSurface) -> PreviewSurface:
    """A user's material in our model, unless it says what only UsdPreviewSurface can."""
    usual = PreviewSurface()
    plain = (own.specular, own.clearcoat, own.ior) == (None, usual.clearcoat, usual.ior)
    return replace(own, f0=F0) if plain and own.f0 is None else own


def _scaled(surface: PreviewSurface, swatch: Swatch, seen: Appearance) -> PreviewSurface:
    """A surface times the factors of its swatch, as far as it stays below one everywhere."""
    (red, green, blue), wear = _factors(swatch, seen)
    color, roughness = surface.base_color, surface.roughness
    if isinstance(color, Texture):
        color = _times(color, (red, green, blue, 1.0))
    else:
        color = (color[0] * red, color[1] * green, color[2] * blue)
    if isinstance(roughness, Texture):
        roughness = _times(roughness, (wear, wear, wear, 1.0))
    else:
        roughness = roughness * wear
    return replace(surface, base_color=color, roughness=roughness)


def _factors(swatch: Swatch, seen: Appearance) -> tuple[Color, float]:
    """Of base colour and roughness, so that neither is above one anywhere."""
    red, green, blue = (
        min(factor, 1.0 / max(top, 1e-3))
        for factor, top in zip(swatch.tint, seen.brightest, strict=True)
    )
    return (red, green, blue), min(swatch.wear, 1.0 / max(seen.roughest, 1e-3))


def _times(texture: Texture, factors: tuple[float, float, float, float]) -> Texture:
    r, g, b, a = (scale * factor for scale, factor in zip(texture.scale, factors, strict=True))
    r0, g0, b0, a0 = (bias * factor for bias, factor in zip(texture.bias, factors, strict=True))
    return replace(texture, scale=(r, g, b, a), bias=(r0, g0, b0, a0))


def _set(prim: Usd.Prim, name: str, kind: Sdf.ValueTypeName, value: object) -> None:
    prim.CreateAttribute(name, kind, custom=False).Set(value)
