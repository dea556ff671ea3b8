"""Scan2CAD: CAD models that were aligned to a ScanNet scan become a Capture.

Each scan of ``full_annotations.json`` has a transform from the scan to the world of the annotation
(Y up), and each of its models one from the CAD to that world. A CAD's points are in the scan at
inv(M_scan) M_cad. Both are T R S, with quaternions w, x, y, z. (Avetisyan et al., "Scan2CAD:
Learning CAD Model Alignment in RGB-D Scans", CVPR 2019.)
"""

import json
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.capture import NO_OPTIONS, Capture, CapturedModel, Packed
from openrooms_usd.errors import InputError
from openrooms_usd.furniture.registry import records
from orusd_scans.frames import as_text, in_world
from orusd_scans.plan import DrawnPlan, floor_in, frame_along, openings_in, read_plan
from orusd_scans.records import Node, read_json, text
from orusd_scans.scannet.frames import read_scannet_frames
from orusd_scans.worldframe import MAX_COORDINATE_M, WorldFrame

# Objects stand on the floor if their bases are this near to the lowest one's, metres.
_STANDING_M: Final = 0.15
_POLYGON: Final = (
    "Scan2CAD has no floor: draw it in the frame of the scan, and give it by --polygon FILE "
    '(JSON: {"floor": [[x, y], ...], "height": 2.5}, or CSV with the columns x and y)'
)
Symmetry = Literal["none", "2", "4", "inf"]
_MAX_SCALE: Final = 1e4
_UNIT_QUATERNION_TOLERANCE: Final = 1e-2
# Axes of an aligned CAD may be off right angles by what rounding does.
_RIGHT_ANGLE_TOLERANCE: Final = 1e-3
_SYMMETRIES: Final[dict[str, Symmetry]] = {
    "__SYM_NONE": "none",
    "__SYM_ROTATE_UP_2": "2",
    "__SYM_ROTATE_UP_4": "4",
    "__SYM_ROTATE_UP_INF": "inf",
}
# Where a CAD lies below the folder of ShapeNetCore.v2.
MESH: Final = "{catid}/{id}/models/model_normalized.obj"
# What ShapeNetCore has besides our categories. WordNet 3.0 offsets of noun synsets, as ShapeNetCore
# and Scan2CAD name their folders.
_OTHERS: Final = {
    "02691156": "airplane",
    "02942699": "camera",
    "02958343": "car",
    "03261776": "earphone",
    "03513137": "helmet",
    "03624134": "knife",
    "03710193": "mailbox",
    "03759954": "microphone",
    "03797390": "mug",
    "04099429": "rocket",
    "04225987": "skateboard",
    "04460130": "tower",
    "04468005": "train",
    "04530566": "watercraft",
}
UNKNOWN: Final = "object"


def entry_of(source: Path, scan: str | None) -> Node:
    """The annotation of a scan.

    Args:
        source: The file.
        scan: Which scan; None where the file holds one.

    Raises:
        InputError: It is not such a file, or lacks the scan.
    """
    root = read_json(source, "annotations")
    entries = Node({"": root.value}, source).items("") if isinstance(root.value, list) else []
    if not entries or not all(isinstance(e.value, dict) and "id_scan" in e.value for e in entries):
        raise root.error(
            "this is JSON, but not a Scan2CAD annotation: a list of scans with id_scan is expected",
            "give the full_annotations.json of Scan2CAD",
        )
    if scan is None and len(entries) == 1:
        return Node(entries[0].value, source, "[0]")
    ids = [str(entry.value["id_scan"]) for entry in entries]
    if scan in ids:
        return Node(entries[ids.index(scan)].value, source, f"[{ids.index(scan)}]")
    near = ", ".join(get_close_matches(scan or "", ids, 3, 0.5) or ids[:3])
    raise InputError(
        f"no scan is named {scan!r}" if scan else f"the file holds {len(ids)} scans",
        place=source,
        remedy=f"give --scan ID, such as: {near}",
    )


@dataclass(frozen=True, eq=False)
class AlignedCad:
    """A CAD in the frame of the scan."""

    id: str
    catid: str
    cad: str
    scan_from_model: Array
    half: Array
    center: Array
    symmetry: Symmetry

    def model(self, frame: WorldFrame, folder: Path | None) -> CapturedModel:
        """The same in the world, with its file where that exists."""
        file = folder / MESH.format(catid=self.catid, id=self.cad) if folder else None
        return CapturedModel(
            id=self.id,
            label=categories().get(self.catid, UNKNOWN),
            file=file if file is not None and file.is_file() else None,
            world_from_model=frame.matrix(self.scan_from_model),
            half=self.half,
            center=self.center,
            symmetry=self.symmetry,
            up="Y",
            front="+Y",
        )

    def without_centre(self) -> "AlignedCad":
        """The same, with the CAD centred in its own frame first."""
        moved = self.scan_from_model.copy()
        moved[:3, 3] -= moved[:3, :3] @ self.center
        return replace(self, scan_from_model=moved)

    def base(self) -> float:
        """Height of the lowest corner of its box in the scan."""
        reach = np.abs(self.scan_from_model[2, :3]) @ self.half
        middle = self.scan_from_model[2] @ [*self.center, 1.0]
        return float(middle - reach)


def aligned_cads(entry: Node, official_centre: bool = False) -> list[AlignedCad]:
    """The CADs of an annotation, in the frame of the scan.

    Args:
        entry: The annotation of one scan.
        official_centre: Whether the CADs' centres are subtracted.

    Raises:
        InputError: It lacks what is needed, or holds nonsense.
    """
    annotation_from_scan = _trs(entry.need("trs"))
    before: Counter[str] = Counter()
    nodes = entry.items("aligned_models")
    found = [_one(node, before, annotation_from_scan) for node in nodes]
    return [one.without_centre() for one in found] if official_centre else found


def _one(node: Node, before: Counter[str], annotation_from_scan: Array) -> AlignedCad:
    cad, catid = (identifier(node.need(key)) for key in ("id_cad", "catid_cad"))
    M: Array = np.asarray(np.linalg.solve(annotation_from_scan, _trs(node.need("trs"))))
    axes = M[:3, :3] / np.linalg.norm(M[:3, :3], axis=0)
    if np.abs(axes.T @ axes - np.eye(3)).max() > _RIGHT_ANGLE_TOLERANCE:
        raise node.error(
            "the scan's scale shears this model", "the scale in the scan's own trs must be uniform"
        )
    half = node.need("bbox").numbers(3, _MAX_SCALE)
    if (half <= 0.0).any():
        raise node.need("bbox").error("a half extent is not positive", "correct the annotation")
    symmetry = node.get("sym")
    # Instances have no identifiers: only those of one CAD are told apart by their order.
    before[cad] += 1
    return AlignedCad(
        id=f"{before[cad] - 1}_{cad}",
        catid=catid,
        cad=cad,
        scan_from_model=M,
        half=half,
        center=node.need("center").numbers(3, _MAX_SCALE),
        symmetry=_SYMMETRIES.get(text(symmetry), "none") if symmetry else "none",
    )


def identifier(node: Node) -> str:
    """An identifier that is the name of a file or folder, too."""
    found = text(node)
    if not found.replace("-", "").replace("_", "").isalnum() or not found.isascii():
        raise node.error(
            f"{found[:40]!r} is not an identifier of Scan2CAD", "correct the annotation"
        )
    return found


def _trs(node: Node) -> Array:
    """(4, 4) translation, rotation and scale of a record."""
    translation = node.need("translation").numbers(3, MAX_COORDINATE_M)
    scale = node.need("scale").numbers(3, _MAX_SCALE)
    if (scale <= 0.0).any():
        what = "zero" if (scale >= 0.0).all() else "negative: it mirrors"
        raise node.need("scale").error(f"a scale is {what}", "correct the annotation")
    quaternion = node.need("rotation")
    w, x, y, z = quaternion.numbers(4, 2.0)
    length = float(np.linalg.norm([w, x, y, z]))
    if abs(length - 1.0) > _UNIT_QUATERNION_TOLERANCE:
        raise quaternion.error(
            f"this quaternion has the length {length:.3g}, not 1", "it is written w, x, y, z"
        )
    w, x, y, z = np.array([w, x, y, z]) / length
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    M = np.eye(4)
    M[:3, :3], M[:3, 3] = rotation * scale, translation
    return M


@cache
def categories() -> dict[str, str]:
    """A category or a plain word by its synset."""
    ours = {synset: name for name, told in records() for synset in told.synsets}
    return {**_OTHERS, **ours}


class Scan2CadImporter:
    """Reads annotations of Scan2CAD, its ``full_annotations.json``."""

    options: Mapping[str, str] = {
        "scan": "Which scan, such as scene0470_00; needed where the file holds several.",
        "models": "The folder of ShapeNetCore.v2; boxes take the place of CADs that it lacks.",
        "frames": "Poses of the photographs: ScanNet's exported folder, a .sens file or JSON.",
        "polygon": "The floor in the frame of the scan, in metres: JSON or CSV.",
        "official_centre": "yes: subtract the CADs' centres, as the official scorer does "
        "(default no).",
    }
    paths = frozenset({"models", "frames", "polygon"})

    def read(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Capture:
        """Read the annotation of one scan.

        Args:
            source: The JSON file.
            options: See `options`.

        Raises:
            InputError: It is missing, is not such a file, or holds nonsense; names the place.
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
        # Also where it is not used: JSON has no infinities.
        raise entry.error("a number is out of range", "correct the annotation") from error


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
