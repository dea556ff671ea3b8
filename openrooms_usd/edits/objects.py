"""What a scene holds, as Python has it: objects and their parts, which can be changed.

Any USD scene can be read. What is changed of a composed room goes to its edits (`arranging`,
`assigning`, `remaking`); another file has no layer for that, and says so.
"""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.edits import arranging, assigning, remaking, views
from openrooms_usd.edits.scenefile import ByName, SceneFile
from openrooms_usd.edits.snapping import PlanPoint
from openrooms_usd.edits.targets import Scope
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.rotations import inverse, nearest_rotation, pose
from openrooms_usd.usd.files.diagnostics import quiet
from openrooms_usd.usd.places.frames import TIME, local_to_world, world_from_stage
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shading.materials import bound_material, bound_subsets


@dataclass(frozen=True, repr=False)
class Visible:
    """What objects and parts have in common; it is read from the file whenever it is asked for.

    Attributes:
        path: Its prim.
    """

    _file: SceneFile
    path: str

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.path!r})"

    @property
    def name(self) -> str:
        """The name of its prim."""
        return self.path.rpartition("/")[2]

    @property
    def category(self) -> str:
        """What it is, such as ``chair``; empty where nothing says."""
        return read_label(self._prim, names.CATEGORY) or ""

    @property
    def pose(self) -> Array:
        """(4, 4) world_from_object: Z up, metres; a rotation and a translation without scale."""
        prim = self._prim
        placed = world_from_stage(prim.GetStage()) @ local_to_world(prim, UsdGeom.XformCache(TIME))
        return pose(nearest_rotation(placed[:3, :3]), placed[:3, 3])

    @property
    def bounds(self) -> Array:
        """(2, 3) least and greatest x, y and z in the world, metres; not a number of nothing."""
        return views.extent_of(views.points_of(self._prim))

    @property
    def size(self) -> Array:
        """(3,) width, depth and height along its own axes, metres; with Z up as in the world."""
        points, frame = views.points_of(self._prim), inverse(self.pose)
        return np.asarray(np.ptp(views.extent_of(points @ frame[:3, :3].T), axis=0))

    @property
    def materials(self) -> tuple[views.SceneMaterial, ...]:
        """What its surfaces are made of, in the order of its parts, each once."""
        with quiet():
            found = {
                str(material.GetPath()): material
                for prim in views.surfaces_of(self._prim)
                for material in (bound_material(prim), *(row[1] for row in bound_subsets(prim)))
                if material is not None
            }
            return tuple(map(views.material_of, found.values()))

    def set_material(self, look: str | Mapping[str, Any] | None = None, **fields: Any) -> Self:
        """Let it be made of something else.

        Args:
            look: A family or a substance such as ``oak_planks`` or ``wood``, or a mapping as
                ``materials`` of a room.yaml has it.
            **fields: Further fields of the look: ``color``, ``roughness``, ``metallic``, ``size``,
                ``number``, and ``file``, whose name begins in the current folder.

        Raises:
            DescriptionError: There is no such material or field.
            InputError: The scene has no layer for edits.
            OutputError: The edits or a texture cannot be written.
        """
        said = {"family": look} if isinstance(look, str) else dict(look or {})
        with self._changing("get another material"):
            chosen = assigning.look_of({**said, **fields})
            assigning.assign(self._file.path, self.path, self._scope, chosen, Path())
        return self

    def set_color(
        self, color: Iterable[float], *, roughness: float = 0.5, metallic: float = 0.0
    ) -> Self:
        """Paint it in one colour; ``set_material("oak_planks", color=...)`` keeps a texture.

        Args:
            color: Red, green and blue from 0 to 1, scene-linear Rec.709.
            roughness: Perceptual, 0 to 1.
            metallic: 0 to 1.

        Raises:
            DescriptionError: A number is out of range.
            InputError: The scene has no layer for edits.
            OutputError: The edits cannot be written.
        """
        return self.set_material(color=list(color), roughness=roughness, metallic=metallic)

    def reset_material(self) -> Self:
        """Let it be made of what the description says again.

        Raises:
            InputError: The scene has no layer for edits.
            OutputError: The edits cannot be written.
        """
        with self._changing("get its material back"):
            assigning.unassign(self._file.path, self.path, self._scope)
        return self

    @property
    def _scope(self) -> Scope:
        return "part"

    @property
    def _prim(self) -> Usd.Prim:
        prim = self._file.stage().GetPrimAtPath(self.path)
        if not prim or not prim.IsActive():
            raise InputError(
                "this object is no longer in the scene", place=f"{self._file.path}, {self.path}"
            )
        return prim

    @contextmanager
    def _changing(self, what: str) -> Iterator[None]:
        _check_editable(self._file.path, f"{self.name} cannot {what}")
        with quiet():
            yield


class ScenePart(Visible):
    """A surface of an object, such as the seat of a chair, with all that `Visible` has."""

    @property
    def part(self) -> str:
        """Which part of the object it is, such as ``leg``; empty where nothing says."""
        return read_label(self._prim, names.PART) or ""


class SceneObject(Visible):
    """A piece of furniture or of the room, or an object of any other scene; it is `Visible`, too.

    What is changed of a composed room lies in its ``layers/edits.usda``. What stands on it, light
    and physics follow when the room is composed again.
    """

    @property
    def parts(self) -> ByName[ScenePart]:
        """Its surfaces by name."""
        found = {str(prim.GetPath()): prim for prim in views.surfaces_of(self._prim)}
        return ByName(
            "part", self._file.path, {path: ScenePart(self._file, path) for path in found}
        )

    def place(
        self,
        at: Iterable[float],
        yaw: float | None = None,
        *,
        size: tuple[float, float, float] | None = None,
        snap: bool = False,
    ) -> Self:
        """Put it somewhere, and let it have another size.

        Args:
            at: x, y and, where it shall not keep its height, z of the middle of its base, metres.
            yaw: Degrees, counter-clockwise from above; None: as it is.
            size: Width, depth and height, metres; None: as they are.
            snap: Whether sides within 15 cm of a wall come flush to it, as in the browser.

        Raises:
            InputError: It is not furniture of a composed room, or a number makes no sense.
            OutputError: The edits cannot be written.
        """
        x, y, *z = _numbers(at, "at", (2, 3))
        if size is not None:
            size = _sized(size)
        with self._moving("be placed"):
            heading = arranging.standing(self._prim).yaw if yaw is None else float(yaw)
            arranging.place(
                self._file.path,
                self.name,
                PlanPoint(x, y, heading),
                z=z[0] if z else None,
                size=size,
                snap=snap,
            )
        return self

    def move(self, dx: float = 0.0, dy: float = 0.0, dz: float = 0.0) -> Self:
        """Shift it along the axes of the world, metres.

        Raises:
            InputError: It is not furniture of a composed room, or a number makes no sense.
            OutputError: The edits cannot be written.
        """
        with self._moving("be moved"):
            now = arranging.standing(self._prim)
            shift = _numbers((dx, dy, dz), "move", (3,))
            return self.place(np.add((now.x, now.y, now.z), shift).tolist())

    def turn(self, degrees: float) -> Self:
        """Turn it about its own origin, counter-clockwise from above.

        Raises:
            InputError: It is not furniture of a composed room, or a number makes no sense.
            OutputError: The edits cannot be written.
        """
        with self._moving("be turned"):
            now = arranging.standing(self._prim)
            (turn,) = _numbers((degrees,), "turn", (1,))
            return self.place((now.x, now.y), now.yaw + turn)

    def remove(self) -> None:
        """Take it away; it comes back when the opinion is removed from the edits.

        Raises:
            InputError: It is not furniture of a composed room.
            OutputError: The edits cannot be written.
        """
        with self._moving("be removed"):
            arranging.remove(self._file.path, self.name)

    def duplicate(self) -> "SceneObject":
        """Put a copy beside it, which follows when the original gets another model or material.

        Raises:
            InputError: It is not furniture of a composed room.
            OutputError: The edits cannot be written.
        """
        with self._moving("be copied"):
            copy = arranging.duplicate(self._file.path, self.name)
        return SceneObject(self._file, f"{names.FURNITURE}/{copy.name}")

    def relabel(self, category: str) -> Self:
        """Call it something else; its mesh stays.

        Raises:
            DescriptionError: There is no such category.
            InputError: It is not furniture of a composed room.
            OutputError: The edits cannot be written.
        """
        with self._moving("be called something else"):
            arranging.relabel(self._file.path, self.name, category)
        return self

    def remake(self, style: str, category: str | None = None, *, keep_size: bool = True) -> Self:
        """Let the library make another model in its place.

        Args:
            style: One of the category's styles.
            category: What it becomes; None for what it is.
            keep_size: Whether it is as large as before, or as such a thing usually is.

        Raises:
            InputError: It is not furniture of a composed room, or there is no such style.
            OutputError: The edits or a model cannot be written.
        """
        with self._moving("be made anew"):
            remaking.remake(self._file.path, self.name, style, category, keep_size=keep_size)
        return self

    @property
    def _scope(self) -> Scope:
        return "object" if self._is_furniture else "part"

    @property
    def _is_furniture(self) -> bool:
        return self.path.rpartition("/")[0] == names.FURNITURE

    @contextmanager
    def _moving(self, what: str) -> Iterator[None]:
        with self._changing(what):
            if not self._is_furniture:
                raise InputError(
                    f"{self.name} cannot {what}: it is part of the room's shell",
                    place=f"{self._file.path}, {self.path}",
                    remedy=f"only objects below {names.FURNITURE} can; change the layout in the "
                    "description and compose again",
                )
            yield


def objects_of(file: SceneFile) -> ByName[SceneObject]:
    """The furniture of a composed room, or the objects of any other scene.

    In other scenes an object is what the channel ``instance`` takes for one: the nearest labelled
    prim above a surface, else the nearest component, else the surface itself.
    """
    stage = file.stage()
    if group := stage.GetPrimAtPath(names.FURNITURE):
        furniture = filter(UsdGeom.Xformable, group.GetChildren())
        return ByName("object", file.path, _things(file, furniture), _shell(file))
    return ByName("object", file.path, _things(file, views.owners_of(stage.GetPseudoRoot())))


def shell_of(file: SceneFile) -> ByName[SceneObject]:
    """Floor, ceiling, walls, doors, windows and trim of a composed room; nothing elsewhere."""
    return ByName("part of the room", file.path, _shell(file))


def _shell(file: SceneFile) -> dict[str, SceneObject]:
    room = file.stage().GetPrimAtPath(names.ROOM)
    return _things(file, views.owners_of(room) if room else ())


def materials_of(file: SceneFile) -> ByName[views.SceneMaterial]:
    """All materials that something in a scene is made of."""
    whole = Visible(file, str(Sdf.Path.absoluteRootPath))
    return ByName("material", file.path, {row.path: row for row in whole.materials})


def add(file: SceneFile, said: Mapping[str, Any], base: Path | None = None) -> SceneObject:
    """Put a new object into a composed room: see `openrooms_usd.edits.remaking.add`."""
    _check_editable(file.path, f"a {said['category']} cannot be added")
    with quiet():
        stands = remaking.add(file.path, said, base)
    return SceneObject(file, f"{names.FURNITURE}/{stands.name}")


def _check_editable(path: Path, what: str) -> None:
    edits = path.parent / names.LAYERS / f"{names.EDITS}.usda"
    if not edits.is_file():
        raise InputError(
            f"{what}: this is not a composed room with a {names.LAYERS}/{names.EDITS}.usda",
            place=path,
            remedy="compose a room and edit that; other files can be read, and edited with pxr",
        )


def _things(file: SceneFile, prims: Iterable[Usd.Prim]) -> dict[str, SceneObject]:
    paths = [str(prim.GetPath()) for prim in prims]
    return {path: SceneObject(file, path) for path in paths}


def _numbers(given: Iterable[float], what: str, counts: tuple[int, ...]) -> list[float]:
    try:
        found = [float(value) for value in given]
    except (TypeError, ValueError):
        found = []
    if len(found) not in counts or not np.isfinite(found).all():
        wanted = " or ".join(map(str, counts))
        raise InputError(f"expected {wanted} finite numbers, found {given!r}", place=what)
    return found


def _sized(given: Iterable[float]) -> tuple[float, float, float]:
    width, depth, height = _numbers(given, "size", (3,))
    if min(width, depth, height) <= 0.0:
        raise InputError(f"a size must be positive, got {given!r}", place="size")
    return width, depth, height
