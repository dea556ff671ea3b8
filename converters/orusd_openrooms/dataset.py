"""Writes finished renders as a scene of an OpenRooms dataset."""

import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import count
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np

from openrooms_usd import atomic, claims, ledger
from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError, OrusdError, OutputError, writing
from openrooms_usd.progress import Progress, silent
from openrooms_usd.rendering.datasets import DatasetOptions, DatasetSummary
from openrooms_usd.rendering.manifest import write_json
from openrooms_usd.rendering.reading import RenderedScene, RenderedView
from openrooms_usd.untrusted import read_bytes
from orusd_openrooms import cameras, layout, readers
from orusd_openrooms.crowding import CROWDED, too_many_of, without
from orusd_openrooms.frame import Frame
from orusd_openrooms.framefiles import write_frame
from orusd_openrooms.layout import SHARED_INTRINSICS, SPLITS, SUBSETS, Place
from orusd_openrooms.lights import lights_of
from orusd_openrooms.pickles import write_pickled

_RELEASED: Final = (640, 480)
# Horizontal, degrees: IndoorLightEditing takes it for granted, InverseRenderingOfIndoorScene 57.
_RELEASED_FIELD_DEG: Final = 57.95
_FIELD_TOLERANCE_DEG: Final = 1.0
_SCENE: Final = re.compile(r"scene\w{1,60}", re.ASCII)


class OpenRoomsDataset:
    """The files of OpenRooms as released (docs/howto/openrooms.md)."""

    takes: Final = "variants"
    needs: Mapping[str, str] = MappingProxyType({})
    called: Mapping[str, str] = MappingProxyType(
        {"main": "main_xml", "mainDiffMat": "mainDiffMat_xml", "mainDiffLight": "mainDiffLight_xml"}
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

        lists = [f"{name}.txt" for name in SUBSETS]
        with claims.claimed(root, f".orusd.{options.scene}.sha256", shared=lists) as kept:
            with atomic.replacing_files(root) as beside:
                for split, render, least in zip(options.splits, renders, crowded, strict=True):
                    place = Place(beside, options.scene, split, options.layout)
                    frames[split] = _write_split(place, render, options, least, missing, finished)
                    write_scene_folder(place, root, render, options.first, kept)
                _write_scenes(beside, renders, options)
                _write_lists(beside, root, options)
                files = (path for path in beside.rglob("*") if path.is_file())
                written = {path.relative_to(beside) for path in files}
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
    from openrooms_usd.usd.files.layers import open_stage
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
        lines = read_bytes(path, "table").splitlines() if os.path.lexists(path) else []
        if any(len(line.split()) > 1 for line in lines):
            raise OutputError(
                "this is not a list of scenes, one per line, and would be overwritten",
                place=path,
                remedy="move it away",
            )
        scenes = {line.strip() for line in lines if line.strip()}
        scenes.discard(own)
        if name == options.subset:
            scenes.add(own)
        atomic.write_bytes(beside / path.name, b"".join(scene + b"\n" for scene in sorted(scenes)))


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
        raise _wrong(f"{options.scene!r} is not the name of a scene", "such as scene0000_00")
    if options.first < 0:
        raise _wrong(f"the first view cannot be number {options.first}", "give 1, or 0")
    if len(options.splits) != len(renders) or len(set(options.splits)) != len(renders):
        raise _wrong(
            f"{len(renders)} renders and {len(options.splits)} splits",
            "give --split once for each render, each with a different split",
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
                f"its views differ from those of {renders[0].folder}",
                place=render.folder,
                remedy="variants of a scene share their views: render the same cameras",
            )


def _same(view: RenderedView, other: RenderedView) -> bool:
    pairs: list[tuple[Array, Array]] = [
        (view.K, other.K),
        (view.world_from_camera, other.world_from_camera),
    ]
    size = (view.width, view.height) == (other.width, other.height)
    return size and all(np.allclose(a, b, rtol=0.0, atol=1e-6) for a, b in pairs)


def _wrong(message: str, remedy: str) -> OrusdError:
    return InputError(message, place="dataset", remedy=remedy)


def cautions(
    renders: Sequence[RenderedScene],
    root: Path,
    options: DatasetOptions,
    crowded: Sequence[Mapping[str, frozenset[int]]],
) -> Iterator[str]:
    """A sentence for each.

    Args:
        renders: What was written.
        root: The dataset's folder.
        options: How it was laid out.
        crowded: The lights that found no place, by view, of each split.
    """
    if options.layout == "split":
        yield (
            "this is the tree of the release, in which the published loaders find no pictures: "
            "what they read is the layout merged"
        )
    # Variants share their views.
    suffixes = map(layout.suffix_of, options.splits)
    of_suffix = dict(zip(suffixes, crowded, strict=True))
    for suffix, each in of_suffix.items():
        place = options.scene if suffix == layout.SUFFIXES[0] else f"{options.scene}, {suffix}"
        for name, numbers in sorted(each.items()):
            if options.crowded == "leave-out":
                said, why = "is left out", f"{CROWDED}, for which IndoorLightEditing has no room"
            else:
                least = ", ".join(map(str, sorted(numbers)))
                said, why = f"is without its weakest lights, {least}", CROWDED
            yield f"{place}: {name} {said}: it has {why}"
    views = [view for render in renders for view in render.views.values()]
    if {(view.width, view.height) for view in views} != {_RELEASED}:
        yield "the released loaders expect pictures of 640x480"
    fields = sorted({round(_field_deg(view), 2) for view in views})
    if any(abs(field - _RELEASED_FIELD_DEG) > _FIELD_TOLERANCE_DEG for field in fields):
        said = " to ".join(f"{field:g}" for field in dict.fromkeys((fields[0], fields[-1])))
        yield (
            f"the field of view is {said} degrees, but the released loaders assume "
            f"{_RELEASED_FIELD_DEG} or 57: use --fov {_RELEASED_FIELD_DEG}, in a "
            f"dataset.yaml views: {{fov: {_RELEASED_FIELD_DEG}}}, or change it in them"
        )
    shared = readers.read_intrinsics(root / layout.SHARED_INTRINSICS)
    if not all(np.allclose(view.K, shared, rtol=1e-6) for view in views):
        yield (
            f"{layout.SHARED_INTRINSICS.as_posix()} is that of other cameras: loaders that read it "
            "for all scenes will be wrong about these"
        )
    if caution := layout.caution(root):
        yield caution


def _field_deg(view: RenderedView) -> float:
    """The horizontal field of view, degrees."""
    return float(2.0 * np.degrees(np.arctan(0.5 * view.width / view.K[0, 0])))


def write_scene_folder(
    place: Place, root: Path, render: RenderedScene, first: int, known: ledger.Ledger
) -> None:
    """Write the cameras of a scene: the new ones in the place of their numbers, others stay.

    Args:
        place: Where they go.
        root: The dataset's folder, with what was written earlier.
        render: The views.
        first: The number of the first of them.
        known: What earlier runs wrote.

    Raises:
        InputError: Earlier cameras are damaged, or there are too few.
        OutputError: A file cannot be written.
    """
    folder = place.scene_folder
    earlier = root / folder.relative_to(place.root)
    there, told = earlier / "cam.txt", earlier / "views.json"
    poses = readers.read_cameras(there) if os.path.lexists(there) else []
    names = readers.read_view_names(told) if os.path.lexists(told) else []
    # Frames count from 1, or from 0 as in sets that others rendered again.
    start = max(0, first - 1)
    if len(poses) < start:
        raise InputError(
            f"the scene has {len(poses)} cameras, so the next view is number {len(poses) + 1}",
            place=there,
            remedy=f"give --first {len(poses) + 1}, or write the earlier views first",
        )
    end = start + len(render.views)
    new = [cameras.pose(view.world_from_camera) for view in render.views.values()]
    cameras.write_cameras(folder / "cam.txt", [*poses[:start], *new, *poses[end:]])
    names = [*names, *[""] * (len(poses) - len(names))]
    write_json(folder / "views.json", {"views": [*names[:start], *render.views, *names[end:]]})
    write_pickled(folder / "transform.dat", cameras.layout_transforms())
    K = next(iter(render.views.values())).K
    cameras.write_intrinsics(folder / "intrinsic.txt", K)
    shared = root / SHARED_INTRINSICS
    if not os.path.lexists(shared) or known.is_own(shared):
        cameras.write_intrinsics(place.root / SHARED_INTRINSICS, K)
    if place.layout == "merged":
        cameras.write_intrinsics(place.root / place.split / place.scene / "intrinsic.txt", K)
