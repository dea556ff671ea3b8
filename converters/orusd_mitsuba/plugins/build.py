"""A `Scene` as objects of the active Mitsuba variant."""

from functools import cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.rendering.scene.arrays import Environment, Patch, Scene
from openrooms_usd.rendering.scene.instances import Instances, joined
from openrooms_usd.rendering.scene.pictures import Picture
from openrooms_usd.rendering.scene.surfaces import Surface
from openrooms_usd.rendering.scene.triangles import Triangles
from orusd_mitsuba.plugins import material_table, meshes, openrooms_bsdf, preview_bsdf
from orusd_mitsuba.plugins import portal_environment as portals
from orusd_mitsuba.plugins.descriptions import (
    Description,
    describe_area,
    describe_bsdf,
    describe_color,
    describe_sun,
)
from orusd_mitsuba.plugins.light_weights import LightWeights, brightest_beam, light_weights
from orusd_mitsuba.plugins.material_table import MaterialTable, PreviewTable, shape_number
from orusd_mitsuba.plugins.shaped_area import shaped_area
from orusd_mitsuba.plugins.sun_disk import sun_disk
from orusd_mitsuba.plugins.two_ways import two_ways
from orusd_mitsuba.plugins.unseen_area import unseen_area


class Builder:
    """Makes Mitsuba objects; each picture and each surface becomes one object.

    Args:
        origin: (3,) the point of the world that becomes Mitsuba's origin.
    """

    def __init__(self, origin: Array) -> None:
        self._origin = origin
        variant = str(mi.variant())
        self._openrooms, self._preview = (
            plugin.register(variant) for plugin in (openrooms_bsdf, preview_bsdf)
        )
        # A scalar variant would call Python for every scattering.
        self._by_formula = not variant.startswith("scalar")
        self._table: MaterialTable | None = None
        self._rows: dict[int, int] = {}
        self._tables: list[tuple[MaterialTable, dict[int, int]]] = []
        self._textures: dict[tuple[Any, ...], Any] = {}
        self._bsdfs: dict[int, Any] = {}
        self._shaped: dict[str, Any] = {}
        self._areas: dict[str, Any] = {}

    def scene(
        self,
        scene: Scene,
        weights: LightWeights | None = None,
        by_portals: bool = True,
        panes: bool = False,
    ) -> Any:
        """The whole scene, its shapes in the order of its patches.

        Args:
            scene: The arrays.
            weights: How often lights are sampled; None: by the flux that they bring.
            by_portals: Whether the surroundings are sampled where they come in.
            panes: Whether panes are among the shapes, after the patches, as Mitsuba's own
                integrators take them; ours follow panes apart from the scene.
        """
        weights = weights or light_weights(scene)
        self._tabulate(scene)
        objects: Description = {"type": "scene"}
        for patch in (*scene.patches, *(pane.sheet() for pane in scene.panes if panes)):
            objects |= self._shapes(patch, weights)
        for number, (sun, weight) in enumerate(zip(scene.suns, weights.suns, strict=True)):
            soft = sun.angle > 0.0 and not str(mi.variant()).startswith("scalar")
            objects[f"sun_{number}"] = (
                sun_disk(sun, weight, scene.radius) if soft else describe_sun(sun, weight)
            )
        sky = None
        if scene.environment is not None:
            sky = self._environment(scene.environment, weights.sky)
            objects["environment"] = sky
            if by_portals and portals.worthwhile(scene.portals):
                objects["environment"] = portals.through_portals(
                    sky,
                    scene.portals,
                    scene.origin,
                    scene.radius,
                    weights.sky,
                    brightest_beam(scene.environment),
                )
        # Without optimisation: it would merge shapes, and their numbers are looked up.
        built = mi.load_dict(objects, optimize=False)
        self._bind(scene, built)
        if sky is not None:
            # What stands before the sky in the scene does not pass this on.
            sky.set_scene(built)
        return built

    def move(self, built: Any, before: Scene, after: Scene) -> None:
        """Let a built scene's triangles stand elsewhere.

        Args:
            built: What `scene` made.
            before: Where they stand now.
            after: Where they shall stand; patches that do not move are the same objects.
        """
        arrays = mi.traverse(built)
        for old, new in zip(before.patches, after.patches, strict=True):
            if old is not new:
                self._move(arrays, new)
        arrays.update()

    def _tabulate(self, scene: Scene) -> None:
        """One BSDF for all surfaces that can share it; scalar variants gain nothing by that."""
        if not self._by_formula:
            return
        surfaces = {id(patch.surface): patch.surface for patch in scene.patches}.values()
        if rows := [surface for surface in surfaces if material_table.fits(surface)]:
            self._table = MaterialTable(rows)
            self._rows = self._share(rows, self._table, self._openrooms)
        if rows := [surface for surface in surfaces if material_table.fits_preview(surface)]:
            self._share(rows, PreviewTable(rows), self._preview)

    def _share(self, surfaces: list[Surface], table: MaterialTable, kind: Any) -> dict[int, int]:
        """Which row of a table each surface is; all have one BSDF."""
        rows = {id(surface): row for row, surface in enumerate(surfaces)}
        self._tables.append((table, rows))
        self._bsdfs |= dict.fromkeys(rows, kind(mi.Properties(), table))
        return rows

    def _bind(self, scene: Scene, built: Any) -> None:
        for table, rows in self._tables:
            found = [
                (shape, rows[id(patch.surface)])
                for shape, patch in zip(built.shapes(), scene.patches, strict=True)
                if id(patch.surface) in rows
            ]
            table.bind(*zip(*found, strict=True))

    def _move(self, arrays: Any, patch: Patch) -> None:
        whole, shared = self._apart(patch.triangles)
        for number, instances in enumerate(shared):
            for row, matrix in enumerate(instances.centred().seen_from(self._origin)):
                arrays[f"{patch.name}_{number}_{row}.to_world"] = _matrix(matrix)
        if len(whole):
            found = meshes.vertices(whole, self._origin)
            arrays[f"{patch.name}.vertex_positions"] = found.positions.ravel()
            arrays[f"{patch.name}.vertex_normals"] = found.normals.ravel()
        if patch.shaping is not None:
            self._shaped[patch.name].turn(patch.shaping)

    def _shapes(self, patch: Patch, weights: LightWeights) -> dict[str, Any]:
        """The shapes of a patch by their identifiers, in the order of its triangles."""
        properties = mi.Properties()
        properties["bsdf"] = self.bsdf(patch.surface)
        if patch.radiance is not None:
            area = describe_area(patch.radiance, weights.patches[patch.name])
            properties["emitter"] = self._emitter(patch, mi.load_dict(self._resolved(area)))
        whole, shared = self._apart(patch.triangles)
        found: dict[str, Any] = {}
        if len(whole) or not shared:
            vertices = meshes.vertices(whole, self._origin)
            found[patch.name] = meshes.mesh(patch.name, vertices, properties)
        for number, instances in enumerate(shared):
            name = f"{patch.name}_{number}"
            found |= meshes.shape_group(name, instances, self._origin, properties)
        if patch.name in self._areas:
            self._areas[patch.name].set_shape(found[patch.name])
        return found

    def first_rows(self, scene: Scene) -> Ints:
        """(shapes,) the row of `Scene.triangles` that the first triangle of each shape is."""
        sizes: list[int] = []
        for patch in scene.patches:
            whole, shared = self._apart(patch.triangles)
            sizes += [len(whole)] if len(whole) or not shared else []
            for instances in shared:
                sizes += [len(instances.prototype)] * len(instances.owners)
        return np.cumsum([0, *sizes[:-1]])

    def _apart(self, triangles: Triangles) -> tuple[Triangles, list[Instances]]:
        """What is one mesh, and what are instances after it.

        Vectorized variants compile code for each instance (half a minute for a thousand), so that
        they are expanded there.
        """
        if not str(mi.variant()).startswith("scalar"):
            return triangles, []
        plain = [part for part in triangles.parts if not isinstance(part, Instances)]
        shared = [part for part in triangles.parts if isinstance(part, Instances)]
        return joined(plain), shared

    def _emitter(self, patch: Patch, inner: Any) -> Any:
        found = inner
        if patch.shaping is not None:
            found = self._shaped[patch.name] = shaped_area(inner, patch.shaping)
        if patch.unseen:
            found = unseen_area(found)
        if found is not inner:
            self._areas[patch.name] = inner
        return found

    @property
    def table(self) -> MaterialTable | None:
        """What surfaces are rows of; None where none fits."""
        return self._table

    def tabulated(self, scene: Scene, built: Any) -> Mask:
        """Which registered shapes have a row in the table; True for numbers that no shape has.

        Args:
            scene: The arrays.
            built: What `scene` made of them.
        """
        numbers = [shape_number(shape) for shape in built.shapes()]
        found = np.ones(max(numbers, default=0) + 1, dtype=bool)
        found[numbers] = self.in_table(scene)
        return found

    def in_table(self, scene: Scene) -> Mask:
        """(patches,) which of a scene's patches have a row in the table."""
        return np.array([id(patch.surface) in self._rows for patch in scene.patches], dtype=bool)

    def bsdf(self, surface: Surface) -> Any:
        """The BSDF of a surface; equal ones share one."""
        key = id(surface)
        if key not in self._bsdfs:
            made = mi.load_dict(self._resolved(describe_bsdf(surface, by_formula=self._by_formula)))
            self._bsdfs[key] = one_sided(made) if surface.one_sided else made
        return self._bsdfs[key]

    def _environment(self, environment: Environment, weight: float) -> Any:
        if environment.pixels.shape[:2] == (1, 1):
            color = describe_color((*environment.pixels[0, 0].tolist(),))
            plugin = {"type": "constant", "radiance": color, "sampling_weight": weight}
            return mi.load_dict(plugin)
        turn = np.eye(4)
        turn[:3, :3] = environment.world_from_light
        return mi.load_dict(
            {
                "type": "envmap",
                "bitmap": mi.Bitmap(environment.pixels),
                "to_world": _matrix(turn),
                "sampling_weight": weight,
            }
        )

    def _resolved(self, value: Any) -> Any:
        """A description with its pictures made into textures."""
        if isinstance(value, dict):
            return {name: self._resolved(item) for name, item in value.items()}
        return self._texture(value) if isinstance(value, Picture) else value

    def _texture(self, picture: Picture) -> Any:
        # Materials that differ in tint or place share their texels.
        key = id(picture.texels), picture.wrap, picture.uv.tobytes(), picture.coding
        if key not in self._textures:
            # The picture is kept with it, so that its identity is not given to another.
            self._textures[key] = _bitmap(picture), picture
        return self._textures[key][0]


def _bitmap(picture: Picture) -> Any:
    if len(set(picture.ways)) > 1:
        return two_ways(picture)
    bitmap = mi.Bitmap(picture.halves())
    plugin = {"type": "bitmap", "bitmap": bitmap, "raw": True, "wrap_mode": picture.wrap}
    if not picture.is_plain:
        plugin["to_uv"] = mi.ScalarTransform3f(picture.uv.tolist())
    return mi.load_dict(plugin)


def _matrix(values: Array) -> Any:
    return mi.ScalarTransform4f(values.tolist())


def load_sensor(description: Description, sampler: Description) -> Any:
    """A sensor as an object of the active variant."""
    matrix = _matrix(description["to_world"])
    return mi.load_dict(description | {"to_world": matrix, "sampler": sampler})


# Lamps of stages are such: a camera may stand behind a softbox, or inside of a ball that shines.


def one_sided(inner: Any) -> Any:
    """A BSDF of the active variant.

    Args:
        inner: What the front is.
    """
    return _bsdf_class(str(mi.variant()))(inner)


@cache
def _bsdf_class(variant: str) -> Any:
    """The BSDF's class for a variant: each has a base class of its own."""

    class OneSided(mi.BSDF):
        def __init__(self, inner: Any) -> None:
            super().__init__(mi.Properties())
            self.inner = inner
            null = mi.BSDFFlags.Null | mi.BSDFFlags.BackSide
            parts = [inner.flags(number) for number in range(inner.component_count())]
            self.m_components = [*parts, null]
            self.m_flags = inner.flags() | null

        def sample(
            self, context: Any, si: Any, which: Any, where: Any, active: Any = True
        ) -> tuple[Any, Any]:
            front = si.wi.z > 0.0
            bs, value = self.inner.sample(context, si, which, where, active & front)
            bs.wo = dr.select(front, bs.wo, -si.wi)
            bs.pdf = dr.select(front, bs.pdf, 1.0)
            bs.eta = dr.select(front, bs.eta, 1.0)
            null = mi.UInt32(int(mi.BSDFFlags.Null))
            bs.sampled_type = dr.select(front, bs.sampled_type, null)
            bs.sampled_component = dr.select(
                front, bs.sampled_component, mi.UInt32(len(self.m_components) - 1)
            )
            return bs, dr.select(active, dr.select(front, value, mi.Color3f(1.0)), mi.Color3f(0.0))

        def eval_pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
            front = active & (si.wi.z > 0.0)
            value, density = self.inner.eval_pdf(context, si, wo, front)
            return dr.select(front, value, mi.Color3f(0.0)), dr.select(front, density, 0.0)

        def eval(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval_pdf(context, si, wo, active)[0]

        def pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval_pdf(context, si, wo, active)[1]

        def eval_null_transmission(self, si: Any, active: Any = True) -> Any:
            passes = active & (si.wi.z <= 0.0)
            return dr.select(passes, mi.Color3f(1.0), mi.Color3f(0.0))

        def eval_diffuse_reflectance(self, si: Any, active: Any = True) -> Any:
            return self.inner.eval_diffuse_reflectance(si, active)

        def to_string(self) -> str:
            return f"OneSided[{self.inner}]"

    return OneSided
