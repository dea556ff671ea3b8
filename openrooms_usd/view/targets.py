"""Where what people do with things of a room is written: what every such place can do, and one."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeAlias

from openrooms_usd import names
from openrooms_usd.edits import arranging, assigning, remaking
from openrooms_usd.edits.snapping import PlanPoint
from openrooms_usd.edits.targets import Scope

# What something is made of, as a room.yaml says it.
Said: TypeAlias = str | Mapping[str, Any]


class Target(Protocol):
    """Where what people do is written."""

    @property
    def file(self) -> Path:
        """What is written."""
        ...

    @property
    def scene(self) -> Path:
        """What is shown."""
        ...

    def place(
        self, name: str, spot: PlanPoint, *, size: tuple[float, float, float] | None, snap: bool
    ) -> arranging.Standing:
        """Move, turn or resize an object."""
        ...

    def duplicate(self, name: str) -> arranging.Standing:
        """Put a copy of an object beside it."""
        ...

    def remove(self, name: str) -> None:
        """Take an object away."""
        ...

    def relabel(self, name: str, category: str) -> arranging.Standing:
        """Call an object something else."""
        ...

    def remake(
        self, name: str, style: str, kind: str | None, *, keep_size: bool
    ) -> arranging.Standing:
        """Let the library make an object anew."""
        ...

    def assign(self, path: str, scope: Scope, look: Said) -> assigning.Assigned:
        """Let parts be made of something."""
        ...

    def unassign(self, path: str, scope: Scope) -> assigning.Assigned:
        """Let parts be made of what the steps give them."""
        ...


@dataclass(frozen=True)
class Edits:
    """The edits of a composed room.

    Attributes:
        scene: Its ``scene.usda``.
        base: Where the names of files in looks begin; None for the scene's folder.
    """

    scene: Path
    base: Path | None = None

    @property
    def file(self) -> Path:
        """What is written."""
        return self.scene.parent / names.LAYERS / f"{names.EDITS}.usda"

    def place(
        self, name: str, spot: PlanPoint, *, size: tuple[float, float, float] | None, snap: bool
    ) -> arranging.Standing:
        """See `arranging.place`."""
        return arranging.place(self.scene, name, spot, size=size, snap=snap)

    def duplicate(self, name: str) -> arranging.Standing:
        """See `arranging.duplicate`."""
        return arranging.duplicate(self.scene, name)

    def remove(self, name: str) -> None:
        """See `arranging.remove`."""
        arranging.remove(self.scene, name)

    def relabel(self, name: str, category: str) -> arranging.Standing:
        """See `arranging.relabel`."""
        return arranging.relabel(self.scene, name, category)

    def remake(
        self, name: str, style: str, kind: str | None, *, keep_size: bool
    ) -> arranging.Standing:
        """See `remaking.remake`."""
        return remaking.remake(self.scene, name, style, kind, keep_size=keep_size)

    def assign(self, path: str, scope: Scope, look: Said) -> assigning.Assigned:
        """See `assigning.assign`."""
        return assigning.assign(self.scene, path, scope, assigning.look_of(look), self.base)

    def unassign(self, path: str, scope: Scope) -> assigning.Assigned:
        """See `assigning.unassign`."""
        return assigning.unassign(self.scene, path, scope)
