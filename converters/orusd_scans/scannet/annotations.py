"""The annotations of Scan2CAD: CADs in the frame of the scan that they were aligned to.

Each scan of ``full_annotations.json`` has a transform from the scan to the world in which people
annotated (Y up), and each of its models one from the CAD to that world; a CAD's points are in the
scan at inv(M_scan) M_cad. Both are T R S, with quaternions w, x, y, z. (Avetisyan et al.,
"Scan2CAD: Learning CAD Model Alignment in RGB-D Scans", CVPR 2019.)
"""

from collections import Counter
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.capture import CapturedModel
from openrooms_usd.errors import InputError
from orusd_scans.records.fields import text
from orusd_scans.records.jsonfile import Node, read_json
from orusd_scans.synsets import UNKNOWN, categories
from orusd_scans.worldframe import MAX_COORDINATE_M, WorldFrame

Array = NDArray[np.float64]
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


def entry_of(source: Path, scan: str | None) -> Node:
    """The annotation of a scan.

    Args:
        source: The file.
        scan: Which scan; None where the file holds one.

    Raises:
        InputError: It is no such file, or lacks the scan.
    """
    root = read_json(source, "annotations")
    entries = Node({"": root.value}, source).items("") if isinstance(root.value, list) else []
    if not entries or not all(isinstance(e.value, dict) and "id_scan" in e.value for e in entries):
        raise root.error(
            "this is JSON, but no Scan2CAD annotation: a list of scans with id_scan is expected",
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
        raise node.need("bbox").error("a half extent is not above zero", "mend the annotation")
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
        raise node.error(f"{found[:40]!r} is no identifier of Scan2CAD", "mend the annotation")
    return found


def _trs(node: Node) -> Array:
    """(4, 4) translation, rotation and scale of a record."""
    translation = node.need("translation").numbers(3, MAX_COORDINATE_M)
    scale = node.need("scale").numbers(3, _MAX_SCALE)
    if (scale <= 0.0).any():
        what = "zero" if (scale >= 0.0).all() else "negative: it mirrors"
        raise node.need("scale").error(f"a scale is {what}", "mend the annotation")
    quaternion = node.need("rotation")
    w, x, y, z = quaternion.numbers(4, 2.0)
    length = float(np.linalg.norm([w, x, y, z]))
    if abs(length - 1.0) > _UNIT_QUATERNION_TOLERANCE:
        raise quaternion.error(
            f"this quaternion has the length {length:.3g}, not 1", "it is written w, x, y, z"
        )
    w, x, y, z = np.array([w, x, y, z]) / length
    rotation = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
    M = np.eye(4)
    M[:3, :3], M[:3, 3] = rotation * scale, translation
    return M
