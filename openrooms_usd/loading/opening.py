"""Finds the source for a folder or a URL, and offers it in a line."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from openrooms_usd import adapters
from openrooms_usd.errors import InputError
from openrooms_usd.loading import shards
from openrooms_usd.loading.files import MOST_CACHED, Files, files_of
from openrooms_usd.loading.folder import INDEX
from openrooms_usd.loading.source import Form, Shards, Source, ViewSelection
from openrooms_usd.rendering.contract import NO_OPTIONS
from openrooms_usd.rendering.folder import MANIFEST
from openrooms_usd.urls import MissingFileError

# How a form is recognised if it is not named.
_SIGNS: Final = {INDEX: "dataset", shards.INDEX: "webdataset", MANIFEST: "render"}


def open_source(
    root: str | os.PathLike[str],
    *,
    form: str | None = None,
    split: str | Sequence[str] = (),
    variants: Sequence[str] = (),
    rooms: Sequence[str] = (),
    views: Sequence[str] = (),
    cache: str | os.PathLike[str] | None = None,
    most_cached: int = MOST_CACHED,
    options: Mapping[str, str] = NO_OPTIONS,
) -> Source | Shards:
    """Open finished views.

    Args:
        root: A folder, or a URL that fsspec knows (extra ``remote``).
        form: ``dataset``, ``render``, ``openrooms``, or what is installed
            (``openrooms_usd.sources``); by default what is found there.
        split: ``train``, ``val`` or ``test``, or several; all without.
        variants: Such as ``main``; all without.
        rooms: Names of rooms; all without.
        views: Names of views; all without.
        cache: Where fetched files are kept; by default the user's cache.
        most_cached: Bytes that the cache holds at most.
        options: What is asked of the form, by name.

    Returns:
        The source: ``len`` of it, and ``read(index, channels)``; of shards, which are read from end
        to end, ``names`` and ``stream(name, channels)``.

    Raises:
        InputError: Nothing known is there, or none of the views that are wanted.
        MissingPackageError: A package for this URL or form is not installed.
    """
    files = files_of(root, None if cache is None else Path(cache), most_cached)
    splits = (split,) if isinstance(split, str) else tuple(split)
    selection = ViewSelection(splits, tuple(variants), tuple(rooms), tuple(views))
    named = form or _form_of(files)
    opener: Form = adapters.load(adapters.SOURCES, named)
    adapters.check_options(adapters.SOURCES, named, opener.options, options)
    return opener.open(files, selection, options)


def _form_of(files: Files) -> str:
    for name, form in _SIGNS.items():
        try:
            with files.local({name: ""}) as root:
                if (root / name).is_file():
                    return form
        except MissingFileError:
            continue
    known = ", ".join(adapters.available(adapters.SOURCES))
    raise InputError(
        f"found neither {' nor '.join(_SIGNS)}",
        place=files,
        remedy=f"check the path, or name the form of what is there: {known}",
    )
