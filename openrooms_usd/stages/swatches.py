"""Swatches: materials that are fully determined, and their textures as files."""

import hashlib
import json
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Final

from pxr import Gf, Sdf, Usd, UsdShade

from openrooms_usd import __version__
from openrooms_usd.description.materials import Look
from openrooms_usd.library import textures
from openrooms_usd.library.finishes import FINISHES, Color
from openrooms_usd.stages.base import FORMAT, StageContext
from openrooms_usd.usd.materials import PreviewSurface, Texture, define_preview_surface
from openrooms_usd.usd.surfaces import NORMAL_BIAS, NORMAL_SCALE

TEXTURES: Final = "textures"


@dataclass(frozen=True)
class Swatch:
    """A material, by all that determines it.

    Attributes:
        family: Its family, or a word for people when it is a plain constant.
        variant: The variant of the family; None for a plain constant.
        color: Mean base colour, scene-linear Rec.709; None: drawn with the textures.
        roughness: Mean perceptual roughness; None: drawn with the textures.
        metallic: 0 or 1.
        draw: What the textures' generator is keyed by.
        across: Whether its grain runs along s rather than t.
        transmission: Part of the light that passes diffusely.
    """

    family: str
    variant: str | None
    color: Color | None
    roughness: float | None
    metallic: float = 0.0
    draw: tuple[str, ...] = ()
    across: bool = False
    transmission: float = 0.0

    @property
    def turned(self) -> "Swatch":
        """The same with its grain along s, where it has a grain."""
        return replace(self, across=True) if self.family == "wood" else self


def from_finish(context: StageContext, name: str, *key: str) -> Swatch:
    """The swatch of a finish: one of the few that the room has of it.

    Args:
        context: Its seed draws what the finish leaves open.
        name: A key of `FINISHES`.
        key: Names what it is for; the same key gives the same swatch.
    """
    finish = FINISHES[name]
    number = str(context.rng("materials", "choice", name, *key).integers(finish.choices))
    draw = ("materials", "finish", name, number)
    rng = context.rng(*draw)
    color = finish.colors[int(rng.integers(len(finish.colors)))] if finish.colors else None
    roughness = round(float(rng.uniform(*finish.roughness)), 3) if finish.roughness else None
    variants = finish.variants
    variant = variants[int(rng.integers(len(variants)))] if variants else None
    return Swatch(
        finish.family, variant, color, roughness, finish.metallic, draw,
        transmission=finish.transmission,
    )  # fmt: skip


def from_look(context: StageContext, look: Look, variants: dict[str, str], *key: str) -> Swatch:
    """The swatch of a look that the description asks for.

    Args:
        context: Its seed draws what the look leaves open.
        look: The look.
        variants: The variant to take of each family; where it has none, one is drawn.
        key: Names what it is for.
    """
    draw = ("materials", "look", *key)
    known = tuple(textures.FAMILIES[look.family])
    variant = variants.get(look.family) or known[int(context.rng(*draw).integers(len(known)))]
    return Swatch(look.family, variant, look.color, look.roughness, 0.0, draw)


class Palette:
    """All swatches of a room: their names, their textures, and their materials in USD."""

    def __init__(self, context: StageContext) -> None:
        self._context = context
        self._section = context.room.materials

    def stem(self, swatch: Swatch) -> str:
        """A name for its textures, by what determines them."""
        section = self._section
        textured = replace(swatch, across=False, metallic=0.0)
        parts = [
            __version__, FORMAT, self._context.room.seed, repr(textured),
            section.resolution, section.texture_size,
        ]  # fmt: skip
        digest = hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:8]
        return "_".join(filter(None, [swatch.family, swatch.variant, digest]))

    def name(self, swatch: Swatch) -> str:
        """The name of its Material prim."""
        return f"{self.stem(swatch)}{'_across' if swatch.across else ''}"

    def publish(self, swatches: Iterable[Swatch]) -> None:
        """Write the textures that are not there yet, each once.

        Raises:
            OutputError: A file cannot be written.
        """
        distinct = {self.stem(swatch): swatch for swatch in swatches if swatch.variant}
        missing = []
        for stem in distinct:
            files = [self._context.keep(f"{TEXTURES}/{stem}_{item}.png") for item in textures.MAPS]
            if not all(file.is_file() for file in files):
                missing.append(stem)
        with ThreadPoolExecutor(max(1, self._context.workers)) as pool:
            for _ in pool.map(lambda stem: self._write(distinct[stem], stem), missing):
                pass

    def _write(self, swatch: Swatch, stem: str) -> None:
        made = textures.make(
            swatch.family,
            self._context.rng(*swatch.draw, "texels"),
            color=swatch.color,
            roughness=swatch.roughness,
            resolution=self._section.resolution,
            physical_size=self._section.texture_size,
            variant=swatch.variant,
        )
        textures.write_set(made, self._context.folder / TEXTURES, stem)

    def define(
        self, stage: Usd.Stage, path: Sdf.Path, swatch: Swatch, folder: str
    ) -> UsdShade.Material:
        """Define the Material of a swatch.

        Args:
            stage: Where; its edit target receives everything.
            path: The Material's path.
            swatch: What it is.
            folder: The textures' folder, relative to the layer that is written.
        """
        textured = swatch.variant is not None
        surface = self._textured(swatch, folder) if textured else _constant(swatch)
        material = define_preview_surface(stage, path, surface)
        prim = material.GetPrim()
        # Without the plugin of our schemas this is what applying one writes.
        prim.AddAppliedSchema("OpenRoomsMaterialAPI")
        _set(prim, "openrooms:material:category", Sdf.ValueTypeNames.Token, swatch.family)
        if textured:
            size = Gf.Vec2f(self._size(swatch))
            _set(prim, "openrooms:material:size", Sdf.ValueTypeNames.Float2, size)
        return material

    def _textured(self, swatch: Swatch, folder: str) -> PreviewSurface:
        stem, repeats = f"{folder}/{self.stem(swatch)}", 1.0 / self._size(swatch)
        turn = 90.0 if swatch.across else 0.0
        albedo = Texture(
            f"{stem}_albedo.png", "rgb", "sRGB", uv_scale=(repeats, repeats), uv_rotation=turn
        )
        raw = replace(albedo, color_space="raw")
        return PreviewSurface(
            base_color=albedo,
            roughness=replace(raw, file=f"{stem}_roughness.png", channel="r"),
            normal=replace(raw, file=f"{stem}_normal.png", scale=NORMAL_SCALE, bias=NORMAL_BIAS),
            transmission=swatch.transmission,
        )

    def _size(self, swatch: Swatch) -> float:
        spread = textures.FAMILIES[swatch.family][swatch.variant or ""].spread
        return self._section.texture_size * spread


def _constant(swatch: Swatch) -> PreviewSurface:
    return PreviewSurface(
        base_color=swatch.color or PreviewSurface.base_color,
        roughness=swatch.roughness or PreviewSurface.roughness,
        metallic=swatch.metallic,
        transmission=swatch.transmission,
    )


def _set(prim: Usd.Prim, name: str, kind: Sdf.ValueTypeName, value: object) -> None:
    prim.CreateAttribute(name, kind, custom=False).Set(value)
