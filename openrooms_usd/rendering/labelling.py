"""What finished renders show, written as labels: COCO, or boxes in 2D and 3D."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from openrooms_usd import claims
from openrooms_usd.errors import InputError
from openrooms_usd.progress import Progress, silent
from openrooms_usd.rendering.boxes import boxes
from openrooms_usd.rendering.coco import coco
from openrooms_usd.rendering.manifest import write_json


@dataclass(frozen=True)
class LabelSummary:
    """What was written.

    Attributes:
        file: The JSON file.
        views: How many views it describes.
        objects: How many objects are labelled in them, all views together.
    """

    file: Path
    views: int
    objects: int

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for ``--json``."""
        return {**asdict(self), "file": str(self.file)}


def write_labels(
    renders: Sequence[Path],
    out: Path,
    *,
    form: Literal["coco", "boxes"] = "coco",
    taxonomy: str = "category",
    stage: Path | None = None,
    progress: Progress = silent,
) -> LabelSummary:
    """Write what is seen in finished renders.

    Args:
        renders: Their folders; ``boxes`` are of one.
        out: The JSON file to write.
        form: ``coco``, or ``boxes`` in 2D and 3D.
        taxonomy: Whose classes, for ``coco``.
        stage: What was rendered, for ``boxes``.
        progress: Called with each view.

    Raises:
        InputError: One is not a render or lacks a channel, the stage is missing, or boxes of
            several renders are requested.
        OutputError: The file cannot be written, or is there and not ours.
    """
    claims.check_output(out)
    if form == "coco":
        found = coco(renders, taxonomy, progress)
        views, count = len(found["images"]), len(found["annotations"])
    else:
        found = _boxes(renders, stage, progress)
        views, count = len(found["views"]), sum(len(v["objects"]) for v in found["views"].values())
    with claims.output(out):
        write_json(out, found)
    return LabelSummary(out, views, count)


def _boxes(renders: Sequence[Path], stage: Path | None, progress: Progress) -> dict[str, Any]:
    from openrooms_usd.usd.files.diagnostics import quiet
    from openrooms_usd.usd.files.layers import open_stage

    if len(renders) != 1:
        raise InputError(
            f"boxes in 3D need a single render, got {len(renders)}",
            remedy="label each render separately",
        )
    if stage is None:
        raise InputError("boxes in 3D come from the stage", remedy="give --stage scene.usda")
    with quiet():
        return boxes(renders[0], open_stage(stage), progress)
