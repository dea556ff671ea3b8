"""The simulated scans of the benchmark: which rooms, and how each scan lies."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.scan.rooms import generated
from benchmarks.scan.scanner import Scan, Scanner, simulate, typical
from benchmarks.scan.truth import Cad, RoughHint, Truth, stretched
from openrooms_usd.draws import generator
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

# The package's route from a cloud to a room, step by step, with the time of each.


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


# What methods are tuned on, and what is run once at the end; no seed is in both.
DEVELOPMENT_SEEDS: Final = (1,)
TEST_SEEDS: Final = (9003,)
DEVELOPMENT_TYPES: Final = (
    "apartment",
    "bathroom",
    "bedroom",
    "classroom",
    "dining_room",
    "garage",
    "hallway",
    "hotel",
    "kitchen",
    "laundry_room",
    "library",
    "living_room",
    "lobby",
    "office",
    "storage",
)
TEST_TYPES: Final = (*DEVELOPMENT_TYPES, "basement", "conference_room", "game_room", "lounge")
QUICK_TYPES: Final = ("bathroom",)

# Scans lie anywhere, and lean by up to so many degrees.
LEAN: Final = 5.0
PLACE: Final = 5.0


@dataclass(eq=False)
class Case:
    """One simulated scan, what is true of it and what the package finds in it."""

    name: str
    scan: Scan
    scanner: Scanner

    @cached_property
    def ours(self) -> Reconstruction:
        """What the package finds."""
        return Reconstruction(self.scan.cloud)

    @property
    def level_truth(self) -> Truth:
        """The truth in the frame that the package found level."""
        return self.scan.truth.moved(self.ours.level.level_from_scan)


def rooms_of(split: str, quick: bool) -> Sequence[tuple[str, int]]:
    """Types and seeds of the rooms of ``development`` or ``test``."""
    if quick:
        return [(kind, DEVELOPMENT_SEEDS[0]) for kind in QUICK_TYPES]
    kinds, seeds = {
        "development": (DEVELOPMENT_TYPES, DEVELOPMENT_SEEDS),
        "test": (TEST_TYPES, TEST_SEEDS),
    }[split]
    return [(kind, seed) for kind in kinds for seed in seeds]


def cases(rooms: Sequence[tuple[str, int]], folder: Path, quick: bool) -> Iterator[Case]:
    """Generate, compose and scan rooms, one after the other."""
    for kind, seed in rooms:
        stage = generated(kind, seed, folder)
        number = int(generator(seed, "scan", kind).integers(2**31))
        scanner = Scanner(frames=30, reduce=6, voxel=0.02) if quick else typical(number)
        scan = simulate(stage, number, scanner)
        world = Scan(scan.cloud, stretched(scan.truth, number))
        yield Case(f"{kind}_{seed}", world.moved(_lying(number)), scanner)


def _lying(seed: int) -> np.ndarray:
    """(4, 4) how a scan lies."""
    random = generator(seed, "lying")
    matrix = np.eye(4)
    lean = random.uniform(0, LEAN) * np.array([*_on_circle(random), 0.0])
    turn = Rotation.from_euler("z", random.uniform(0, 360), degrees=True)
    matrix[:3, :3] = (Rotation.from_rotvec(np.radians(lean)) * turn).as_matrix()
    matrix[:3, 3] = random.uniform(-PLACE, PLACE, 3)
    return matrix


def _on_circle(random: np.random.Generator) -> tuple[float, float]:
    angle = random.uniform(0, 2 * np.pi)
    return float(np.cos(angle)), float(np.sin(angle))
