"""Computes collision shapes and masses of an object: arrays in, arrays out."""

from dataclasses import dataclass

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.library.construction import mass_of_part
from openrooms_usd.library.friction.references import SUBSTANCES
from openrooms_usd.physics.components import Part
from openrooms_usd.physics.mass import MassProperties, combined
from openrooms_usd.steps.physics.ahead import Search
from openrooms_usd.steps.physics.cache import cached_shapes
from openrooms_usd.steps.physics.parts import RigidAsset, RigidLink, Solid


@dataclass(frozen=True, eq=False)
class Collider:
    """A convex shape.

    Attributes:
        name: Unique within its link.
        mesh: In the frame of its link's prim, before its scale.
        solid: The part whose material it has.
    """

    name: str
    mesh: TriangleMesh
    solid: Solid


@dataclass(frozen=True, eq=False)
class LinkColliders:
    """The collision shapes and the mass of a link.

    Attributes:
        link: What it is of.
        colliders: Its shapes.
        masses: In its rigid frame, by look; empty where it does not move.
        error: How far its shapes lie from what is seen at most, metres.
    """

    link: RigidLink
    colliders: tuple[Collider, ...]
    masses: tuple[MassProperties, ...]
    error: float = 0.0


AssetColliders = tuple[LinkColliders, ...]


def colliders_of(asset: RigidAsset) -> AssetColliders:
    """Shapes and masses of all links of an object.

    Raises:
        InputError: Its surfaces enclose nothing and have no area.
    """
    try:
        masses = _masses(asset)
        return tuple(
            _link_colliders(asset, link, weights)
            for link, weights in zip(asset.links, masses, strict=True)
        )
    except InputError as error:
        error.place = error.place or str(asset.root)
        raise


def scaled(mesh: TriangleMesh, scale: Array) -> TriangleMesh:
    """A mesh after a scale along its axes; mirrors keep its outside."""
    mirrored = np.prod(scale) < 0.0
    triangles = mesh.triangles[:, ::-1] if mirrored else mesh.triangles
    return TriangleMesh(mesh.points * scale, triangles, mesh.faces)


def _link_colliders(
    asset: RigidAsset, link: RigidLink, masses: tuple[MassProperties, ...]
) -> LinkColliders:
    found = cached_shapes(*_search_of(asset, link))
    by_name = dict(zip(_stems(link), link.solids, strict=True))
    colliders: list[Collider] = []
    count: dict[str, int] = {}
    for shape in found.shapes:
        stem = shape.parts[0]
        number = count[stem] = count.get(stem, -1) + 1
        mesh = scaled(shape.mesh, 1.0 / asset.scale)
        colliders.append(Collider(f"{stem}_{number}", mesh, by_name[stem]))
    return LinkColliders(link, tuple(colliders), masses, found.error)


def searches_of(asset: RigidAsset) -> list[Search]:
    """What is searched for an object: the shapes of each of its links."""
    return [_search_of(asset, link) for link in asset.links]


def _search_of(asset: RigidAsset, link: RigidLink) -> Search:
    parts = []
    for name, solid in zip(_stems(link), link.solids, strict=True):
        mesh = scaled(solid.mesh, asset.scale)
        parts.append(Part(name, mesh.points, mesh.triangles, repr(solid.substances)))
    return Search(parts, asset.settings.shapes, asset.settings.tolerance)


def _stems(link: RigidLink) -> list[str]:
    """A name for each part that no number behind it makes that of another."""
    last = [solid.path.rpartition("/")[2] for solid in link.solids]
    unique = len(set(last)) == len(last)
    return last if unique else [f"{name}_p{i}" for i, name in enumerate(last)]


def _masses(asset: RigidAsset) -> list[tuple[MassProperties, ...]]:
    """By link and look; where the whole mass is known, each link has its share."""
    looks = range(len(asset.looks))
    moving = [not asset.fixed or link.joint is not None for link in asset.links]
    weighed = [moves or asset.mass is not None for moves in moving]
    table = [
        [_link_mass(asset, link, look) for look in looks] if needed else []
        for link, needed in zip(asset.links, weighed, strict=True)
    ]
    if asset.mass is not None:
        for look in looks:
            total = sum(row[look].mass for row in table)
            for row in table:
                row[look] = row[look].weighing(row[look].mass * asset.mass / total)
    return [tuple(row) if moves else () for row, moves in zip(table, moving, strict=True)]


def _link_mass(asset: RigidAsset, link: RigidLink, look: int) -> MassProperties:
    pieces = []
    for part in link.solids:
        mesh = scaled(part.mesh, asset.scale)
        made = part.substances[look].category
        substance = next((known for known in SUBSTANCES if known == made), None)
        pieces.append(
            mass_of_part(asset.category, part.name, substance, mesh.points, mesh.triangles)
        )
    return combined(pieces)
