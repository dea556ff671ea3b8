"""The captures of a folder, and how each of them is run."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal, NamedTuple

from benchmarks.real.truth import Truth, truth_of

# What is done to a scan before it is imported.
Change = Literal["", "strip", "on its side", "millimetres"]

# Every upright scan of points is also run like this: it may not become a wrong room in silence.
DERIVED: Final[tuple[Change, ...]] = ("on its side", "millimetres")
_POINTS: Final = (".ply", ".xyz", ".pcd")


@dataclass(frozen=True)
class Run:
    """One way to import a capture.

    Attributes:
        name: For people.
        words: What follows ``orusd import``; paths are absolute.
        labels: Whether the scan says what its points are.
        partial: Whether the room is told that the scan shows a part of it.
        change: What is done to the scan first; it is the second word.
        derived: The run is about axis and unit alone.
    """

    name: str
    words: tuple[str, ...]
    labels: bool = False
    partial: bool = False
    change: Change = ""
    derived: bool = False


@dataclass(frozen=True)
class Capture:
    """A capture with what is true of it."""

    name: str
    truth: Truth
    runs: tuple[Run, ...]
    substitutes: Mapping[str, Sequence[str] | None]


def captures_of(folder: Path, only: Sequence[str] = (), derived: bool = True) -> Iterator[Capture]:
    """The captures of a folder.

    Args:
        folder: Holds ``captures.json``, ``data`` and ``truth``.
        only: Their names; all without.
        derived: Also run each scan on its side and in millimetres.
    """
    listed = json.loads((folder / "captures.json").read_text(encoding="utf-8"))
    table = json.loads((folder / "truth" / "substitutes.json").read_text(encoding="utf-8"))["table"]
    for name, entry in listed.items():
        path = folder / "truth" / f"{name}.json"
        if (only and name not in only) or not path.exists():
            continue
        truth = truth_of(path)
        runs = [_run(folder, run, spec) for run, spec in entry["runs"].items()]
        more = _derived(runs, truth) if derived else []
        yield Capture(name, truth, (*runs, *more), table)


def _run(folder: Path, name: str, spec: Mapping[str, Any]) -> Run:
    words = [str((folder / w).resolve()) if w.startswith("data/") else w for w in spec["import"]]
    change: Change = "strip" if spec.get("strip") else ""
    return Run(
        name, tuple(words), bool(spec.get("labels")), bool(spec.get("partial")), change=change
    )


def _derived(runs: Sequence[Run], truth: Truth) -> list[Run]:
    """The first run of an upright, whole scan of points, changed."""
    first = runs[0]
    upright = truth.kind == "scan" and truth.up_axis == "z" and not truth.axis_only
    plain = first.words[0] == "scan" and Path(first.words[1]).suffix.lower() in _POINTS
    if not (upright and plain and truth.unit == 1.0):
        return []
    return [Run(change, first.words[:2], change=change, derived=True) for change in DERIVED]


# Where public captures come from; none is part of the project, for their licences' sake.


class Source(NamedTuple):
    """Files of a public repository, at one of its commits."""

    capture: str
    repository: str
    commit: str
    path: str
    terms: str


_S3DIS: Final = (
    "T0M0F/pointnet",
    "05ae2f8b5bcdb8fd9e8e4104540f494b87d18df6",
    "sem_seg/log6/dump/Area_6_{room}_gt.obj, _gt.txt, _pred.txt",
    "S3DIS: research only",
)
_ROOMS: Final = (
    "copyRoom_1",
    "hallway_3",
    "hallway_5",
    "office_10",
    "office_17",
    "office_26",
    "office_36",
    "pantry_1",
)

SOURCES: Final = (
    *(
        Source(f"s3dis_6_{room}", _S3DIS[0], _S3DIS[1], _S3DIS[2].format(room=room), _S3DIS[3])
        for room in _ROOMS
    ),
    Source(
        "scannet_0470_00",
        "skanti/Scan2CAD",
        "99c8b9565617b43a9ad03d0dbeb9141805b00618",
        "Assets/scannet-sample/scene0470_00",
        "ScanNet: research only",
    ),
    Source(
        "polycam_room",
        "tamatebox/audio-infra",
        "fdf7cbf79e85209b9612ebf68ebc4a5cdcbe2c8b",
        "room/scans/room.glb",
        "none stated",
    ),
    Source(
        "scaniverse_office_low",
        "nikitash98/digital_memories",
        "61a8bbb64e4fca35337c26a5e3f8f260a750a73c",
        "office_low.ply",
        "none stated",
    ),
    Source(
        "planefinder_office",
        "zwpdbh/PlaneFinder",
        "f46581126d3307ead47e2f38017673a0eaf0dcd5",
        "data/office.ply",
        "none stated",
    ),
    Source(
        "rotating_lidar_office",
        "senegalo/lidar-room-scanner",
        "428964a8d7e5f807d4e4746646c75c3203a0ce2d",
        "results/combined_cloud_000000.xyz",
        "none stated",
    ),
    Source(
        "roomplan_unity",
        "NamanBhoj/Room-Plan-Update-TELUS",
        "9823282bbda05707339471db2282dc9c54b526e1",
        "Assets/RoomPlanUnityKit/Samples/RPU/Resources/EditorAR/scan.{json,usdz}",
        "none stated",
    ),
    Source(
        "roomplan_libroom",
        "SekharReddy07/AR_PROJECT",
        "6910e14e8d9ba2eadba3704fea977fcb2e58af62",
        "Libroom_output.zip",
        "none stated",
    ),
)
