"""Reports of steps, for people and programs: kept beside a layer, gathered at the end."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic, names
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.results import FoundObject, FoundRoom, as_text
from openrooms_usd.scratch import scratch_folder
from openrooms_usd.steps.base import StepContext

REPORT: Final = "report.json"
OVERLAY: Final = "overlay.png"


def keep_report(context: StepContext, report: Mapping[str, Any]) -> None:
    """Keep what a step reports.

    Raises:
        OutputError: It cannot be written.
    """
    _keep(context, as_text(report).encode(), REPORT)


def keep_overlay(
    context: StepContext,
    cloud: Cloud,
    rooms: Sequence[FoundRoom],
    objects: Sequence[FoundObject] = (),
    bounds: Mapping[str, NDArray[np.float64]] | None = None,
) -> None:
    """Keep a plan of what was found in a scan.

    Args:
        context: The step's.
        cloud: The scan, in the level frame.
        rooms: Those in it.
        objects: What stands in them.
        bounds: (2, 3) least and greatest coordinates of CADs by their ids.

    Raises:
        OutputError: It cannot be written.
    """
    from openrooms_usd.scan.report.overlay import write_overlay

    with scratch_folder() as folder:
        path = folder / OVERLAY
        write_overlay(path, cloud, rooms, objects, bounds)
        _keep(context, path.read_bytes(), OVERLAY)


def _keep(context: StepContext, data: bytes, name: str) -> None:
    stem, _, suffix = name.partition(".")
    digest = hashlib.sha256(data).hexdigest()[:16]
    atomic.write_bytes(context.keep(f"{stem}-{digest}.{suffix}"), data)


def gather(out: Path) -> tuple[Path, ...]:
    """Bring the reports of all steps together in a composed folder.

    ``report.json`` has a part for each step that reports, under the step's name; ``overlay.png``
    is that of the last one. Without any, neither is there.

    Args:
        out: The folder of the composition.

    Returns:
        What was written.

    Raises:
        OutputError: It cannot be written.
    """
    layers = out / names.LAYERS
    parts = {name: file for name in names.STEPS for file in layers.glob(f"{name}/report-*.json")}
    pictures = [file for name in names.STEPS for file in layers.glob(f"{name}/overlay-*.png")]
    written = []
    if parts:
        whole = {name: json.loads(file.read_text("utf-8")) for name, file in parts.items()}
        atomic.write_text(out / REPORT, as_text(whole))
        written.append(out / REPORT)
    if pictures:
        atomic.write_bytes(out / OVERLAY, pictures[-1].read_bytes())
        written.append(out / OVERLAY)
    return tuple(written)
