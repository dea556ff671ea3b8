"""Scan2CAD: CAD models that were aligned to a ScanNet scan become a Capture."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.capture import NO_OPTIONS, Capture, CapturedModel, Packed
from openrooms_usd.errors import InputError
from orusd_scans.frames import as_text, in_world
from orusd_scans.plan import DrawnPlan, floor_in, frame_along, openings_in, read_plan
from orusd_scans.records.jsonfile import Node
from orusd_scans.scannet.annotations import MESH, AlignedCad, aligned_cads, entry_of, identifier
from orusd_scans.scannet.frames import read_scannet_frames
from orusd_scans.worldframe import WorldFrame

Array = NDArray[np.float64]

# Objects stand on the floor if their bases are this near to the lowest one's, metres.
_STANDING_M: Final = 0.15
_POLYGON: Final = (
    "Scan2CAD knows no floor: draw it in the frame of the scan, and give it by --polygon FILE "
    '(JSON: {"floor": [[x, y], ...], "height": 2.5}, or CSV with the columns x and y)'
)


class Scan2CadImporter:
    """Reads ``full_annotations.json`` of Scan2CAD."""

    options: Mapping[str, str] = {
        "scan": "Which scan, such as scene0470_00; needed where the file holds several.",
        "models": "The folder of ShapeNetCore.v2; boxes take the place of CADs that it lacks.",
        "frames": "Poses of the photographs: ScanNet's exported folder, a .sens file or JSON.",
        "polygon": "The floor in the frame of the scan, in metres: JSON or CSV.",
        "official_centre": "yes: take the CADs' centres off, as the official scorer (default no).",
    }
    paths = frozenset({"models", "frames", "polygon"})

    def read(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Capture:
        """Read the annotation of one scan.

        Args:
            source: The JSON file.
            options: See `options`.

        Raises:
            InputError: It is missing, is no such file, or holds nonsense; names the place.
        """
        entry, notes = entry_of(source, options.get("scan")), list[str]()
        folder = Path(options["models"]) if "models" in options else None
        aligned = aligned_cads(entry, official(options, source))
        plan = read_plan(Path(options["polygon"]), "Z") if "polygon" in options else None
        frame = _frame(plan, aligned, notes)
        floor = floor_in(frame, plan, "Z") if plan else None
        models = _models(aligned, frame, folder, notes)
        frames = read_scannet_frames(Path(options["frames"]), notes) if "frames" in options else ()
        return Capture(
            source=source.name,
            source_from_world=frame.source_from_world(),
            floor=floor,
            height=plan.height if plan else None,
            openings=openings_in(frame, plan.openings, floor) if plan and floor is not None else (),
            models=models,
            frames=in_world(frames, frame, notes),
            notes=tuple(notes),
            remedy=_POLYGON,
        )

    def pack(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Packed:
        """The scan's own annotation, the CADs that it uses, its polygon and its cameras."""
        entry = entry_of(source, options.get("scan"))
        scan = identifier(entry.need("id_scan"))
        contents: dict[str, bytes | Path] = {f"{scan}.json": _annotation(entry)}
        kept = {name: options[name] for name in ("official_centre",) if name in options}
        if "models" in options:
            contents |= _packed_models(Path(options["models"]), aligned_cads(entry))
            kept["models"] = "models"
        if "polygon" in options:
            kept["polygon"] = f"floor{Path(options['polygon']).suffix.lower()}"
            contents[kept["polygon"]] = Path(options["polygon"])
        if "frames" in options:
            kept["frames"] = "frames.json"
            found = read_scannet_frames(Path(options["frames"]), [])
            contents["frames.json"] = as_text(found)
        return Packed(f"{scan}.json", contents, kept)


def read_aligned(
    source: Path,
    scan: str,
    frame: WorldFrame,
    folder: Path | None,
    official_centre: bool,
    notes: list[str],
) -> tuple[CapturedModel, ...]:
    """The CADs of one scan, in the world.

    Args:
        source: The annotations.
        scan: Which scan.
        frame: Transform from the scan to the world.
        folder: The folder of ShapeNetCore.v2.
        official_centre: Whether the CADs' centres are subtracted.
        notes: Receives a sentence about CADs that are not there.

    Raises:
        InputError: The annotations cannot be read, hold nonsense, or lack the scan.
    """
    return _models(aligned_cads(entry_of(source, scan), official_centre), frame, folder, notes)


def official(options: Mapping[str, str], source: Path) -> bool:
    """Whether the CADs' centres are subtracted, as ``EvaluateBenchmark.py`` of Scan2CAD does.

    The annotation's own transforms fit the scan; the scorer's are offset by the scaled centre, some
    centimetres.

    Raises:
        InputError: The option is neither yes nor no.
    """
    asked = options.get("official_centre", "no").lower()
    if asked not in ("yes", "no", "true", "false"):
        raise InputError(
            f"official_centre is yes or no, not {asked[:20]!r}", place=source, remedy="give yes"
        )
    return asked in ("yes", "true")


def _models(
    aligned: list["AlignedCad"], frame: WorldFrame, folder: Path | None, notes: list[str]
) -> tuple[CapturedModel, ...]:
    models = tuple(one.model(frame, folder) for one in aligned)
    if missing := sorted({m.id.partition("_")[2] for m in models if m.file is None}):
        notes.append(
            f"{len(missing)} CAD models are not there (such as {missing[0]}): the library "
            "fills their boxes"
        )
    return models


def _annotation(entry: Node) -> bytes:
    try:
        return _json([entry.value])
    except ValueError as error:
        # Also where nobody reads it: JSON has no infinities.
        raise entry.error("a number is out of range", "mend the annotation") from error


def _json(data: Any) -> bytes:
    return (json.dumps(data, indent=1, allow_nan=False) + "\n").encode()


def _frame(plan: DrawnPlan | None, aligned: list[AlignedCad], notes: list[str]) -> WorldFrame:
    """The world: along the polygon's walls, or along the scan's own axes without one."""
    level = plan.level if plan else None
    if level is None:
        bases = sorted(one.base() for one in aligned)
        standing = [base for base in bases if base - bases[0] < _STANDING_M]
        level = float(np.median(standing)) if standing else 0.0
        notes.append(f"the floor's level is not stated: the objects stand at {level:.3f} m")
    if plan is None:
        return WorldFrame(np.eye(3), np.array([0.0, 0.0, level]))
    return frame_along(plan, level, "Z")


def _packed_models(folder: Path, aligned: list[AlignedCad]) -> dict[str, bytes | Path]:
    """The files of every CAD that is there: its mesh, its materials and their pictures."""
    found: dict[str, bytes | Path] = {}
    for catid, cad in sorted({(one.catid, one.cad) for one in aligned}):
        mesh = folder / MESH.format(catid=catid, id=cad)
        if mesh.is_file():
            for path in (mesh, *_beside(mesh)):
                found[f"models/{path.relative_to(folder).as_posix()}"] = path
    return found


def _beside(mesh: Path) -> Iterator[Path]:
    """The material file of a CAD, and the pictures of its folder."""
    material = mesh.with_suffix(".mtl")
    pictures = sorted((mesh.parent.parent / "images").glob("*"))
    yield from (path for path in (material, *pictures) if path.is_file())
