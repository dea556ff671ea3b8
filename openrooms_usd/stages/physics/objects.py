"""The physics of objects: computed once for all equal ones, each as a layer.

::

    over Chair                default prim: RigidBodyAPI, MassAPI; variants of its looks
        Physics               Scope
            Colliders         Scope, purpose guide: Mesh prims with CollisionAPI
            Materials         Scope: what no material of the object says
            Joints            Scope: RevoluteJoint and PrismaticJoint prims
        Geometry/Body         over: RigidBodyAPI, MassAPI, Colliders, where parts move
        Geometry/door_0_hinge over: likewise
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.description.physics import Physics, PhysicsObject
from openrooms_usd.errors import InputError
from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.furniture.record import Support
from openrooms_usd.library.construction import movable, tolerance_of
from openrooms_usd.physics.collision_error import RESOLUTION_M
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.physics.assets import ColliderSettings, RigidAsset
from openrooms_usd.stages.physics.colliders import AssetColliders, colliders_of
from openrooms_usd.stages.physics.parts import looks_of, read_links
from openrooms_usd.threads import mapped
from openrooms_usd.usd.bodies import frame_and_scale
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.semantics import read_label

# Scales that differ by less are one.
_SCALE_DIGITS: Final = 6
# The alignment's support token, and the kind of support.
_FOUND: Final[dict[str, Support]] = {
    "floor": "floor",
    "wall": "wall",
    "ceiling": "ceiling",
    "object": "surface",
}


@dataclass(frozen=True)
class Objects:
    """Reads objects, each of those that are alike once.

    Attributes:
        section: The section of the description.
    """

    section: Physics

    def read(
        self, stage: Usd.Stage, roots: Iterable[Usd.Prim]
    ) -> list[tuple[RigidAsset, list[Sdf.Path]]]:
        """The assets that are there, each with all its roots, in the order of the stage."""
        cache = UsdGeom.XformCache(TIME)
        groups: dict[tuple[object, ...], list[Usd.Prim]] = {}
        for root in roots:
            groups.setdefault(self._alike(root, cache), []).append(root)
        # Reading goes through the looks, which makes prims anew.
        members = [[root.GetPath() for root in group] for group in groups.values()]
        assets = [(self.asset(stage, paths[0]), paths) for paths in members]
        return [(asset, paths) for asset, paths in assets if _has_surface(asset)]

    def _alike(self, root: Usd.Prim, cache: UsdGeom.XformCache) -> tuple[object, ...]:
        given = self.section.objects.get(root.GetName())
        return (
            _content(root),
            tuple(_scale(root, cache).tolist()),
            given and tuple(given.model_dump().values()),
            _mass_by_hand(root),
            _support(root),
        )

    def asset(self, stage: Usd.Stage, path: Sdf.Path, owner: Sdf.Path | None = None) -> RigidAsset:
        """What one object is for physics.

        Args:
            stage: The composed stage.
            path: Its root.
            owner: Where its looks are chosen; the root itself where None.
        """
        chooser = owner or path
        links = tuple(read_links(stage, path, chooser))
        root = stage.GetPrimAtPath(path)
        given = self.section.objects.get(root.GetName(), PhysicsObject())
        category = read_label(root, names.CATEGORY) or ""
        return RigidAsset(
            path,
            str(root.GetAssetInfo().get("name", "")) or root.GetName(),
            category,
            not movable(category, _support(root)) if given.body is None else given.body == "fixed",
            given.mass or _mass_by_hand(root),
            given.friction,
            _scale(root, UsdGeom.XformCache(TIME)),
            looks_of(stage.GetPrimAtPath(chooser)),
            links,
            ColliderSettings(
                given.shapes or self.section.shapes, tolerance_of(category, self.section.tolerance)
            ),
        )


def _content(root: Usd.Prim) -> object:
    """The key of equal objects: their prototype, or what they reference."""
    if root.IsInstance():
        return root.GetPrototype().GetPath()
    own = set(root.GetStage().GetLayerStack())
    specs = root.GetPrimStack()
    if any(spec.layer in own and spec.nameChildren for spec in specs):
        return root.GetPath()
    sets = root.GetVariantSets()
    chosen = tuple((name, sets.GetVariantSelection(name)) for name in sets.GetNames())
    sources = tuple(
        (spec.layer.identifier, str(spec.path)) for spec in specs if spec.layer not in own
    )
    return (sources, chosen) if sources else root.GetPath()


def _scale(root: Usd.Prim, cache: UsdGeom.XformCache) -> Array:
    _, scale = frame_and_scale(cache.GetLocalToWorldTransform(root))
    return np.round(scale, _SCALE_DIGITS) + 0.0


def _mass_by_hand(root: Usd.Prim) -> float | None:
    """The mass of an object in the edits; no weaker layer has written one yet."""
    attribute = root.GetAttribute("physics:mass")
    value = attribute.Get(TIME) if attribute else None
    return value if isinstance(value, float) and value > 0.0 else None


def _support(root: Usd.Prim) -> Support | None:
    """The support of an object: found in a scan, or else usual for its category."""
    attribute = root.GetAttribute(names.ALIGNMENT_SUPPORT)
    found = attribute.Get() if attribute else None
    spec = CATEGORIES.get(read_label(root, names.CATEGORY) or "")
    usual = spec.support if spec else None
    return _FOUND.get(str(found), usual)


def _has_surface(asset: RigidAsset) -> bool:
    return any(link.solids for link in asset.links)


def search_colliders(
    context: StageContext, assets: Iterable[RigidAsset]
) -> Mapping[int, AssetColliders]:
    """Masses and collision shapes, by ``id`` of the asset; the workers change nothing.

    What has none is left out, with a note.
    """
    waiting = list(assets)
    made = {}
    for asset, searched in zip(waiting, mapped(_tried, waiting, context.workers), strict=True):
        if isinstance(searched, InputError):
            context.notes.append(f"{asset.root.name} has no physics: {searched.message}")
            continue
        made[id(asset)] = searched
        error = max(link.error for link in searched)
        wanted = asset.settings.tolerance
        if error > wanted + RESOLUTION_M:
            told = f"its collision shapes lie within {1e3 * error:.0f} mm of it, not"
            context.notes.append(f"{asset.root.name}: {told} {1e3 * wanted:g} mm")
    return made


def _tried(asset: RigidAsset) -> AssetColliders | InputError:
    try:
        return colliders_of(asset)
    except InputError as error:
        return error
