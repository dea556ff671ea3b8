"""The simulated scans of the benchmark: which rooms, and how each scan lies."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.scan.hints import stretched
from benchmarks.scan.methods import Reconstruction
from benchmarks.scan.rooms import generated
from benchmarks.scan.scanner import Scan, Scanner, simulate, typical
from benchmarks.scan.truth import Truth
from openrooms_usd.draws import generator

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
