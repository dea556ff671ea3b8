"""Puts what is no ordinary file where one is expected: pipes, devices, links, folders, nothing."""

import os
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Final

BESIDE: Final = "beside"


def plant_beside(folder: Path) -> None:
    """What lies beside input and output: files to keep, a pipe, a link without end."""
    beside = folder / BESIDE
    (beside / "view").mkdir(parents=True)
    (beside / "keep.txt").write_text("keep this\n")
    (beside / "view/channels.exr").write_bytes(b"keep this too")
    os.mkfifo(beside / "pipe")
    (beside / "endless").symlink_to("/dev/zero")
    (beside / "circle").symlink_to("circle")


def _folder(path: Path) -> None:
    path.mkdir()
    (path / "within.txt").write_text("x")


def _forbidden(path: Path) -> None:
    path.write_bytes(b"x")
    path.chmod(0)


def _linked(target: str) -> Callable[[Path], None]:
    return lambda path: path.symlink_to(target)


def _beside(name: str) -> Callable[[Path], None]:
    """A link to what lies beside the input, however deep the file is in it."""

    def put(path: Path) -> None:
        root = path.parent
        while not (root / BESIDE).is_dir():
            root = root.parent
        path.symlink_to(root / BESIDE / name)

    return put


_WAYS: Final[tuple[Callable[[Path], None], ...]] = (
    os.mkfifo,
    _folder,
    _forbidden,
    lambda path: None,
    lambda path: path.write_bytes(b""),
    _linked("/dev/zero"),
    _linked("/dev/null"),
    _linked("/dev/full"),
    _linked("/proc/self/mem"),
    _linked("nowhere"),
    lambda path: path.symlink_to(path.name),
    _beside("keep.txt"),
    _beside("pipe"),
    _beside("endless"),
)


def replace_file(path: Path, rng: Random) -> None:
    """Put something else in place of a file."""
    path.unlink()
    rng.choice(_WAYS)(path)
