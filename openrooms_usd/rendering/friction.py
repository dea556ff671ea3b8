"""The friction channel: made by the core from what any renderer gives, so that all have it."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.channels import CHANNELS
from openrooms_usd.library.friction import friction_of
from openrooms_usd.library.friction.references import SUBSTANCES
from openrooms_usd.rendering.contract import View

if TYPE_CHECKING:
    from pxr import Usd

    from openrooms_usd.description.substances import Substance

FRICTION: Final = "friction"
SOURCES: Final = ("base_color", "roughness", "material", "valid")


@dataclass(frozen=True)
class Material:
    """What is known of a material's friction.

    Attributes:
        substance: What it is made of; None where nothing says.
        authored: The static coefficient that its prim carries, where it has no substance.
    """

    substance: "Substance | None" = None
    authored: float | None = None

    def static(self, albedo: Floats, roughness: Floats) -> Array:
        """(P,) static coefficients of (P, 3) base colours and (P,) roughnesses."""
        if self.authored is not None:
            return np.full(roughness.shape, self.authored)
        return friction_of(self.substance, albedo, roughness).static

    def entry(self) -> dict[str, Any]:
        """What the manifest says about it."""
        if self.authored is not None:
            return {"from": "UsdPhysicsMaterialAPI", "static": round(self.authored, 6)}
        if self.substance is not None:
            return {"from": "substance and looks", "substance": self.substance}
        return {"from": "nothing: the mean of all substances"}


_UNKNOWN: Final = Material()


def derivable(given: tuple[str, ...]) -> tuple[str, ...]:
    """The channels that can be made of what a renderer gives."""
    return (FRICTION,) if set(SOURCES) <= set(given) else ()


@dataclass(frozen=True)
class FrictionMap:
    """Makes the channel of a stage.

    Attributes:
        materials: By material number.
    """

    materials: Mapping[int, Material]

    @staticmethod
    def needs(channels: tuple[str, ...]) -> tuple[str, ...]:
        """The channels to render so that these can be written."""
        needed = ({*channels} - {FRICTION}) | {*SOURCES}
        return tuple(name for name in CHANNELS if name in needed)

    def complete(self, view: View, channels: tuple[str, ...]) -> View:
        """The view with its friction, and without sources that were not requested."""
        began = time.perf_counter()
        pixels = self.pixels(*(view.images[name].pixels for name in SOURCES))
        source = view.images["base_color"]
        made = replace(source, pixels=pixels, seconds=time.perf_counter() - began)
        images = {**view.images, FRICTION: made}
        return replace(view, images={name: images[name] for name in channels})

    def pixels(self, albedo: Floats, roughness: Floats, material: Floats, valid: Floats) -> Floats:
        """The static coefficient of every pixel.

        Args:
            albedo: (H, W, 3).
            roughness: (H, W, 1).
            material: (H, W, 1) material numbers; one that is not known is of no substance.
            valid: (H, W, 1) 0 without surface.

        Returns:
            (H, W, 1), 0 without surface.
        """
        found = np.zeros(roughness.shape[:2])
        seen = valid[..., 0] > 0
        numbers, which = np.unique(material[seen][:, 0], return_inverse=True)
        kinds = [self.materials.get(int(number), _UNKNOWN) for number in numbers]
        colors, gloss, values = albedo[seen], roughness[seen][:, 0], np.zeros(len(which))
        # Materials of one kind are looked up together: a room may have hundreds.
        for kind in dict.fromkeys(kinds):
            mine = np.array([other == kind for other in kinds])[which]
            values[mine] = kind.static(colors[mine], gloss[mine])
        found[seen] = values
        return found[..., None].astype(np.float32)

    def entry(self) -> dict[str, Any]:
        """What the manifest says about it."""
        return {
            "meaning": "static Coulomb coefficients, dry, against the references' mean counterface",
            "sources": list(SOURCES),
            "materials": {number: known.entry() for number, known in self.materials.items()},
        }


def read_materials(stage: "Usd.Stage", paths: Mapping[int, str]) -> dict[int, Material]:
    """What a stage says of its materials' friction.

    A material's substance (`names.MATERIAL_CATEGORY`) comes first, because its looks then refine
    the value pixel by pixel. One without takes the coefficient that UsdPhysicsMaterialAPI gives it.

    Args:
        stage: The composed stage, ours or a foreign one.
        paths: The materials' prim paths by number.
    """
    from openrooms_usd.usd.shading import physics

    found = {}
    for number, path in paths.items():
        prim = stage.GetPrimAtPath(path)
        category = physics.read_category(prim) if prim else None
        known = physics.read(prim) if prim else None
        if category in SUBSTANCES:
            found[number] = Material(substance=category)
        else:
            found[number] = Material(authored=known.static_friction) if known else _UNKNOWN
    return found
