"""A stage as arrays: what renderers receive, and what ground truth is looked up in."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from openrooms_usd.arrays import Array, Floats, Ints, Mask
from openrooms_usd.exporters import Report
from openrooms_usd.rendering.scene.instances import joined
from openrooms_usd.rendering.scene.legend import Legend
from openrooms_usd.rendering.scene.pictures import Value
from openrooms_usd.rendering.scene.surfaces import Surface
from openrooms_usd.rendering.scene.triangles import Triangles
from openrooms_usd.usd.light.lights import Portal
from openrooms_usd.usd.light.profiles import Shaping
from openrooms_usd.usd.shapes.meshes import is_outside


@dataclass(frozen=True, eq=False)
class Patch:
    """Triangles that share a surface; one shape of the renderer.

    Attributes:
        name: An identifier, unique in the scene.
        triangles: Its triangles.
        surface: What it does to light.
        radiance: What its front side emits, nits; None where it is dark.
        shaping: What that is multiplied with by direction; None: with nothing.
        lamp: The prim of the light that it is; empty where it is dark.
        unlit_by: The prims of lamps that do not light it.
        response: Of a lamp, factors of what it does on all surfaces but metals, and on metals.
        unseen: Of a lamp, whether it lights without being seen.
    """

    name: str
    triangles: Triangles
    surface: Surface
    radiance: Value | None = None
    shaping: Shaping | None = field(default=None, kw_only=True)
    lamp: str = field(default="", kw_only=True)
    unlit_by: tuple[str, ...] = field(default=(), kw_only=True)
    response: tuple[float, float] = field(default=(1.0, 1.0), kw_only=True)
    unseen: bool = field(default=False, kw_only=True)

    def at(self, triangles: Triangles) -> "Patch":
        """The same with its triangles elsewhere, after a rigid motion of each of its pieces."""
        if self.shaping is None or not len(triangles):
            return replace(self, triangles=triangles)
        turn = _rotation(self.triangles.corners, triangles.corners)
        return replace(self, triangles=triangles, shaping=self.shaping.turned(turn))

    def flux_share(self) -> float:
        """What its flux is multiplied with by its shaping; 1 without one."""
        if self.shaping is None:
            return 1.0
        a, b, c = np.moveaxis(self.triangles.corners, 1, 0)
        crosses = np.cross(b - a, c - a)
        doubled = np.linalg.norm(crosses, axis=1)
        normals = crosses / np.where(doubled > 0.0, doubled, 1.0)[:, None]
        return self.shaping.mean_over(normals, 0.5 * doubled)


@dataclass(frozen=True, eq=False)
class Pane(Patch):
    """Triangles of thin clear panes, whose `Surface.pane` says what they let through.

    Attributes:
        is_sheet: Whether each triangle is a pane, seen from either side. Else they bound solids,
            and a ray meets the pane where it goes in.
    """

    is_sheet: bool = False

    def sheet(self) -> Patch:
        """The pane as renderers know it that let each triangle be one: of a solid half remains.

        A ray through a thin solid goes in at one side and out at the other; the side that faces
        along its largest triangle stands for both.
        """
        if self.is_sheet or not len(self.triangles):
            return self
        a, b, c = np.moveaxis(self.triangles.corners, 1, 0)
        crosses = np.cross(b - a, c - a)
        largest = crosses[np.argmax(np.einsum("ni,ni->n", crosses, crosses))]
        return self.at(self.triangles.rows(crosses @ largest > 0.0))


@dataclass(frozen=True, eq=False)
class Environment:
    """The surroundings at infinity.

    Attributes:
        pixels: (H, W, 3) nits, latitude-longitude from pole to pole; one pixel where it is
            constant.
        world_from_light: (3, 3) rotation; in the light's frame +Y is the picture's upper edge, its
            middle lies along +Z, a quarter from the left along +X.
    """

    pixels: Floats
    world_from_light: Array


@dataclass(frozen=True, eq=False)
class Sun:
    """Parallel light.

    Attributes:
        direction: (3,) unit vector along which it travels.
        irradiance: (3,) lux of each primary on a surface that faces it.
        angle: Its angular diameter, degrees.
        path: Its prim.
    """

    direction: Array
    irradiance: Array
    angle: float = 0.0
    path: str = ""


@dataclass(frozen=True)
class PixelLabels:
    """What the pixels of a piece of surface are labelled with; 0 is nothing."""

    instance: int = 0
    part: int = 0
    material: int = 0
    semantic: int = 0
    semantic_nyu40: int = 0
    semantic_ade20k: int = 0
    semantic_coco: int = 0


@dataclass(frozen=True, eq=False)
class Scene:
    """A translated stage.

    Attributes:
        patches: All surfaces.
        pieces: What the triangles' labels are.
        environment: The surroundings, if there are any.
        suns: Parallel lights.
        portals: Where the surroundings come in; empty where the stage does not say.
        legend: What the label numbers mean.
        owners: Prims by path with the surface that they gave: materials, and meshes without one.
        report: What became of every prim.
        folder: Where the stage's file lies, for what is kept beside it; None where it has none.
        panes: Clear panes, which are not patches: geometry and labels look through them. Light
            passes straight through, less what they reflect and absorb.
        exposure: What pictures of it are multiplied by where its cameras do not say; None: what
            fits each.
    """

    patches: tuple[Patch, ...]
    pieces: tuple[PixelLabels, ...]
    environment: Environment | None
    suns: tuple[Sun, ...]
    portals: tuple[Portal, ...]
    legend: Legend
    owners: tuple[tuple[str, Surface], ...] = ()
    report: Report = field(default_factory=Report)
    folder: Path | None = None
    panes: tuple[Pane, ...] = ()
    exposure: float | None = None

    def placed(self, triangles: Sequence[Triangles]) -> "Scene":
        """The same with the triangles of its patches and panes elsewhere; the origin stays.

        Args:
            triangles: Of each patch, then of each pane; those that are its own leave it the same
                object.
        """
        pairs = zip((*self.patches, *self.panes), triangles, strict=True)
        every = [patch if patch.triangles is own else patch.at(own) for patch, own in pairs]
        count = len(self.patches)
        panes = tuple(pane for pane in every[count:] if isinstance(pane, Pane))
        found = replace(self, patches=tuple(every[:count]), panes=panes)
        # The property is cached: what others hold relative to the origin stays true.
        found.__dict__["origin"] = self.origin
        return found

    @cached_property
    def triangles(self) -> Triangles:
        """The triangles of all patches, patch by patch."""
        return joined([patch.triangles for patch in self.patches])

    @cached_property
    def indoors(self) -> Mask:
        """(M,) which of `triangles` do not belong to the surroundings outside the windows."""
        return self._indoor_pieces[self.triangles.pieces]

    @property
    def has_outside(self) -> bool:
        """Whether anything stands outside before the windows."""
        return not self._indoor_pieces.all()

    @cached_property
    def _indoor_pieces(self) -> Mask:
        paths = self.legend.part
        outside = [is_outside(paths.get(piece.part, "")) for piece in self.pieces]
        return ~np.array([*outside, False])

    @cached_property
    def _indoor_triangles(self) -> Triangles:
        return self.triangles.of_pieces(self._indoor_pieces)

    @cached_property
    def offsets(self) -> Ints:
        """(P + 1,) the first triangle of each patch, and the number of all."""
        return np.cumsum([0, *(len(patch.triangles) for patch in self.patches)])

    @cached_property
    def radius(self) -> float:
        """Metres; of a sphere about `origin` that holds all surfaces."""
        return self._reach(self.triangles)

    @cached_property
    def room_radius(self) -> float:
        """Metres; of a sphere about `origin` that holds all surfaces but those outside."""
        return self._reach(self._indoor_triangles)

    def _reach(self, triangles: Triangles) -> float:
        if not len(triangles):
            return 1.0
        return float(np.sqrt(((triangles.hull - self.origin) ** 2).sum(axis=-1).max()))

    @cached_property
    def origin(self) -> Array:
        """(3,) whole metres in the middle of the scene.

        Renderers work in single precision: what they get is relative to this.
        """
        if not len(self._indoor_triangles):
            return np.zeros(3)
        return np.round(np.median(self._indoor_triangles.landmarks, axis=0))


def _rotation(before: Array, after: Array) -> Array:
    """(3, 3) of the rigid motion that takes (M, 3, 3) corners to others: Kabsch's."""
    old, new = (one.reshape(-1, 3) - one.reshape(-1, 3).mean(axis=0) for one in (before, after))
    u, _, vt = np.linalg.svd(new.T @ old)
    return np.asarray(u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt)
