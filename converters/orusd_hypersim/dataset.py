"""All rooms of a dataset as scenes of Hypersim."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np

from openrooms_usd import claims
from openrooms_usd.errors import InputError
from openrooms_usd.progress import Progress, silent
from openrooms_usd.rendering.datasets import DatasetOptions, DatasetSummary, FinishedRoom
from openrooms_usd.rendering.reading import RenderedScene
from orusd_hypersim import tables
from orusd_hypersim.cameras import orientations, positions
from orusd_hypersim.frames import write_frame
from orusd_hypersim.hdf5 import write_array

_LEDGER: Final = ".orusd.hypersim.sha256"
# A volume of a hundred for each variant, of a thousand rooms each.
_VOLUMES: Final = {"main": 1, "mainDiffMat": 101, "mainDiffLight": 201, "mainDiffMatLight": 301}
_ROOMS: Final = 1000
_MOST_ROOMS: Final = 100 * _ROOMS


class HypersimDataset:
    """Scenes in the layout of Hypersim (docs/howto/hypersim.md)."""

    takes: Final = "rooms"
    needs: Mapping[str, str] = MappingProxyType({"h5py": "hypersim"})

    def write_rooms(
        self,
        rooms: Iterable[FinishedRoom],
        root: Path,
        options: DatasetOptions,
        progress: Progress = silent,
    ) -> DatasetSummary:
        """Write a scene for each variant of each room; see `rendering.datasets.RoomsWriter`."""
        splits: list[tuple[object, ...]] = []
        lenses: list[tuple[object, ...]] = []
        frames: dict[str, list[int]] = {}
        missing: dict[str, str] = {}
        with claims.refilling(root, _LEDGER) as refill:
            folder = refill.folder
            for room in rooms:
                progress(room.name, 0.5)
                for variant, render in sorted(room.renders.items()):
                    scene = scene_name(room.number, variant)
                    frames[scene] = _write_scene(folder / "scenes" / scene, render, missing)
                    part = (True, "", room.split)
                    splits += [(scene, tables.CAMERA, frame, *part) for frame in frames[scene]]
                    lenses.append(tables.camera_row(scene, next(iter(render.views.values()))))
            tables.write_table(folder / tables.SPLIT_FILE, tables.SPLIT_HEADS, splits)
            tables.write_table(folder / tables.CAMERAS_FILE, tables.CAMERA_HEADS, lenses)
        return DatasetSummary(root, frames, len(refill.written), missing)


def scene_name(number: int, variant: str) -> str:
    """What a variant of a room is called.

    Raises:
        InputError: There is no such name.
    """
    if variant not in _VOLUMES or number >= _MOST_ROOMS:
        raise InputError(
            f"Hypersim's names have no room for the variant {variant!r} of room {number}",
            place="outputs",
            remedy=f"at most {_MOST_ROOMS:,} rooms, of {', '.join(_VOLUMES)}",
        )
    return f"ai_{_VOLUMES[variant] + number // _ROOMS:03d}_{number % _ROOMS:03d}"


def _write_scene(folder: Path, render: RenderedScene, missing: dict[str, str]) -> list[int]:
    """Write a scene; the numbers of its frames."""
    first = next(iter(render.views.values()))
    alike = [
        view
        for view in render.each()
        if (view.K == first.K).all() and (view.width, view.height) == (first.width, first.height)
    ]
    if len(alike) < len(render.views):
        missing["frames of other lenses"] = "a scene of Hypersim has one lens"
    for number, view in enumerate(alike):
        missing |= write_frame(folder / "images", number, view)
    detail = folder / "_detail"
    tables.write_scene_tables(detail, render)
    camera = detail / tables.CAMERA
    frames = np.arange(len(alike))
    arrays = {
        "positions": positions(alike),
        "orientations": orientations(alike),
        "frame_indices": frames,
    }
    for name, values in arrays.items():
        write_array(camera / f"camera_keyframe_{name}.hdf5", values, packed=False)
    return [int(frame) for frame in frames]
