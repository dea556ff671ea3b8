"""Instances, which share their triangles, and several triangles one after the other."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.rendering.scene.triangles import Ints, Triangles

# Triangles of instances that are expanded at once: about half a kilobyte each, meanwhile.
_MOST_TRIANGLES: Final = 1 << 18


class Instances(Triangles):
    """The same triangles in many places, expanded only on demand.

    They lie one instance after the other. Where a transform mirrors, the winding is turned round,
    so that the front stays the front.

    Args:
        prototype: The triangles in their own frame; their pieces say nothing.
        world_from_prototype: (K, 4, 4) any invertible affine transforms, for column vectors.
        owners: (K,) row of `Scene.pieces` of each instance.
    """

    def __init__(self, prototype: Triangles, world_from_prototype: Array, owners: Ints) -> None:
        # The fields of plain triangles are computed; an assignment would be refused.
        vars(self).update(
            prototype=prototype, world_from_prototype=world_from_prototype, owners=owners
        )

    prototype: Triangles
    world_from_prototype: Array
    owners: Ints

    def __len__(self) -> int:
        return len(self.owners) * len(self.prototype)

    @cached_property
    def corners(self) -> Any:
        """See `Triangles`."""
        return self._expanded(self._corners, self.prototype.corners)

    @cached_property
    def normals(self) -> Any:
        """See `Triangles`."""
        return self._expanded(self._normals, self.prototype.normals)

    @cached_property
    def st(self) -> Any:
        """See `Triangles`."""
        return self._expanded(self._st, self.prototype.st)

    @cached_property
    def pieces(self) -> Any:
        """See `Triangles`."""
        return np.repeat(self.owners, len(self.prototype))

    def rows(self, which: Any) -> Triangles:
        """See `Triangles.rows`; no others are expanded."""
        numbers = _numbers(which, len(self))
        if not len(numbers):
            return Triangles.of(())
        instances, own = np.divmod(numbers, max(len(self.prototype), 1))
        of = self.prototype.rows(own)
        return Triangles(
            self._corners(of.corners[:, None], instances)[:, 0],
            self._normals(of.normals[:, None], instances)[:, 0],
            self._st(of.st[:, None], instances)[:, 0],
            self.owners[instances],
        )

    def centred(self) -> "Instances":
        """The same, of a prototype about its own middle: far from it single precision is coarse."""
        middle = self.prototype.hull.mean(axis=0)
        matrices = self.world_from_prototype.copy()
        matrices[:, :3, 3] += matrices[:, :3, :3] @ middle
        prototype = replace(self.prototype, corners=self.prototype.corners - middle)
        return Instances(prototype, matrices, self.owners)

    def seen_from(self, origin: Array) -> Array:
        """(K, 4, 4) where they stand relative to a point of the world."""
        matrices = self.world_from_prototype.copy()
        matrices[:, :3, 3] -= origin
        return matrices

    def forget(self) -> None:
        """Drop what was expanded, until the next demand."""
        for one in fields(Triangles):
            vars(self).pop(one.name, None)

    @property
    def landmarks(self) -> Array:
        """See `Triangles.landmarks`."""
        return np.asarray(self._corners(self.prototype.corners[None, :1], slice(None))[:, 0, 0])

    @property
    def hull(self) -> Array:
        """See `Triangles.hull`: the corners of boxes."""
        points = self.prototype.corners.reshape(-1, 3)
        ends = np.stack([points.min(axis=0), points.max(axis=0)], axis=1)
        box = np.stack(np.meshgrid(*ends, indexing="ij"), axis=-1).reshape(1, -1, 1, 3)
        return np.asarray(self._corners(box, slice(None)).reshape(-1, 3))

    def of_pieces(self, chosen: Mask) -> Triangles:
        """See `Triangles.of_pieces`."""
        which = chosen[self.owners]
        if which.all():
            return self
        return Instances(self.prototype, self.world_from_prototype[which], self.owners[which])

    def moved(self, motions: Mapping[int, Array]) -> Triangles:
        """See `Triangles.moved`."""
        matrices = self.world_from_prototype.copy()
        for piece, motion in motions.items():
            matrices[self.owners == piece] = motion @ matrices[self.owners == piece]
        return Instances(self.prototype, matrices, self.owners)

    @cached_property
    def mirrored(self) -> Mask:
        """(K,) which transforms turn the winding round."""
        return np.asarray(np.linalg.det(self.world_from_prototype[:, :3, :3]) < 0.0)

    @cached_property
    def _inverse(self) -> Array:
        """(K, 3, 3) what row vectors that are normals are multiplied with."""
        return np.asarray(np.linalg.inv(self.world_from_prototype[:, :3, :3]))

    def _expanded(self, place: Callable[[Any, Any], Any], values: Any) -> Any:
        """(M, 3, C) values of the prototype's corners in all instances, some at once."""
        size = len(values)
        found = np.empty((len(self), *values.shape[1:]), values.dtype)
        step = max(1, _MOST_TRIANGLES // max(size, 1))
        for start in range(0, len(self.owners), step):
            some = slice(start, min(start + step, len(self.owners)))
            rows = slice(some.start * size, some.stop * size)
            found[rows] = place(values[None], some).reshape(-1, *values.shape[1:])
        return found

    # Each takes values of (K or 1, M, 3) corners, and the instances that they are of.

    def _corners(self, values: Any, instances: Any) -> Any:
        matrices = self.world_from_prototype[instances]
        flat = values.reshape(len(values), -1, 3) @ matrices[:, :3, :3].swapaxes(1, 2)
        flat += matrices[:, None, :3, 3]
        return self._wound(flat.reshape(len(matrices), *values.shape[1:]), instances)

    def _normals(self, values: Any, instances: Any) -> Any:
        inverse = self._inverse[instances]
        # Those of flat triangles are one number for three corners.
        distinct = values if values.strides[2] else values[:, :, :1]
        turned = unit(distinct.reshape(len(values), -1, 3).astype(np.float64) @ inverse)
        found = turned.astype(np.float32).reshape(len(inverse), *distinct.shape[1:])
        return self._wound(np.broadcast_to(found, (len(inverse), *values.shape[1:])), instances)

    def _st(self, values: Any, instances: Any) -> Any:
        count = len(self.owners[instances])
        return self._wound(np.broadcast_to(values, (count, *values.shape[1:])), instances)

    def _wound(self, values: Any, instances: Any) -> Any:
        mirrored = self.mirrored[instances]
        if not mirrored.any():
            return values
        return np.where(mirrored[:, None, None, None], values[:, :, ::-1], values)


def _numbers(which: Any, size: int) -> NDArray[np.int64]:
    """Rows by their numbers, of so many: there may be a hundred million, of which few are asked."""
    if isinstance(which, slice):
        return np.arange(*which.indices(size))
    rows = np.asarray(which)
    return np.flatnonzero(rows) if rows.dtype == np.bool_ else rows % max(size, 1)


def _of_parts(name: str) -> Any:
    """A field of plain triangles: the same of all parts, put together once."""
    return cached_property(lambda one: np.concatenate([getattr(part, name) for part in one.parts]))


class _Several(Triangles):
    """Plain triangles and instances, one after the other; made plain only on demand."""

    def __init__(self, parts: Sequence[Triangles]) -> None:
        ends = np.cumsum([0, *map(len, parts)])
        vars(self).update(_parts=tuple(parts), _ends=ends)

    _parts: tuple[Triangles, ...]
    _ends: NDArray[np.int64]

    def __len__(self) -> int:
        return int(self._ends[-1])

    @property
    def parts(self) -> tuple[Triangles, ...]:
        """See `Triangles.parts`."""
        return self._parts

    corners: Any = _of_parts("corners")
    normals: Any = _of_parts("normals")
    st: Any = _of_parts("st")
    pieces: Any = _of_parts("pieces")

    def rows(self, which: Any) -> Triangles:
        """See `Triangles.rows`."""
        numbers = _numbers(which, len(self))
        of = np.searchsorted(self._ends, numbers, side="right") - 1
        found = Triangles(
            np.empty((len(numbers), 3, 3)),
            np.empty((len(numbers), 3, 3), np.float32),
            np.empty((len(numbers), 3, 2), np.float32),
            np.empty(len(numbers), np.int32),
        )
        for part in np.unique(of):
            here = of == part
            some = self._parts[part].rows(numbers[here] - self._ends[part])
            for one in fields(Triangles):
                getattr(found, one.name)[here] = getattr(some, one.name)
        return found

    @property
    def landmarks(self) -> Array:
        """See `Triangles.landmarks`."""
        return np.concatenate([part.landmarks for part in self._parts])

    @property
    def hull(self) -> Array:
        """See `Triangles.hull`."""
        return np.concatenate([part.hull for part in self._parts])

    def of_pieces(self, chosen: Mask) -> Triangles:
        """See `Triangles.of_pieces`."""
        return joined([part.of_pieces(chosen) for part in self._parts])

    def moved(self, motions: Mapping[int, Array]) -> Triangles:
        """See `Triangles.moved`."""
        return _Several([part.moved(motions) for part in self._parts])


def joined(parts: Sequence[Triangles]) -> Triangles:
    """All triangles of several, in their order; instances stay what they are."""
    every = [part for whole in parts for part in whole.parts if len(part)]
    if len(every) == 1:
        return every[0]
    if any(isinstance(part, Instances) for part in every):
        return _Several(every)
    return Triangles.of(every)
