"""Writes a finished render for radiance fields and photogrammetry."""

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Final

from openrooms_usd import atomic, claims
from openrooms_usd.errors import InputError, OutputError, writing
from openrooms_usd.ledger import Ledger
from openrooms_usd.progress import Progress, silent
from openrooms_usd.render.datasets import DatasetOptions, DatasetSummary
from openrooms_usd.render.reading import RenderedScene
from orusd_nerf.cameras import camera_of, write_matrices
from orusd_nerf.colmap import MODEL, write_model
from orusd_nerf.pictures import DEPTHS, IMAGES, survey, write_depth, write_image
from orusd_nerf.points import NOTHING, Points, Sightings, joined, sample, sightings
from orusd_nerf.transforms import TRANSFORMS, write_transforms

_LEDGER: Final = ".orusd.nerf.sha256"
# Kinds of files that are made of depth.
_OF_DEPTH: Final = ("depths", "points")


class NerfDataset:
    """``transforms.json``, a COLMAP model and plain matrices of the same views (docs/nerf.md)."""

    takes: Final = "render"
    needs: Mapping[str, str] = MappingProxyType({})
    called: Mapping[str, str] = MappingProxyType({})

    def write(
        self,
        renders: Sequence[RenderedScene],
        root: Path,
        options: DatasetOptions,
        progress: Progress = silent,
    ) -> DatasetSummary:
        """Write one render; nothing appears before all is written.

        Args:
            renders: The render.
            root: The dataset's folder.
            options: What it was given: those of OpenRooms' dataset mean nothing here.
            progress: Called with each finished view and the finished fraction.

        Raises:
            InputError: There are several renders, or an option has no meaning here, or a camera
                cannot be said in these files.
            OutputError: A file cannot be written, or another's would be replaced.
        """
        render = _check(renders, options)
        with claims.claimed(root, _LEDGER) as kept:
            _refuse_to_replace(root, kept)
            with atomic.filling(root) as beside:
                missing, far = _write(beside, render, progress)
                files = [path for path in beside.rglob("*") if path.is_file()]
                written = {root.absolute() / path.relative_to(beside) for path in files}
            with writing(root):
                stay = kept.remove(path for path in kept.below(root) if path not in written)
        frames = {"all": list(range(1, len(render.views) + 1))}
        return DatasetSummary(root, frames, len(written), missing, tuple(_notes(far, stay)))


def _write(folder: Path, render: RenderedScene, progress: Progress) -> tuple[dict[str, str], int]:
    """Write everything; what there is none of and why, and how many pixels are too far away."""
    cameras = [camera_of(view) for view in render.views.values()]
    found, count = survey(render), len(cameras)
    parts: list[Points] = []
    far = 0
    for number, (camera, view) in enumerate(zip(cameras, render.each(), strict=True), start=1):
        image = None if found.exposure is None else write_image(folder, view, found.exposure)
        if found.depths:
            far += write_depth(folder, view)
            parts.append(sample(camera, view.pixels["depth"], image, count))
        progress(view.name, 0.5 * number / count)
    points = joined(parts)
    seen: list[Sightings] = []
    for number, (camera, view) in enumerate(zip(cameras, render.each(), strict=True), start=1):
        seen.append(sightings(camera, view.pixels["depth"], points) if parts else NOTHING)
        progress(view.name, 0.5 + 0.5 * number / count)
    write_model(folder, cameras, points, seen)
    write_transforms(folder, cameras, points, depths=found.depths)
    write_matrices(folder, cameras)
    missing = {} if found.exposure else {"images": "a view has no radiance"}
    return missing | ({} if found.depths else dict.fromkeys(_OF_DEPTH, "a view has no depth")), far


def _check(renders: Sequence[RenderedScene], options: DatasetOptions) -> RenderedScene:
    if len(renders) != 1:
        raise InputError(
            f"{len(renders)} renders, and this dataset is of one",
            place="dataset",
            remedy="write each into a folder of its own",
        )
    if options != DatasetOptions():
        raise InputError(
            "--scene, --split, --subset, --layout, --imenv-order and --first are of OpenRooms",
            place="dataset",
            remedy="leave them out",
        )
    return renders[0]


def _refuse_to_replace(root: Path, kept: Ledger) -> None:
    """See that only what an earlier run wrote gives way.

    Raises:
        OutputError: The folder is somebody else's.
    """
    names = (TRANSFORMS, IMAGES, DEPTHS, MODEL)
    foreign = [root / name for name in names if os.path.lexists(root / name)]
    if foreign and not kept.below(root):
        raise OutputError(
            "it is not of an earlier run, and would be replaced or mixed with this one",
            place=foreign[0],
            remedy="choose another folder, or move it away",
        )


def _notes(far: int, stay: Sequence[Path]) -> Iterator[str]:
    if far:
        yield f"{far} pixels lie farther away than 16 bits of millimetres say: they have no depth"
    for path in stay:
        yield f"{path.name} stays, which was changed after it was written"
