"""Views that stand for the rest, and small pictures of them that a page holds in itself."""

import base64
import tempfile
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import cycle, islice
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import imagefile
from openrooms_usd.dataset.plan import Job, PlannedRoom, view_name
from openrooms_usd.dataset.records import SCENE
from openrooms_usd.dataset.store import Store
from openrooms_usd.errors import InputError
from openrooms_usd.rendering.folder import MANIFEST, preview_file
from openrooms_usd.rendering.previews import preview
from openrooms_usd.rendering.reading import read_render
from openrooms_usd.usd.shading.textures import read_texture

LIGHT: Final = ("denoised", "radiance")
"""What people look at of a view, the best first."""

_WIDTH: Final = 240
_HOW: Final = {"oiio:ColorSpace": "srgb_rec709_scene", "Compression": "jpeg:80"}


@dataclass(frozen=True)
class Picture:
    """A small picture.

    Attributes:
        name: What is written below it.
        alt: What it shows, for those who cannot see it.
        data: The picture as an address; empty where it cannot be read.
    """

    name: str
    alt: str
    data: str


@dataclass(frozen=True)
class Strip:
    """Pictures that are looked at side by side.

    Attributes:
        title: What they have in common.
        pictures: One or several.
    """

    title: str
    pictures: tuple[Picture, ...]


def variants(store: Store, most: int) -> list[Strip]:
    """A view of some rooms in all their variants: of every type, and spread over the rooms.

    Args:
        store: Where everything lies.
        most: At most so many pictures, but of one room at least.
    """
    jobs: dict[int, list[Job]] = defaultdict(list)
    rooms: dict[int, PlannedRoom] = {}
    for job in store.jobs():
        # Nobody has begun the others.
        if store.record_path(job, SCENE).is_file():
            rooms[job.room.number] = job.room
            jobs[job.room.number].append(job)
    across = max(map(len, jobs.values()), default=1)
    strips: list[Strip] = []
    for place, room in enumerate(spread(rooms.values(), max(1, most // across))):
        if strip := _room_strip(store, room, jobs[room.number], place):
            strips.append(strip)
    return strips


def channels(store: Store, wanted: Sequence[str]) -> Strip | None:
    """A finished view in its channels; None where no view is finished.

    Args:
        store: Where everything lies.
        wanted: Their names, as far as the view has them.
    """
    for job in store.jobs():
        for view, _ in store.records(job):
            pictures = tuple(_channel_pictures(store, job, view, wanted))
            if pictures:
                return Strip(f"{job.name}/{view_name(view)}", pictures)
    return None


def _channel_pictures(
    store: Store, job: Job, view: int, wanted: Sequence[str]
) -> Iterator[Picture]:
    """Those that are stored, and those that are made of the channels."""
    render, folder = store.render(job), store.render(job) / view_name(view)
    try:
        if store.remote is not None:
            store.remote.get([store.name_of(render / MANIFEST)], store.root)
            store.remote.get_all(f"{store.name_of(folder)}/", store.root)
        found = read_render(render).views[view_name(view)]
        for name in wanted:
            picture = _picture(store, job, view, [name])
            data = picture.data
            if not data and name in found.pixels:
                data = _data(preview(name, found.pixels[name]).pixels)
            if data:
                yield Picture(name, f"{name} of {job.name}/{view_name(view)}", data)
    except (InputError, KeyError):
        return


def spread(rooms: Iterable[PlannedRoom], most: int) -> list[PlannedRoom]:
    """Some of many rooms: types by turns, and of each type rooms from the first to the last."""
    by_type: dict[str, list[PlannedRoom]] = defaultdict(list)
    for room in rooms:
        by_type[str(room.source.get("type", ""))].append(room)
    left = min(most, sum(map(len, by_type.values())))
    shares = dict.fromkeys(sorted(by_type), 0)
    for kind in cycle(shares):
        if not left:
            break
        if shares[kind] < len(by_type[kind]):
            shares[kind] += 1
            left -= 1
    chosen = [
        by_type[kind][(2 * number + 1) * len(by_type[kind]) // (2 * share)]
        for kind, share in shares.items()
        for number in range(share)
    ]
    return sorted(chosen, key=lambda room: room.number)


def _room_strip(store: Store, room: PlannedRoom, jobs: Sequence[Job], place: int) -> Strip | None:
    every = [(job, [view for view, _ in store.records(job)]) for job in jobs]
    finished = [(job, views) for job, views in every if views]
    if not finished:
        return None
    # One that all variants have, if there is one; from room to room another.
    shared = sorted(set.intersection(*(set(views) for _, views in finished)))
    pictures = []
    for job, views in finished:
        chosen = next(islice(cycle(shared or views), place, None))
        pictures.append(replace(_picture(store, job, chosen, LIGHT), name=job.variant))
    return Strip(room.name, tuple(pictures))


def _picture(store: Store, job: Job, view: int, wanted: Sequence[str]) -> Picture:
    """The first of some channels that has a stored picture, as far as that can be read."""
    name = f"{job.name}/{view_name(view)}"
    for channel in wanted:
        path = store.render(job) / view_name(view) / preview_file(channel)
        with suppress(InputError):
            if store.remote is not None:
                store.remote.get([store.name_of(path)], store.root)
            if path.is_file():
                return Picture(name, f"{channel} of {name}", _data(read_texture(str(path))))
    return Picture(name, f"{name}: there is no picture of it", "")


def _data(pixels: NDArray[Any]) -> str:
    """A picture as a small JPEG in an address."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "small.jpg"
        imagefile.write(file, _reduced(pixels), "uint8", _HOW)
        return f"data:image/jpeg;base64,{base64.b64encode(file.read_bytes()).decode()}"


def _reduced(pixels: NDArray[Any]) -> NDArray[np.uint8]:
    """Three channels of bytes, no wider than `_WIDTH`."""
    import OpenImageIO

    colored = np.repeat(pixels[..., :1], 3, axis=-1) if pixels.shape[-1] < 3 else pixels[..., :3]
    height, width = colored.shape[:2]
    source: Any = OpenImageIO.ImageBuf(np.ascontiguousarray(colored))
    if width > _WIDTH:
        size = OpenImageIO.ROI(0, _WIDTH, 0, max(1, round(_WIDTH * height / width)), 0, 1, 0, 3)
        source = OpenImageIO.ImageBufAlgo.resize(source, "box", roi=size)
    return np.asarray(source.get_pixels(OpenImageIO.UINT8))
