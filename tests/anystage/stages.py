"""Random sound stages: hierarchies with transforms, instances, bindings, lights and cameras."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from random import Random

from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from tests.anystage import things
from tests.anystage.things import Maker


@dataclass
class Kinds:
    """What a stage may hold.

    Attributes:
        drawn: What is drawn, with its share.
        wild: Whether factors go from 1e-4 to 1e4, and stacks of transforms are reset.
        lit: Whether there are lights and cameras.
    """

    drawn: Mapping[Maker, int] = field(default_factory=lambda: things.ANY)
    wild: bool = True
    lit: bool = True


FLAT = Kinds(things.FLAT, wild=False, lit=False)


def random_stage(seed: int, kinds: Kinds | None = None) -> Usd.Stage:
    """A sound stage in memory; the same for the same seed."""
    return _Growing(Random(f"stage {seed}"), kinds or Kinds()).stage


class _Growing:
    """One stage while it is made."""

    def __init__(self, rng: Random, kinds: Kinds) -> None:
        self._rng, self._kinds = rng, kinds
        self.stage = Usd.Stage.CreateInMemory()
        UsdGeom.SetStageUpAxis(self.stage, rng.choice("YZ"))
        units = (1e-3, 0.01, 0.3048, 1.0, 100.0)
        UsdGeom.SetStageMetersPerUnit(self.stage, rng.choice(units))
        root = UsdGeom.Xform.Define(self.stage, "/World")
        self.stage.SetDefaultPrim(root.GetPrim())
        self._looks = [
            str(things.material(self.stage, f"/World/Looks/m{i}", rng).GetPath()) for i in range(2)
        ]
        self._models = self._made_models()
        for number in range(rng.randint(2, 4)):
            self._branch(f"/World/b{number}", 3, self._models)
        if kinds.lit:
            for number in range(rng.randint(0, 3)):
                path = f"/World/l{number}"
                things.light(self.stage, path, rng)
                self._place(path, tame=True)
            for number in range(rng.randint(0, 2)):
                path = f"/World/c{number}"
                things.camera(self.stage, path, rng)
                self._place(path, tame=True)

    def _made_models(self) -> list[str]:
        """What is instanced; later ones may hold instances of earlier ones."""
        found: list[str] = []
        for number in range(self._rng.randint(1, 2)):
            path = f"/World/Models/p{number}"
            UsdGeom.Xform.Define(self.stage, path)
            self._branch(f"{path}/inner", 2, found)
            found.append(path)
        # They are drawn where they are instanced alone.
        self.stage.OverridePrim("/World/Models").SetSpecifier(Sdf.SpecifierClass)
        return found

    def _branch(self, path: str, depth: int, models: list[str]) -> None:
        rng = self._rng
        roll = rng.random()
        if models and roll < 0.2:
            UsdGeom.Xform.Define(self.stage, path).GetPrim().GetReferences().AddInternalReference(
                rng.choice(models)
            )
            self.stage.GetPrimAtPath(path).SetInstanceable(True)
            self._place(path)
        elif roll < 0.3:
            self._scatter(path, models)
        elif depth and roll < 0.6:
            kind = rng.choice(("Xform", "Xform", "Scope", ""))
            self.stage.DefinePrim(path, kind)
            if kind == "Xform":
                self._place(path)
            for number in range(rng.randint(1, 2)):
                self._branch(f"{path}/b{number}", depth - 1, models)
        else:
            self._leaf(path)
            self._place(path)
        self._hide(path)

    def _leaf(self, path: str) -> None:
        rng, drawn = self._rng, self._kinds.drawn
        rng.choices([*drawn], [*drawn.values()])[0](self.stage, path, rng)
        prim = self.stage.GetPrimAtPath(path)
        if rng.random() < 0.6:
            self._bind(prim)
        mesh = UsdGeom.Mesh(prim)
        if mesh and rng.random() < 0.3:
            faces = range(len(mesh.GetFaceVertexCountsAttr().Get()))
            chosen = [face for face in faces if rng.random() < 0.5]
            subset = UsdShade.MaterialBindingAPI.Apply(prim).CreateMaterialBindSubset(
                "part", chosen
            )
            self._bind(subset.GetPrim())

    def _bind(self, prim: Usd.Prim) -> None:
        look = UsdShade.Material.Get(self.stage, self._rng.choice(self._looks))
        strength = self._rng.choice(("weakerThanDescendants", "strongerThanDescendants"))
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(look, strength)

    def _scatter(self, path: str, models: list[str]) -> None:
        """A point instancer with one or two prototypes below it, or a model."""
        rng = self._rng
        made = UsdGeom.PointInstancer.Define(self.stage, path)
        targets = [f"{path}/Kinds/a", f"{path}/Kinds/b"][: rng.randint(1, 2)]
        for target in targets:
            self._leaf(target)
            self._place(target)
        if models and rng.random() < 0.5:
            targets.append(rng.choice(models))
        made.CreatePrototypesRel().SetTargets(targets)
        count = rng.randint(1, 3)
        made.CreateProtoIndicesAttr([rng.randrange(len(targets)) for _ in range(count)])
        made.CreatePositionsAttr([self._vector() for _ in range(count)])
        if rng.random() < 0.5:
            turns = [self._turn().GetQuat() for _ in range(count)]
            made.CreateOrientationsfAttr([Gf.Quatf(turn) for turn in turns])
        if rng.random() < 0.5:
            made.CreateScalesAttr([Gf.Vec3f(*self._factors()) for _ in range(count)])
        if rng.random() < 0.3:
            made.CreateInvisibleIdsAttr([0])
        self._place(path)

    def _hide(self, path: str) -> None:
        rng, prim = self._rng, self.stage.GetPrimAtPath(path)
        shown = UsdGeom.Imageable(prim)
        if shown and rng.random() < 0.07:
            shown.MakeInvisible()
        if shown and rng.random() < 0.1:
            shown.CreatePurposeAttr(rng.choice(("render", "proxy", "guide", "default")))
        if rng.random() < 0.04:
            prim.SetActive(False)

    # Transforms.

    def _place(self, path: str, *, tame: bool = False) -> None:
        """Operations in any number and order; tame ones keep lengths and handedness."""
        rng, shape = self._rng, UsdGeom.Xformable(self.stage.GetPrimAtPath(path))
        kinds = [self._translate, self._rotate, self._orient]
        if not tame:
            kinds += [self._scale, self._matrix, self._pivot]
        for make in rng.sample(kinds, rng.randint(0, 3)):
            make(shape)
        if self._kinds.wild and rng.random() < 0.05:
            shape.SetResetXformStack(True)

    def _vector(self) -> Gf.Vec3f:
        return Gf.Vec3f(*(self._rng.uniform(-3, 3) for _ in range(3)))

    def _turn(self) -> Gf.Rotation:
        return Gf.Rotation(Gf.Vec3d(self._vector()), self._rng.uniform(-180, 180))

    def _factors(self) -> list[float]:
        rng = self._rng
        if self._kinds.wild and rng.random() < 0.3:
            return [things.extent(rng)] * 3
        return [rng.choice((1, 1, 1, -1)) * rng.uniform(0.3, 2.0) for _ in range(3)]

    def _translate(self, shape: UsdGeom.Xformable) -> None:
        shape.AddTranslateOp().Set(Gf.Vec3d(self._vector()))

    def _rotate(self, shape: UsdGeom.Xformable) -> None:
        order = self._rng.choice(("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX", "X", "Y", "Z"))
        made = getattr(shape, f"AddRotate{order}Op")()
        made.Set(self._rng.uniform(-180, 180) if len(order) == 1 else 50 * self._vector())

    def _orient(self, shape: UsdGeom.Xformable) -> None:
        shape.AddOrientOp().Set(Gf.Quatf(self._turn().GetQuat()))

    def _scale(self, shape: UsdGeom.Xformable) -> None:
        shape.AddScaleOp().Set(Gf.Vec3f(*self._factors()))

    def _matrix(self, shape: UsdGeom.Xformable) -> None:
        """A sheared one."""
        shear = Gf.Matrix4d(1.0)
        shear.SetRow(1, Gf.Vec4d(self._rng.uniform(-1, 1), 1, self._rng.uniform(-1, 1), 0))
        shape.AddTransformOp().Set(shear * Gf.Matrix4d(self._turn(), Gf.Vec3d(self._vector())))

    def _pivot(self, shape: UsdGeom.Xformable) -> None:
        """A turn about a point, by an operation and its inverse."""
        shape.AddTranslateOp(opSuffix="pivot").Set(Gf.Vec3d(self._vector()))
        shape.AddRotateYOp(opSuffix="about").Set(self._rng.uniform(-180, 180))
        shape.AddTranslateOp(opSuffix="pivot", isInverseOp=True)
