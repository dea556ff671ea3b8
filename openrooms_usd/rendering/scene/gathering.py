"""Surfaces of a stage as shapes of a renderer: triangles of one kind are gathered to one."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.rendering.scene import lamps
from openrooms_usd.rendering.scene.arrays import Pane, Patch
from openrooms_usd.rendering.scene.instances import Instances, joined
from openrooms_usd.rendering.scene.pictures import Value
from openrooms_usd.rendering.scene.surfaces import Surface
from openrooms_usd.rendering.scene.triangles import Ints, Triangles
from openrooms_usd.usd.light.profiles import Shaping
from openrooms_usd.usd.shapes.meshes import PlacedMesh, TriangleMesh

# Where instances save fewer triangles than these in all, they are expanded: plain triangles are
# looked up faster, and in a room they cost little.
LEAST_SAVED_TRIANGLES: Final = 1 << 18
# Of a stage that has more, a mesh that saves fewer is expanded all the same.
_LEAST_SAVED_BY_ONE: Final = 1 << 10


@dataclass
class Gathered:
    """Triangles that will be one shape.

    Attributes:
        surface: What they do to light.
        radiance: What they emit, nits; None where they are dark.
        is_sheet: Whether each triangle of a clear pane is one.
        shaping: What their light is multiplied with by direction.
        lamp: The prim of the light that they are; empty where they are dark.
        unlit_by: The prims of lamps that do not light them.
        unseen: Whether they light without being seen.
    """

    surface: Surface
    radiance: Value | None
    is_sheet: bool
    shaping: Shaping | None
    lamp: str
    unlit_by: tuple[str, ...]
    unseen: bool = False
    _plain: list[Triangles] = field(default_factory=list)
    _placed: dict[tuple[int, bytes, int], "_Prototype"] = field(default_factory=dict)

    def add(self, triangles: Triangles) -> None:
        """Add triangles that stand in the world."""
        self._plain.append(triangles)

    def place(self, mesh: PlacedMesh, rows: Ints, st: Floats, piece: int) -> None:
        """Add triangles of a mesh where it stands.

        Args:
            mesh: The mesh.
            rows: Which of its triangles, in order.
            st: (M, 3, 2) texture coordinates of all; instances of one prototype share the object.
            piece: Row of `Scene.pieces`.
        """
        is_whole = len(rows) == len(mesh.mesh.triangles)
        key = id(mesh.mesh), b"" if is_whole else rows.tobytes(), id(st)
        if key not in self._placed:
            self._placed[key] = _Prototype(mesh.mesh, rows, st)
        self._placed[key].matrices.append(mesh.world_from_local)
        self._placed[key].pieces.append(piece)

    def saved(self) -> int:
        """How many triangles there are less, where instances share theirs."""
        return sum(one.saved for one in self._placed.values()) if self._may_share else 0

    def take(self, *, share: bool) -> tuple[list[Triangles], list[Triangles]]:
        """All triangles, which are then no longer here: those that are plain, and instances.

        Args:
            share: Whether instances stay what they are, where that saves enough.
        """
        plain, shared = self._plain, list[Triangles]()
        for prototype in self._placed.values():
            instances = prototype.instances()
            if share and self._may_share and prototype.saved >= _LEAST_SAVED_BY_ONE:
                shared.append(instances)
            else:
                plain.append(instances)
        self._plain, self._placed = [], {}
        return plain, shared

    @property
    def _may_share(self) -> bool:
        # Lamps are sampled by their triangles, and panes looked up by theirs.
        return self.radiance is None and self.surface.pane is None


@dataclass
class _Prototype:
    """Some triangles of a mesh, and where they stand."""

    mesh: TriangleMesh
    rows: Ints
    st: Floats
    matrices: list[Array] = field(default_factory=list)
    pieces: list[int] = field(default_factory=list)

    @property
    def saved(self) -> int:
        return (len(self.matrices) - 1) * len(self.rows)

    def instances(self) -> Instances:
        # All in order are taken without a copy.
        is_whole = len(self.rows) == len(self.mesh.triangles)
        rows: Any = slice(None) if is_whole else self.rows
        corners = self.mesh.points[self.mesh.triangles[rows]]
        if self.mesh.normals is None:
            a, b, c = np.moveaxis(corners, 1, 0)
            flat = unit(np.cross(b - a, c - a)).astype(np.float32)
            normals = np.broadcast_to(flat[:, None], corners.shape)
        else:
            normals = self.mesh.normals[rows]
        own = Triangles(corners, normals, self.st[rows], np.zeros(len(corners), np.int32))
        return Instances(own, np.array(self.matrices), np.array(self.pieces, np.int32))


def _expanded(groups: Iterable[list[Triangles]]) -> Triangles:
    """Triangles in one piece of memory; the groups are emptied, so that none lies there twice."""
    lists = list(groups)
    total = sum(len(part) for parts in lists for part in parts)
    found = Triangles(
        np.empty((total, 3, 3)),
        np.empty((total, 3, 3), np.float32),
        np.empty((total, 3, 2), np.float32),
        np.empty(total, np.int32),
    )
    start = 0
    for parts in lists:
        for part in parts:
            room = found.rows(slice(start, start + len(part)))
            start += len(part)
            for one in fields(Triangles):
                getattr(room, one.name)[...] = getattr(part, one.name)
            if isinstance(part, Instances):
                part.forget()
        parts.clear()
    return found


def shapes(
    gathered: Sequence[Gathered], responses: dict[str, tuple[float, float]]
) -> tuple[tuple[Patch, ...], tuple[Pane, ...]]:
    """Patches and panes, in the order in which they were gathered.

    Plain triangles lie in memory once: those of patches are views of all.

    Args:
        gathered: All groups, which are empty afterwards.
        responses: Of lamps by prim, factors of what they do on surfaces; 1 of others.
    """
    groups = sorted(gathered, key=lambda group: group.surface.pane is not None)
    share = sum(group.saved() for group in groups) >= LEAST_SAVED_TRIANGLES
    taken = [group.take(share=share) for group in groups]
    sizes = [sum(map(len, plain)) for plain, _ in taken]
    every = _expanded(plain for plain, _ in taken)
    patches: list[Patch] = []
    panes: list[Pane] = []
    for group, own, (_, shared) in zip(groups, every.split(sizes), taken, strict=True):
        if group.surface.pane is not None:
            name = f"pane_{len(panes) + 1}"
            panes.append(Pane(name, own, group.surface, is_sheet=group.is_sheet))
            continue
        shines = group.radiance is not None and lamps.is_extended(own)
        patches.append(
            Patch(
                f"patch_{len(patches) + 1}",
                joined([own, *shared]),
                group.surface,
                group.radiance if shines else None,
                shaping=group.shaping,
                lamp=group.lamp,
                unlit_by=group.unlit_by,
                response=responses.get(group.lamp, (1.0, 1.0)),
                unseen=group.unseen,
            )
        )
    return tuple(patches), tuple(panes)
