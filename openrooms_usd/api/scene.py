"""A scene: a composed room or any USD file, with what it holds."""

import os
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from openrooms_usd import names
from openrooms_usd.api.given import AnyPath, path_of
from openrooms_usd.errors import InputError
from openrooms_usd.progress import Progress, silent

if TYPE_CHECKING:
    from pxr import Usd

    from openrooms_usd.composing import ComposeSummary, StepSummary
    from openrooms_usd.description.room import Room
    from openrooms_usd.edits.objects import SceneObject
    from openrooms_usd.edits.orphans import Orphan
    from openrooms_usd.edits.scenefile import ByName, SceneFile
    from openrooms_usd.edits.views import SceneCamera, SceneLight, SceneMaterial


@dataclass(eq=False, repr=False)
class Scene(os.PathLike[str]):
    """A composed room, or any USD file. It stands for its file wherever a path is taken.

    What it holds is read when it is asked for, and again when a file has changed. Any scene can be
    read; objects are changed in composed rooms, as opinions in ``layers/edits.usda``.

    Attributes:
        path: The USD file; of a composed room its ``scene.usda``.
        composed: What composing it did; None where it was only opened.
        description: What it was composed from; None where it was only opened.
    """

    path: Path
    composed: "ComposeSummary | None" = None
    description: "Room | None" = None

    def __fspath__(self) -> str:
        return str(self.path)

    def __repr__(self) -> str:
        states = [row.state for row in self.stages]
        counts = (f"{states.count(state)} steps {state}" for state in dict.fromkeys(states))
        said = [*counts, *([f"{len(self.notes)} notes"] if self.notes else [])]
        return f"Scene({str(self.path)!r}{''.join(f', {text}' for text in said)})"

    @property
    def folder(self) -> Path:
        """Where the file lies."""
        return self.path.parent

    @property
    def edits(self) -> Path:
        """The layer of a composed room for your own edits."""
        return self.folder / names.LAYERS / f"{names.EDITS}.usda"

    @property
    def stages(self) -> "tuple[StepSummary, ...]":
        """What became of each step when it was composed."""
        return self.composed.stages if self.composed else ()

    @property
    def notes(self) -> tuple[str, ...]:
        """What composing approximated or guessed, one sentence each; also of an opened room."""
        if self.composed is None:
            from openrooms_usd.steps.runner import notes_of

            layers = [(self.folder / names.LAYERS / f"{n}.usda", n) for n in names.STEPS]
            kept = [*layers, (self.path, "")] if self.path.name == names.SCENE else []
            return tuple(note for layer, stage in kept for note in notes_of(layer, stage))
        of_stages = (note for row in self.stages for note in row.notes)
        return (*of_stages, *self.composed.notes)

    @property
    def orphans(self) -> "tuple[Orphan, ...]":
        """Opinions of the edits that had no effect when it was composed."""
        return self.composed.orphans if self.composed else ()

    @property
    def objects(self) -> "ByName[SceneObject]":
        """What stands in it, by name or by the path of its prim.

        Of a composed room its furniture, and by their paths alone what `shell` has. Elsewhere an
        object is what the channel ``instance`` takes for one: the nearest labelled prim above a
        surface, else the nearest component, else the surface itself.

        Raises:
            InputError: The file is missing or no readable USD.
        """
        from openrooms_usd.edits.objects import objects_of

        return objects_of(self._file)

    @property
    def shell(self) -> "ByName[SceneObject]":
        """Floor, ceiling, walls, doors, windows and trim of a composed room; else nothing.

        Raises:
            InputError: The file is missing or no readable USD.
        """
        from openrooms_usd.edits.objects import shell_of

        return shell_of(self._file)

    @property
    def cameras(self) -> "ByName[SceneCamera]":
        """Its cameras by name, for pictures as its render settings ask for.

        Raises:
            InputError: The file is missing or no readable USD.
            StageError: A camera's numbers make no picture.
        """
        from openrooms_usd.edits.views import cameras_of

        return cameras_of(self._file)

    @property
    def lights(self) -> "ByName[SceneLight]":
        """Its lights by name: lamps, the surroundings, and what else USD knows.

        Raises:
            InputError: The file is missing or no readable USD.
        """
        from openrooms_usd.edits.views import lights_of

        return lights_of(self._file)

    @property
    def materials(self) -> "ByName[SceneMaterial]":
        """All materials that something in it is made of.

        Raises:
            InputError: The file is missing or no readable USD.
        """
        from openrooms_usd.edits.objects import materials_of

        return materials_of(self._file)

    def add(
        self,
        category: str,
        at: Sequence[float],
        *,
        yaw: float = 0.0,
        name: str | None = None,
        size: tuple[float, float, float] | None = None,
        style: str | None = None,
        file: AnyPath | None = None,
        on: str | None = None,
        relative_to: str | None = None,
        **fields: Any,
    ) -> "SceneObject":
        """Add an object to a composed room.

        Args:
            category: What it is, such as ``chair``; the library makes it.
            at: x, y and, where that does not follow from what carries it, z of the middle of its
                base, metres.
            yaw: Degrees, counter-clockwise from above; at 0 its front looks along -Y.
            name: The name of its prim; by default its category and ``_added``.
            size: Width, depth and height, metres; by default as usual.
            style: One of the category's styles; drawn by default.
            file: An OBJ, GLB, PLY, STL, URDF or USD file to take in place of the library.
            on: What carries it: ``floor``, ``ceiling``, ``wall`` or another object's name; by
                default as its category does.
            relative_to: Another object's name: ``at`` and ``yaw`` are in its frame.
            **fields: Further fields of an object, such as ``tilt``, ``up`` or ``unit``.

        Returns:
            The object. Lamps shine and bodies collide once the room is composed again.

        Raises:
            DescriptionError: There is no such category or field, or a value is out of range.
            InputError: It is not a composed room, the file cannot be read, or a name is unknown.
            OutputError: The edits or the model cannot be written.
        """
        from openrooms_usd.edits.objects import add

        asked = {"name": name, "size": size, "style": style, "on": on, "relative_to": relative_to}
        said = {"category": category, "at": at, "yaw": yaw, **fields}
        said |= {key: value for key, value in asked.items() if value is not None}
        if file is not None:
            said |= {"from": "file", "file": str(path_of(file, "a model file"))}
        return add(self._file, said, Path())

    def stage(self) -> "Usd.Stage":
        """Open it with USD.

        Raises:
            InputError: It is missing or no readable USD.
        """
        from openrooms_usd.usd.files.diagnostics import quiet
        from openrooms_usd.usd.files.layers import open_stage

        with quiet():
            return open_stage(self.path)

    def editing(self) -> "AbstractContextManager[Usd.Stage]":
        """Open it so that changes are written to ``layers/edits.usda``.

        ``with scene.editing() as stage:`` saves the layer at the end of the block, and drops what
        was authored where something fails. Objects that are changed in the block are saved with
        it, which is faster for many. Compose the room again for its other layers to follow.

        Raises:
            InputError: It is not a composed room.
            StageError: With what was authored the room would not compose.
        """
        from openrooms_usd.edits.editing import editing

        return editing(self.path)

    def recompose(
        self, *, workers: int | None = None, progress: Progress = silent
    ) -> "ComposeSummary":
        """Compose it again from the same description, so that everything follows the edits.

        Args:
            workers: Threads that a stage may use; all cores by default.
            progress: Called with each step's name and the finished fraction of all steps.

        Returns:
            What became of each step; `stages`, `notes` and `orphans` say the same.

        Raises:
            InputError: It was opened, so that its description is not known: use ``ou.compose``.
            OrusdError: As `compose`.
        """
        from openrooms_usd.composing import compose_room
        from openrooms_usd.usd.files.diagnostics import quiet

        if self.description is None:
            raise InputError(
                "the description of this scene is not known, because it was not composed here",
                place=self.path,
                remedy="ou.compose(room, folder) composes it again",
            )
        with quiet():
            self.composed = compose_room(
                self.description, self.folder, workers=workers, progress=progress
            )
        return self.composed

    @cached_property
    def _file(self) -> "SceneFile":
        from openrooms_usd.edits.scenefile import SceneFile

        return SceneFile(self.path)
