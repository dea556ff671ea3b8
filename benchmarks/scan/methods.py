"""The package's route from a cloud to a room, step by step, with the time of each."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from benchmarks.scan.hints import RoughHint
from benchmarks.scan.truth import Cad, Truth
from openrooms_usd.scan.models.cad import CadModel
from openrooms_usd.scan.openings.detection import find_openings
from openrooms_usd.scan.placement.correcting import Placement, place
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.thinning import clean, thin
from openrooms_usd.scan.reconstruction import VOXEL_M
from openrooms_usd.scan.registration.alignment import Alignment, Hint, align
from openrooms_usd.scan.results import FoundObject, FoundRoom
from openrooms_usd.scan.rooms.layout import LayoutRoom, find_layout
from openrooms_usd.scan.rooms.levelling import Level, level


@dataclass(eq=False)
class Reconstruction:
    """What the package finds in a cloud; each step runs when it is asked for.

    Attributes:
        scan: Metres, anywhere; what is not finite and what is double is taken away first.
        seconds: What each step took.
    """

    scan: Cloud
    seconds: dict[str, float] = field(default_factory=dict)

    @cached_property
    def cloud(self) -> Cloud:
        """The finite points, each once."""
        return self._timed("clean", lambda: clean(self.scan)[0])

    @cached_property
    def thinned(self) -> Cloud:
        """Means over the voxels that rooms are found on."""
        cloud = self.cloud
        return self._timed("thin", lambda: thin(cloud, VOXEL_M))

    @cached_property
    def level(self) -> Level:
        """How it stands."""
        cloud = self.thinned
        return self._timed("level", lambda: level(cloud))

    @cached_property
    def still(self) -> Cloud:
        """The cloud in the level frame."""
        return self.cloud.moved(self.level.level_from_scan)

    @cached_property
    def rooms(self) -> tuple[FoundRoom, ...]:
        """Rooms with openings in the level frame."""
        flat = self.thinned.moved(self.level.level_from_scan)
        found = self._timed("layout", lambda: find_layout(flat, self.level))
        return self._timed("openings", lambda: tuple(_with_openings(r, flat) for r in found))

    @property
    def scan_rooms(self) -> tuple[FoundRoom, ...]:
        """The rooms in the scan's own frame."""
        return Truth(self.rooms, (), {}).moved(self.level.scan_from_level).rooms

    def aligned(self, hints: Sequence[RoughHint], cads: dict[str, Cad]) -> Alignment:
        """Objects in the level frame."""
        models = [model_of(cad) for cad in cads.values()]
        given = [Hint(h.instance, h.category, h.cad, h.pose, h.box) for h in hints]
        still, rooms = self.still, self.rooms
        return self._timed("alignment", lambda: align(still, given, models, rooms))

    def placed(self, objects: Sequence[FoundObject], cads: dict[str, Cad]) -> Placement:
        """Objects where they can be."""
        models = {name: model_of(cad) for name, cad in cads.items()}
        rooms = self.rooms
        return self._timed("placement", lambda: place(objects, models, rooms))

    def _timed(self, step: str, work: Callable[[], Any]) -> Any:
        began = time.perf_counter()
        done = work()
        self.seconds[step] = time.perf_counter() - began
        return done


def _with_openings(room: LayoutRoom, cloud: Cloud) -> FoundRoom:
    corners = np.column_stack([room.corners, np.zeros(len(room.corners))])
    holes = find_openings(cloud, room.corners, room.ceiling)
    up = np.array([0.0, 0.0, 1.0])
    return FoundRoom(up, np.zeros(3), corners, tuple(room.guessed), room.ceiling, holes)


def model_of(cad: Cad) -> CadModel:
    """A model as the package takes it."""
    faces = cad.faces.astype(np.int32)
    return CadModel(cad.id, cad.category, cad.vertices, faces, cad.symmetry, "Z")
