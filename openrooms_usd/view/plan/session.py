"""The page of a plan: its state and its commands. It has no rules of its own."""

import base64
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Final, Generic, TypeVar

import numpy as np

from openrooms_usd.description.layout import named_openings, named_partitions
from openrooms_usd.description.model import Model, Switch, Whole
from openrooms_usd.errors import InputError
from openrooms_usd.importing import ROOM, import_capture
from openrooms_usd.view.app import App, Command, Nothing
from openrooms_usd.view.plan.document import Document
from openrooms_usd.view.plan.drawing import Drawing
from openrooms_usd.view.plan.fittings import hole_in
from openrooms_usd.view.plan.operations import OPERATIONS, Operation, SnapRequest
from openrooms_usd.view.plan.pictures import Picture, from_above, heights, of_wall, view_box

_DESCRIPTIONS: Final = (".yaml", ".yml")
Kept = TypeVar("Kept")
POINTS = "points.png"


class Answer(Model):
    """Yes or no."""

    take: Switch


class WallChoice(Model):
    """A wall or a partition."""

    wall: Whole | None = None
    partition: str | None = None


class Taken(Model):
    """A room that was found."""

    room: str


class Session:
    """A plan that is being drawn.

    Args:
        file: Its ``room.yaml``.

    Raises:
        OrusdError: It, or its capture, cannot be read.
    """

    def __init__(self, file: Path) -> None:
        self.document = Document(file)
        self.history = History(self.document.saved)
        self.draft = self.document.kept()
        under = self.document.under
        plans = [self.history.now, *under.found.values()]
        corners = np.vstack([plan.polygon for plan in plans])
        self.box = view_box(corners, under.points)

    def app(self) -> App:
        """The page."""
        commands: dict[str, Command[Any]] = {
            name: Command(operation.model, partial(self._operate, operation))
            for name, operation in OPERATIONS.items()
        }
        steps: Mapping[str, Callable[[], None]] = {
            "undo": self.history.undo,
            "redo": self.history.redo,
            "save": lambda: self.document.save(self.history.now),
            "reload": self._reload,
        }
        for name, step in steps.items():
            commands[name] = Command(Nothing, partial(self._step, step))
        commands["draft"] = Command(Answer, self._answer)
        commands["take"] = Command(Taken, self._take)
        commands["elevation"] = Command(WallChoice, self._elevation)
        return App(
            "plan",
            f"{self.document.file.parent.resolve().name}: plan",
            self.state,
            {POINTS: self._points},
            commands,
            (self.document.file,),
        )

    def state(self) -> dict[str, Any]:
        """All that a page needs when it opens."""
        under = self.document.under
        return {
            **self.told(self.history.now),
            "box": self.box,
            "look": view_box(self.history.now.polygon, np.empty((0, 3))),
            "picture": POINTS if len(under.points) else None,
            "heights": heights(under.points),
            "found": {name: _outline(plan) for name, plan in under.found.items()},
            "notes": list(under.notes),
            "draft": self.draft is not None,
        }

    def told(self, plan: Drawing) -> dict[str, Any]:
        """What a page shows of a plan."""
        refusal = self.document.refusal(plan)
        return {
            "file": self.document.file.name,
            **_outline(plan),
            "height": plan.height,
            "area": plan.area,
            "refusal": None if refusal is None else refusal.as_dict(),
            "renumbered": self.document.renumbers(plan),
            "unsaved": not self.document.has(plan),
            "undo": self.history.done,
            "redo": self.history.undone,
        }

    def _operate(self, operation: Operation, given: SnapRequest) -> dict[str, Any]:
        plan = operation.run(self.history.now, given)
        if not given.final:
            return self.told(plan)
        return self._record(plan)

    def _record(self, plan: Drawing) -> dict[str, Any]:
        if plan != self.history.now:
            self.history.do(plan)
        self.document.keep(plan)
        return self.told(plan)

    def _step(self, step: Callable[[], None], _: Nothing) -> dict[str, Any]:
        step()
        self.document.keep(self.history.now)
        return self.told(self.history.now)

    def _reload(self) -> None:
        """What another program wrote is one more step, which can be undone."""
        if (plan := self.document.changed()) is not None:
            self.history.do(plan)

    def _answer(self, given: Answer) -> dict[str, Any]:
        plan, self.draft = self.draft, None
        if given.take and plan is not None:
            return self._record(plan)
        self.document.forget()
        return self.told(self.history.now)

    def _take(self, given: Taken) -> dict[str, Any]:
        found = self.document.under.found
        if given.room not in found:
            known = ", ".join(found) or "none"
            raise InputError(f"no room {given.room} was found", remedy=f"found are: {known}")
        return self._record(replace(found[given.room], thickness=self.history.now.thickness))

    def _points(self) -> bytes:
        under = self.document.under
        return from_above(under.points, self.box, self.history.now.height).png

    def _elevation(self, given: WallChoice) -> dict[str, Any]:
        plan, under = self.history.now, self.document.under
        wall = plan.seen(given.wall, given.partition)
        picture: Picture | None = None
        if len(under.points):
            picture = of_wall(under.points, under.colors, wall, plan.height)
        png = None if picture is None else base64.b64encode(picture.png).decode("ascii")
        return {"wall": wall.name, "length": wall.length, "height": plan.height, "png": png}


def _outline(plan: Drawing) -> dict[str, Any]:
    """Corners, walls, openings and partitions as lines in the plan, and on their elevations."""
    names = [name for name, _ in named_openings(plan.openings)]
    openings = []
    for name, one in zip(names, plan.openings, strict=True):
        start, end = plan.line(one)
        along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-9)
        half, at = 0.5 * (one.width or 0.0), one.at or 0.0
        hole = hole_in(plan, one)
        openings.append(
            {
                "name": name,
                "kind": one.kind,
                "wall": one.wall,
                "partition": one.partition,
                "line": [(start + along * (at + way * half)).tolist() for way in (-1.0, 1.0)],
                "rectangle": [hole.left, hole.right, hole.bottom, hole.top],
            }
        )
    return {
        "corners": [list(corner) for corner in plan.corners],
        "openings": openings,
        "partitions": [
            {"name": name, "line": [list(end) for end in one.line], "thickness": one.thickness}
            for name, one in named_partitions(plan.partitions)
        ],
    }


class History(Generic[Kept]):
    """States in the order in which they came about, and which of them is now.

    Args:
        first: The state at the beginning.
    """

    def __init__(self, first: Kept) -> None:
        self._states = [first]
        self._now = 0

    @property
    def now(self) -> Kept:
        """The present state."""
        return self._states[self._now]

    @property
    def done(self) -> int:
        """How many steps can be taken back."""
        return self._now

    @property
    def undone(self) -> int:
        """How many steps that were taken back can be done again."""
        return len(self._states) - 1 - self._now

    def do(self, state: Kept) -> None:
        """Go on to a state; what was taken back before is forgotten."""
        self._states = [*self._states[: self._now + 1], state]
        self._now += 1

    def undo(self) -> None:
        """Take the last step back, if there is one."""
        self._now = max(0, self._now - 1)

    def redo(self) -> None:
        """Do the step again that was taken back last, if there is one."""
        self._now = min(len(self._states) - 1, self._now + 1)


def room_file(source: Path, out: Path | None = None, importer: str = "scan") -> Path:
    """The description to draw in.

    Args:
        source: A ``room.yaml``, a folder with one, or a scan.
        out: The folder that a scan is imported to.
        importer: What reads a scan.

    Raises:
        InputError: The scan cannot be read, or there is no folder to import it to.
        OutputError: There is a room in that folder already.
    """
    if (source / ROOM).is_file():
        source = source / ROOM
    if source.suffix in _DESCRIPTIONS:
        if out is not None:
            raise InputError(
                "a room.yaml is edited in place",
                place=source,
                remedy="omit --out, or copy its folder first",
            )
        return source
    if out is None:
        raise InputError(
            "a scan needs a folder for its room.yaml", place=source, remedy="give one: `--out DIR`"
        )
    return import_capture(importer, source, out).file
