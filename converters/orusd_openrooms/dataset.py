"""Writes finished renders as a scene of an OpenRooms dataset."""

import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import count
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic, claims, ledger
from openrooms_usd.errors import InputError, OrusdError, OutputError, writing
from openrooms_usd.progress import Progress, silent
from openrooms_usd.render.datasets import DatasetOptions, DatasetSummary
from openrooms_usd.render.reading import RenderedScene, RenderedView
from openrooms_usd.untrusted import read_bytes
from orusd_openrooms import layout
from orusd_openrooms.cautions import cautions
from orusd_openrooms.crowding import too_many_of, without
from orusd_openrooms.frame import Frame
from orusd_openrooms.framefiles import write_frame
from orusd_openrooms.layout import SHARED, SPLITS, SUBSETS, Place
from orusd_openrooms.records import lights_of
from orusd_openrooms.scenefolder import write_scene_folder

_SCENE: Final = re.compile(r"scene\w{1,60}", re.ASCII)


class OpenRoomsDataset:
    """The files of OpenRooms as released (docs/openrooms.md)."""

    takes: Final = "variants"
    needs: Mapping[str, str] = MappingProxyType({})
    called: Mapping[str, str] = MappingProxyType(
        {
            "main": "main_xml",
            "mainDiffMat": "mainDiffMat_xml",
            "mainDiffLight": "mainDiffLight_xml",
        }
    )

    def write(
        self,
        renders: Sequence[RenderedScene],
        root: Path,
        options: DatasetOptions,
        progress: Progress = silent,
    ) -> DatasetSummary:
        """Write a scene of a dataset; nothing appears before all is written.

        Args:
            renders: The variants of one scene.
            root: The dataset's folder; other scenes in it, and other frames of this one, stay.
            options: How to lay it out.
            progress: Called with each finished view and the finished fraction.

        Raises:
            InputError: The renders or options do not fit each other.
            OutputError: A file cannot be written.
        """
        _check(renders, options)
        missing: dict[str, str] = {}
        frames: dict[str, list[int]] = {}
        crowded: list[dict[str, frozenset[int]]] = [{} for _ in renders]
        if options.crowded != "keep":
            crowded = too_many_of(options.splits, renders)
        if options.crowded == "leave-out":
            renders = [without(*each) for each in zip(renders, crowded, strict=True)]
        total, done = sum(len(render.views) for render in renders), count(1)

        def finished(view: str) -> None:
            progress(view, next(done) / total)

        with claims.claimed(root, f".orusd.{options.scene}.sha256") as kept:
            with atomic.filling(root) as beside:
                for split, render, least in zip(options.splits, renders, crowded, strict=True):
                    place = Place(beside, options.scene, split, options.layout)
                    frames[split] = _write_split(place, render, options, least, missing, finished)
                    write_scene_folder(place, root, render, options.first, kept)
                _write_scenes(beside, renders, options)
                _write_lists(beside, root, options)
                files = (path for path in beside.rglob("*") if path.is_file())
                written = {path.relative_to(beside) for path in files}
                _refuse_to_replace(root, written, kept)
            stay = _remove_stale(root, written, kept)
        notes = (*cautions(renders, root, options, crowded), *stay)
        return DatasetSummary(root, frames, len(written), missing, notes)


def _write_split(
    place: Place,
    render: RenderedScene,
    options: DatasetOptions,
    least: Mapping[str, frozenset[int]],
    missing: dict[str, str],
    finished: Callable[[str], None],
) -> list[int]:
    lights = lights_of(render)
    instances = max(render.legend("instance"), default=0)
    numbers = [options.first + index for index in range(len(render.views))]
    for number, view in zip(numbers, render.each(), strict=True):
        placed = [light for light in lights if light.number not in least.get(view.name, ())]
        frame = Frame(view, placed, options.order, instances)
        write_frame(place, number, frame)
        missing |= frame.missing
        finished(view.name)
    return numbers


def _write_scenes(root: Path, renders: Sequence[RenderedScene], options: DatasetOptions) -> None:
    """The rooms of which there are stages: meshes, materials, lights, and the file of all."""
    from openrooms_usd.usd.layers import open_stage
    from orusd_openrooms.scenes.export import Film, add_scene

    for split, render, file in zip(options.splits, renders, options.stages, strict=False):
        view = next(iter(render.views.values()))
        fov = float(2.0 * np.degrees(np.arctan(0.5 * view.width / view.K[0, 0])))
        film = Film(fov, (view.width, view.height))
        add_scene(open_stage(file), root, options.scene, split, film)


def _write_lists(beside: Path, root: Path, options: DatasetOptions) -> None:
    """``train.txt``, ``val.txt`` and ``test.txt``: the scene stands in one of them."""
    for name in SUBSETS:
        path, own = root / f"{name}.txt", options.scene.encode()
        # Names of others stay as they are, in whatever encoding.
        scenes = set(read_bytes(path, "table").split()) if os.path.lexists(path) else set()
        scenes.discard(own)
        if name == options.subset:
            scenes.add(own)
        atomic.write_bytes(beside / path.name, b"".join(scene + b"\n" for scene in sorted(scenes)))


def _refuse_to_replace(root: Path, written: Iterable[Path], known: ledger.Ledger) -> None:
    """See that only files of an earlier run give way; lists of scenes are written by all.

    Raises:
        OutputError: There are others.
    """
    inner = sorted(path for path in written if len(path.parts) > 1 and path.parts[0] != SHARED)
    there = (root / path for path in inner if os.path.lexists(root / path))
    foreign = [path for path in there if not known.is_own(path)]
    if foreign:
        more = f" (and {len(foreign) - 1} more)" if len(foreign) > 1 else ""
        raise OutputError(
            f"this would be replaced{more}, and no earlier run wrote it as it is now",
            place=foreign[0],
            remedy="give another --scene or --first, another folder, or move the files away",
        )


def _remove_stale(root: Path, written: Iterable[Path], known: ledger.Ledger) -> list[str]:
    """Remove lights of an earlier render of the same frames: loaders take all that they find.

    Returns:
        A sentence for each file that stays, because it is not ours to remove.
    """
    new = set(written)
    folders = {path.parent for path in new if path.parent.name.startswith("light_")}
    with writing(root):
        inner = [path for folder in sorted(folders) for path in sorted((root / folder).iterdir())]
        stay = known.remove(path for path in inner if path.relative_to(root) not in new)
    return [
        f"{path.relative_to(root.absolute()).as_posix()} stays, which no earlier run wrote as it "
        "is now: loaders will take it"
        for path in stay
    ]


def _check(renders: Sequence[RenderedScene], options: DatasetOptions) -> None:
    if not _SCENE.fullmatch(options.scene):
        raise _wrong(f"{options.scene!r} is no name of a scene", "such as scene0000_00")
    if options.first < 0:
        raise _wrong(f"the first view cannot be number {options.first}", "give 1, or 0")
    if len(options.splits) != len(renders) or len(set(options.splits)) != len(renders):
        raise _wrong(
            f"{len(renders)} renders and {len(options.splits)} splits",
            "give --split once for each render, each another one",
        )
    if options.stages and len(options.stages) != len(renders):
        raise _wrong(
            f"{len(renders)} renders and {len(options.stages)} stages",
            "give --stage once for each render, in their order",
        )
    for split in options.splits:
        if split not in SPLITS:
            raise _wrong(f"no split is named {split!r}", f"known: {', '.join(SPLITS)}")
    for suffix in layout.SUFFIXES:
        of_suffix = zip(options.splits, renders, strict=True)
        _check_views([render for split, render in of_suffix if split.endswith(f"_{suffix}")])


def _check_views(renders: Sequence[RenderedScene]) -> None:
    """Variants share their views."""
    for render in renders[1:]:
        first = renders[0].views
        same = list(render.views) == list(first) and all(
            _same(view, first[name]) for name, view in render.views.items()
        )
        if not same:
            raise InputError(
                f"its views are not those of {renders[0].folder}",
                place=render.folder,
                remedy="variants of a scene share their views: render the same cameras",
            )


def _same(view: RenderedView, other: RenderedView) -> bool:
    pairs: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = [
        (view.K, other.K),
        (view.world_from_camera, other.world_from_camera),
    ]
    size = (view.width, view.height) == (other.width, other.height)
    return size and all(np.allclose(a, b, rtol=0.0, atol=1e-6) for a, b in pairs)


def _wrong(message: str, remedy: str) -> OrusdError:
    return InputError(message, place="dataset", remedy=remedy)
