"""The lights of a scene by number.

Lamps come first, then openings, then whatever else there is: light that comes in past all openings,
through an open ceiling for instance, is ``elsewhere``. One that is off keeps its number.
"""

from dataclasses import dataclass
from typing import Final, Literal

from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.usd.light.lights import Portal

ELSEWHERE: Final = "elsewhere"
GRAZING_COS: Final = 1e-6
"""|cos| between a ray and a rectangle's normal below which the ray does not cross it."""


@dataclass(frozen=True)
class Source:
    """A light that ground truth is given for.

    Attributes:
        path: The prim of the lamp's object or of the portal; empty for `ELSEWHERE`.
        kind: A lamp emits by itself, an opening lets the surroundings in.
        patches: Numbers of the emitting patches of a lamp.
        portal: The rectangle of an opening.
    """

    path: str
    kind: Literal["lamp", "opening", "elsewhere"]
    patches: tuple[int, ...] = ()
    portal: Portal | None = None


def sources_of(scene: Scene) -> tuple[Source, ...]:
    """The lights of a scene: lamps by object, openings by portal, and the rest."""
    lamps: dict[str, list[int]] = {}
    for number, patch in enumerate(scene.patches):
        if patch.radiance is not None:
            piece = scene.pieces[int(patch.triangles.pieces[0])]
            lamps.setdefault(scene.legend.instance[piece.instance], []).append(number)
    found = [Source(path, "lamp", tuple(patches)) for path, patches in lamps.items()]
    found += [Source(portal.path, "opening", portal=portal) for portal in scene.portals]
    return (*found, Source("", ELSEWHERE))
