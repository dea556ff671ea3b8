"""How a plain scan stands: which way is up in it, and how long its unit is.

What the file, or somebody, says is compared with the evidence of all axes and all units. Where that
is clear it is followed, with a note; where it is not, or contradicts what was asked, the scan is
refused with the option that settles it. The options are those of the importer: ``--up``,
``--unit``, or ``up:`` and ``unit:`` in a description.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.rooms.verticals import Vertical, verticals
from orusd_scans.scanaxes import find_up, written
from orusd_scans.scanunits import Asked, find_unit

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Standing:
    """How a scan stands.

    Attributes:
        up: (3,) unit, in the scan's frame.
        unit: Metres for one unit of it.
        settled: Options that say what was found where it is not what the file says.
        notes: What people should know.
    """

    up: Array
    unit: float
    settled: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def find_standing(cloud: Cloud, asked: Asked, source: Path) -> Standing:
    """Find how a scan stands.

    Args:
        cloud: Finite points in the file's frame and unit.
        asked: What is said of it.
        source: The file, for messages.

    Raises:
        InputError: What is said is absurd, or the evidence is not clear.
    """
    found, notes = verticals(cloud), list[str]()
    if not found:
        found = (_as_said(cloud, asked.up),)
        if not asked.up_said:
            notes.append(
                f"{written(asked.up)} is taken for up: the scan shows too little surface to tell"
                " (`--up` says otherwise)"
            )
    unit, name = find_unit(found, asked, source, notes)
    up = find_up(found, asked, unit, source, notes)
    settled = {} if np.allclose(up, asked.up, atol=1e-3) else {"up": written(up)}
    if asked.unit is None and name != "m":
        settled["unit"] = name
    return Standing(up, unit, settled, tuple(notes))


def _as_said(cloud: Cloud, up: Array) -> Vertical:
    """The direction that is said, of a scan that shows hardly any surface."""
    heights = cloud.points @ up
    across = cloud.points - heights[:, None] * up
    along = float(np.ptp(np.percentile(heights, (1.0, 99.0))))
    sizes = np.ptp(np.percentile(across, (1.0, 99.0), axis=0), axis=0)
    return Vertical(up, 0.0, np.inf, None, (along, float(np.linalg.norm(sizes))))
