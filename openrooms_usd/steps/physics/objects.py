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
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.description.physics import Physics, PhysicsObject
from openrooms_usd.errors import InputError
from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.furniture.record import Support
from openrooms_usd.library.construction import joint_damping_of, movable, tolerance_of
from openrooms_usd.library.friction import friction_of
from openrooms_usd.physics.collision_error import RESOLUTION_M
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.materials.looks import VARIANT_SET
from openrooms_usd.steps.physics.colliders import AssetColliders, LinkColliders, colliders_of
from openrooms_usd.steps.physics.parts import (
    ColliderSettings,
    RigidAsset,
    Solid,
    Substance,
    looks_of,
    read_links,
)
from openrooms_usd.threads import mapped
from openrooms_usd.usd.bodies import (
    Motion,
    author_articulation,
    author_body,
    author_mass,
    bind_physics,
    define_collider,
    define_guides,
    define_joint,
    frame_and_scale,
    keep_apart,
)
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shading import physics
from openrooms_usd.usd.shading.physics import MaterialPhysics

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
    context: StepContext, assets: Iterable[RigidAsset]
) -> Mapping[int, AssetColliders]:
    """Masses and collision shapes, by ``id`` of the asset; the workers change nothing.

    What has none is left out, with a note.
    """
    waiting = list(assets)
    made = {}
    for asset, searched in zip(
        waiting, mapped(_try_colliders, waiting, context.workers), strict=True
    ):
        if isinstance(searched, InputError):
            context.notes.append(f"{asset.root.name} has no physics: {searched.message}")
            continue
        made[id(asset)] = searched
        error = max(link.error for link in searched)
        wanted = asset.settings.tolerance
        if error > wanted + RESOLUTION_M:
            told = f"collision shapes deviate by up to {1e3 * error:.0f} mm"
            context.notes.append(f"{asset.root.name}: {told} (tolerance {1e3 * wanted:g} mm)")
    return made


def _try_colliders(asset: RigidAsset) -> AssetColliders | InputError:
    try:
        return colliders_of(asset)
    except InputError as error:
        return error


# Writes bodies, collision shapes and joints below the root of an object.

SCOPE: Final = "Physics"
COLLIDERS: Final = "Colliders"
_MASS_DECIMALS: Final = 3


def author_physics(
    stage: Usd.Stage,
    root: Sdf.Path,
    asset: RigidAsset,
    made: AssetColliders,
    owner: Sdf.Path | None = None,
) -> None:
    """Write the physics of an object.

    Args:
        stage: Where; its edit target receives everything.
        root: The object's root there, which may be an over.
        asset: What it is.
        made: What was worked out of it.
        owner: The prim above it that has its looks, where it has none of its own.
    """
    UsdGeom.Scope.Define(stage, root.AppendChild(SCOPE))
    contacts = _Contacts(stage, root, asset, owner)
    for item in made:
        path = _below(root, item.link.path)
        prim = stage.OverridePrim(path)
        moves = not asset.fixed or item.link.joint is not None
        if moves:
            author_body(prim)
        if item.colliders:
            scope = define_guides(stage, _holder(path, item).AppendChild(COLLIDERS))
            for collider in item.colliders:
                shape = define_collider(stage, scope.AppendChild(collider.name), collider.mesh)
                contacts.bind(shape.GetPath(), collider.solid)
        for look, mass in zip(asset.looks, item.masses, strict=moves):
            author_mass(contacts.spec(path, look), mass, asset.scale)
    _author_joints(stage, root, asset, made)


def _below(root: Sdf.Path, relative: str) -> Sdf.Path:
    return root if relative == "." else root.AppendPath(relative)


@dataclass(frozen=True, eq=False)
class _Contacts:
    """Binds what shapes are made of, look by look."""

    stage: Usd.Stage
    root: Sdf.Path
    asset: RigidAsset
    owner: Sdf.Path | None
    own: dict[MaterialPhysics, Sdf.Path] = field(default_factory=dict)

    def spec(self, path: Sdf.Path, look: str) -> Sdf.PrimSpec:
        """Where the opinions about a prim go that hang on the look."""
        layer = self.stage.GetEditTarget().GetLayer()
        if not look:
            return Sdf.CreatePrimInLayer(layer, path)
        owner = self.owner or self.root
        Sdf.CreateVariantInLayer(layer, owner, VARIANT_SET, look)
        inside = owner.AppendVariantSelection(VARIANT_SET, look)
        return Sdf.CreatePrimInLayer(layer, path.ReplacePrefix(owner, inside))

    def bind(self, shape: Sdf.Path, solid: Solid) -> None:
        for look, made in zip(self.asset.looks, solid.substances, strict=True):
            bind_physics(self.spec(shape, look), self._material(made))

    def _material(self, made: Substance) -> Sdf.Path:
        """The Material that the part shows, where it says all; else one of our own."""
        if made.physics is not None and made.material and self.asset.friction is None:
            path = Sdf.Path(made.material)
            # A layer that is referenced cannot name what is outside of it.
            if not path.IsAbsolutePath() or self.owner is not None:
                return path.MakeAbsolutePath(self.root)
        return self._own(made.category or "unknown", self._physics_of(made))

    def _physics_of(self, made: Substance) -> MaterialPhysics:
        known = made.physics or _usual()
        if self.asset.friction is None:
            return known
        ratio = known.dynamic_friction / known.static_friction if known.static_friction else 1.0
        given = self.asset.friction
        return MaterialPhysics(given, given * ratio, known.restitution, known.density)

    def _own(self, name: str, known: MaterialPhysics) -> Sdf.Path:
        if known not in self.own:
            scope = self.root.AppendChild(SCOPE).AppendChild("Materials")
            UsdGeom.Scope.Define(self.stage, scope)
            path = scope.AppendChild(f"{name}_{len(self.own)}")
            physics.author(UsdShade.Material.Define(self.stage, path).GetPrim(), known)
            self.own[known] = path
        return self.own[known]


def _usual() -> MaterialPhysics:
    """The physics of an unknown substance: the mean of all."""
    static, dynamic, spread = (
        round(float(value), _MASS_DECIMALS) for value in friction_of(None, (0.5, 0.5, 0.5), 0.5)
    )
    return MaterialPhysics(static, dynamic, 0.0, 0.0, friction_spread=spread)


def _author_joints(
    stage: Usd.Stage, root: Sdf.Path, asset: RigidAsset, made: AssetColliders
) -> None:
    movers = [item for item in made if item.link.joint is not None]
    if not movers:
        return
    scope = UsdGeom.Scope.Define(stage, root.AppendPath(f"{SCOPE}/Joints")).GetPath()
    base = _below(root, made[0].link.path)
    if not asset.fixed:
        author_articulation(stage.GetPrimAtPath(base))
    for item in movers:
        name = item.link.path.replace("/", "_").removeprefix("Geometry_")
        bodies = (base, _below(root, item.link.path))
        define_joint(stage, scope.AppendChild(name), _motion(asset, item), bodies, asset.scale)
    _keep_apart(stage, root, asset, made)


def _keep_apart(stage: Usd.Stage, root: Sdf.Path, asset: RigidAsset, made: AssetColliders) -> None:
    """Drawers pass each other, and the case: collisions are turned off pair by pair."""
    passed: list[Sdf.Path] = []
    for item in made:
        path = _below(root, item.link.path)
        if item.link.joint is not None:
            if passed:
                keep_apart(stage.GetPrimAtPath(path), passed)
            passed.append(path)
        elif asset.fixed:
            passed += [
                _holder(path, item).AppendPath(f"{COLLIDERS}/{c.name}") for c in item.colliders
            ]


def _holder(path: Sdf.Path, item: LinkColliders) -> Sdf.Path:
    """Where the shapes of a link go."""
    return path if item.link.path != "." else path.AppendChild(SCOPE)


def _motion(asset: RigidAsset, item: LinkColliders) -> Motion:
    says = item.link.joint
    assert says is not None
    axis = np.array(says.axis) / np.linalg.norm(says.axis)
    lost = joint_damping_of(asset.category, says.kind)
    return Motion(says.kind, axis, says.limits, item.link.built, lost.damping, lost.friction)
