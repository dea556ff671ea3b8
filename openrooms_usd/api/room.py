"""A room that is built step by step; every step is checked, and is plain data in the end."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

from pydantic import ConfigDict

from openrooms_usd import description
from openrooms_usd.api.given import AnyPath, path_of, unknown_name
from openrooms_usd.description.former import name_in
from openrooms_usd.description.furniture import PlacedObject
from openrooms_usd.errors import InputError
from openrooms_usd.names import section_of
from openrooms_usd.progress import Progress, silent

if TYPE_CHECKING:
    from openrooms_usd.api.scene import Scene

Point: TypeAlias = Sequence[float | str]
"""x, y and perhaps z: metres, or texts with a unit such as ``"120 cm"``."""

_SURFACES: Final = ("floor", "walls", "ceiling", "trim", "beams")


class Room(description.Room):
    """A room as ``room.yaml`` describes it, which can be built step by step.

    Each method changes the room, or raises a `DescriptionError` that names the field and leaves it
    as it was. Those that add something return its name, by which others speak about it:
    ``lamp = room.add("table_lamp", at=(1, 1), on=desk)``. Lengths are metres, or texts such as
    ``"120 cm"``; angles degrees, counter-clockwise from above. Sections are replaced by assignment:
    ``room.seed = 4``.
    """

    model_config = ConfigDict(frozen=False)

    def __setattr__(self, name: str, value: Any) -> None:
        """Replace a section, or raise a `DescriptionError` and leave it as it was."""
        if (section := section_of(name)) in type(self).model_fields:
            self._change({**self.as_dict(), section: value})
        else:
            super().__setattr__(name, value)

    @classmethod
    def of(cls, room: description.Room) -> "Room":
        """A room from the same description, to be changed by itself."""
        made: Room = cls.model_construct()
        made._take(room)
        made._folder = room.folder
        return made

    def add(
        self,
        category: str,
        at: Point,
        *,
        yaw: float | str | None = None,
        name: str | None = None,
        size: Point | None = None,
        style: str | None = None,
        file: AnyPath | None = None,
        on: str | None = None,
        relative_to: str | None = None,
        **fields: Any,
    ) -> str:
        """Add an object.

        Args:
            category: What it is, such as ``chair``; the library makes it.
            at: x, y and, where nothing that carries it says that, z of the middle of its base.
            yaw: Its heading; at 0 its front looks along -Y.
            name: Its name; by default its category and a number.
            size: Width, depth and height; by default as usual.
            style: One of the category's styles; drawn by default.
            file: An OBJ, GLB, PLY, STL, URDF or USD file to take in place of the library, relative
                to the room's folder.
            on: What carries it: ``floor``, ``ceiling``, ``wall`` or another object's name.
            relative_to: Another object's name: ``at`` and ``yaw`` are in its frame.
            **fields: Further fields of an object (docs/reference/description.md), such as ``tilt``.

        Returns:
            Its name.

        Raises:
            InputError: The name is taken, or the objects are generated when it is composed.
        """
        said = {"yaw": yaw, "name": name, "size": size, "style": style, "on": on}
        source = {} if file is None else {"from": "file", "file": str(path_of(file))}
        if name in dict(self._named()):
            # Else the other one would be numbered anew, and what stands on it would move.
            raise InputError("an object has this name", place=name, remedy="give another name")
        data, place = self.as_dict(), {"at": at, "relative_to": relative_to}
        row = given_of(category=category, **place, **source, **said, **fields)
        self._rows(data, "furniture", "objects").append(row)
        self._change(data)
        return self._named()[-1][0]

    def add_window(
        self,
        wall: int | None = None,
        *,
        at: float | str | None = None,
        width: float | str | None = None,
        height: float | str | None = None,
        sill: float | str | None = None,
        name: str | None = None,
        **fields: Any,
    ) -> str:
        """Cut a window into a wall.

        Args:
            wall: The wall's number: wall i runs from corner i to corner i + 1.
            at: From the wall's start to the window's middle; by default the wall's middle.
            width: By default 1.2 m.
            height: By default 1.3 m.
            sill: Its lower edge above the floor; by default 0.9 m.
            name: Its name; by default ``window`` and a number.
            **fields: Further fields of an opening, such as ``style`` or ``partition``.

        Returns:
            Its name.

        Raises:
            InputError: The layout is generated when the room is composed.
        """
        said = {"at": at, "width": width, "height": height, "sill": sill, "name": name}
        return self._open("window", wall, {**said, **fields})

    def add_door(
        self,
        wall: int | None = None,
        *,
        at: float | str | None = None,
        width: float | str | None = None,
        height: float | str | None = None,
        open: float | str | None = None,
        name: str | None = None,
        **fields: Any,
    ) -> str:
        """Cut a door into a wall.

        Args:
            wall: The wall's number: wall i runs from corner i to corner i + 1.
            at: From the wall's start to the door's middle; by default the wall's middle.
            width: By default 0.9 m.
            height: By default 2.05 m.
            open: How far its leaf stands open, degrees; by default it is shut.
            name: Its name; by default ``door`` and a number.
            **fields: Further fields of an opening, such as ``hinge``, ``swing`` or ``style``.

        Returns:
            Its name.

        Raises:
            InputError: The layout is generated when the room is composed.
        """
        said = {"at": at, "width": width, "height": height, "open": open, "name": name}
        return self._open("door", wall, {**said, **fields})

    def add_opening(self, wall: int | None = None, **fields: Any) -> str:
        """Cut a passage without a leaf into a wall, as `add_door` does one with a leaf."""
        return self._open("opening", wall, fields)

    def add_camera(
        self,
        eye: Point | None = None,
        target: Point | None = None,
        *,
        world_from_camera: Any = None,
        fov: float | str | None = None,
        name: str | None = None,
        **fields: Any,
    ) -> str:
        """Add a camera, from which renders are made by default.

        Args:
            eye: Where it stands.
            target: What it looks at.
            world_from_camera: (3, 4) or (4, 4) in their place: from the OpenCV frame (x right,
                y down, z forward) to the world, metres.
            fov: Horizontal field of view, degrees; by default 60.
            name: Its name; by default ``camera`` and a number.
            **fields: Further fields of a view, such as ``f_stop``, ``focus``, ``exposure_value``.

        Returns:
            Its name.
        """
        data = self.as_dict()
        rows = self._rows(data, "cameras", "views")
        M = None if world_from_camera is None else [list(row) for row in world_from_camera][:3]
        called = name or f"camera_{len(rows)}"
        rows.append(
            given_of(eye=eye, target=target, world_from_camera=M, fov=fov, name=called, **fields)
        )
        self._change(data)
        return called

    def select_cameras(self, count: int = 3, **fields: Any) -> None:
        """Select this many good views when the room is composed (docs/reference/description.md)."""
        data = self.as_dict()
        self._rows(data, "cameras", "views").append(
            given_of(**{"from": "select"}, count=count, **fields)
        )
        self._change(data)

    def set_lamp(
        self,
        name: str,
        *,
        lumen: float | None = None,
        kelvin: float | None = None,
        color: Sequence[float] | None = None,
        on: bool | None = None,
        **fields: Any,
    ) -> None:
        """Set what a lamp emits.

        Args:
            name: The object's.
            lumen: Its luminous flux.
            kelvin: Its colour temperature.
            color: Its hue in place of ``kelvin``, scene-linear Rec.709.
            on: Whether it is on; one that is off keeps its shape and is dark.
            **fields: ``radiance``, ``profile`` and ``beam``.
        """
        said = given_of(lumen=lumen, kelvin=kelvin, color=color, on=on, **fields)
        self.update(lights={"lamps": {name: said}})

    def set_environment(self, **fields: Any) -> None:
        """Set the light outside the openings; it replaces the previous setting.

        Args:
            **fields: A panorama (``file``), a sky (``latitude``, ``longitude``, ``date``,
                ``time``), houses and gardens under one (``scene``), or the same light from
                everywhere (``illuminance``, ``color``): docs/reference/description.md has all.
        """
        data = self.as_dict()
        data.setdefault("lights", {})["environment"] = given_of(**fields)
        self._change(data)

    def set_material(
        self,
        what: str,
        look: str | Mapping[str, Any] | None = None,
        *,
        part: str = "all",
        **fields: Any,
    ) -> None:
        """Set the material of something; it replaces the previous choice.

        Args:
            what: ``floor``, ``walls``, ``ceiling``, ``trim`` or ``beams``, one wall such as
                ``wall_2``, or an object's name.
            look: A family or a substance such as ``oak_planks`` or ``wood``, or a mapping.
            part: Which part of an object.
            **fields: ``color``, ``roughness``, ``metallic``, ``file``, ``number`` or ``size``.
        """
        said = {"family": look} if isinstance(look, str) else dict(look or {})
        data = self.as_dict()
        section = data.setdefault("materials", {})
        if what in _SURFACES:
            section[what] = {**said, **fields}
        elif what.startswith("wall_"):
            section.setdefault("accents", {})[what] = {**said, **fields}
        else:
            section.setdefault("overrides", {}).setdefault(what, {})[part] = {**said, **fields}
        self._change(data)

    def remove(self, name: str) -> None:
        """Remove an object from the list, with its light, materials and mass.

        Args:
            name: The object's.

        Raises:
            DescriptionError: Something stands on it.
            InputError: There is no such object.
        """
        data = self.as_dict()
        rows = self._rows(data, "furniture", "objects")
        known = [name for name, _ in self._named()]
        if name not in known:
            raise unknown_name("object", name, known, "the room")
        # The names of the others stay, also where they are numbered.
        for row, own in zip(rows, known, strict=True):
            row["name"] = own
        del rows[known.index(name)]
        for section, key in (
            ("lights", "lamps"),
            ("lights", "screens"),
            ("materials", "overrides"),
            ("materials", "annotations"),
            ("physics", "objects"),
        ):
            ((data.get(section) or {}).get(key) or {}).pop(name, None)
        self._change(data)

    def update(self, **sections: Any) -> None:
        """Set any sections of room.yaml; mappings are merged, everything else is replaced.

        ``room.update(style="scandinavian", physics={}, materials={"resolution": 1024})``

        Args:
            **sections: By key of the description.
        """
        data = self.as_dict()
        self._change(_merged({name_in(sections, key): data[key] for key in data}, sections))

    def save(self, file: AnyPath) -> Path:
        """Write it as a ``room.yaml`` that `ou.load_room` reads as the same room.

        Args:
            file: The file to write; one that is there is replaced. Names of files in the room are
                written as they are: they begin in its folder then.

        Returns:
            The file.

        Raises:
            OutputError: The file cannot be written.
        """
        from openrooms_usd.atomic import making_folder, write_text

        path, text = path_of(file), description.dump_room(self)
        with making_folder(path.parent):
            write_text(path, text)
        return path

    def compose(
        self, out: AnyPath, *, workers: int | None = None, progress: Progress = silent
    ) -> "Scene":
        """Compose it into USD layers: `ou.compose` has further options.

        Args:
            out: The folder for ``scene.usda`` and ``layers/``.
            workers: Threads that a stage may use; all cores by default.
            progress: Called with each step's name and the finished fraction of all steps.

        Returns:
            The composed room.

        Raises:
            InputError: A file that it names cannot be read.
            StageError: The composed stage has errors.
            OutputError: ``out`` cannot be written.
        """
        from openrooms_usd.api.scenes import compose

        return compose(self, out, workers=workers, progress=progress)

    def _open(
        self, kind: Literal["window", "door", "opening"], wall: int | None, said: dict[str, Any]
    ) -> str:
        data = self.as_dict()
        self._rows(data, "layout", "openings").append(given_of(kind=kind, wall=wall, **said))
        self._change(data)
        return description.named_openings(self.layout.openings)[-1][0]  # type: ignore[union-attr]

    def _rows(self, data: dict[str, Any], section: str, key: str) -> list[Any]:
        """The list of a section, in the data."""
        said = data.setdefault(section, {})
        if said.get("from") == "generate":
            raise InputError(
                f"the {section} of this room is generated when it is composed",
                place=section,
                remedy="ou.generate(room_type, seed) lists what is generated, to be changed",
            )
        return said.setdefault(self._list() if section == "furniture" else key, [])  # type: ignore[no-any-return]

    def _named(self) -> list[tuple[str, PlacedObject]]:
        return description.named_objects(getattr(self.furniture, self._list(), None) or ())

    def _list(self) -> str:
        return "further" if getattr(self.furniture, "source", None) == "scan" else "objects"

    def _change(self, data: dict[str, Any]) -> None:
        self._take(description.room_of(data))

    def _take(self, room: description.Room) -> None:
        """Become what a checked room says; where its names of files begin stays."""
        for name in ("__dict__", "__pydantic_fields_set__"):
            object.__setattr__(self, name, getattr(room, name).copy())
        notes = tuple(dict.fromkeys((*self.notes, *room.notes)))
        self._text = replace(room._text, notes=notes)  # of the file, until something is changed


def given_of(**fields: Any) -> dict[str, Any]:
    """The fields that have a value; the others keep their defaults."""
    return {key: value for key, value in fields.items() if value is not None}


def _merged(data: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    found = dict(data)
    for key, value in changes.items():
        old = found.get(key)
        both = isinstance(old, Mapping) and isinstance(value, Mapping)
        found[key] = _merged(old, value) if both else value  # type: ignore[arg-type]
    return found
