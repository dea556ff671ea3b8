"""What a finished render shows, written as annotations: COCO, or boxes in 2D and 3D."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from openrooms_usd.errors import InputError
from openrooms_usd.render.boxes import boxes
from openrooms_usd.render.coco import coco
from openrooms_usd.render.manifest import write_json


@dataclass(frozen=True)
class AnnotationSummary:
    """What was written.

    Attributes:
        file: The JSON file.
        views: How many views it describes.
        objects: How many objects are annotated in them, all views together.
    """

    file: Path
    views: int
    objects: int

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for ``--json``."""
        return {**asdict(self), "file": str(self.file)}


def annotate(
    render: Path,
    out: Path,
    *,
    form: Literal["coco", "boxes"] = "coco",
    taxonomy: str = "category",
    stage: Path | None = None,
) -> AnnotationSummary:
    """Write what is seen in a finished render.

    Args:
        render: Its folder.
        out: The JSON file to write.
        form: ``coco``, or ``boxes`` in 2D and 3D.
        taxonomy: Whose classes, for ``coco``.
        stage: What was rendered, for ``boxes``.

    Raises:
        InputError: It is no render, lacks a channel, or the stage is missing.
        OutputError: The file cannot be written.
    """
    if form == "coco":
        found = coco(render, taxonomy)
        views, count = len(found["images"]), len(found["annotations"])
    else:
        found = _boxes(render, stage)
        views, count = len(found["views"]), sum(len(v["objects"]) for v in found["views"].values())
    write_json(out, found)
    return AnnotationSummary(out, views, count)


def _boxes(render: Path, stage: Path | None) -> dict[str, Any]:
    from openrooms_usd.usd.diagnostics import quiet
    from openrooms_usd.usd.layers import open_stage

    if stage is None:
        raise InputError("boxes in 3D are the stage's", remedy="say --stage scene.usda")
    with quiet():
        return boxes(render, open_stage(stage))
