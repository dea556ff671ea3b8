"""Writes bodies, collision shapes and joints below the root of an object."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd.library.construction import joint_damping_of
from openrooms_usd.library.friction import friction_of
from openrooms_usd.stages.materials.looks import VARIANT_SET
from openrooms_usd.stages.physics.assets import RigidAsset
from openrooms_usd.stages.physics.colliders import AssetColliders, LinkColliders
from openrooms_usd.stages.physics.parts import Solid, Substance
from openrooms_usd.usd.bodies import (
    Motion,
    author_articulation,
    author_body,
    author_mass,
    bind_physics,
    define_collider,
    define_guides,
    define_joint,
    keep_apart,
)
from openrooms_usd.usd.shading import physics
from openrooms_usd.usd.shading.physics import MaterialPhysics

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
        return self._own(made.category or "unknown", self._known(made))

    def _known(self, made: Substance) -> MaterialPhysics:
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
    """Drawers pass each other, and the case: a joint to what is no body keeps nothing apart."""
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
