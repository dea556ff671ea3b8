"""Files that are cut short or hit: readers refuse them with their name, and never otherwise."""

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.errors import InputError

Reader = Callable[[Path], object]


def cuts_are_refused(read: Reader, file: Path, lengths: Iterable[int]) -> None:
    """Whatever is left of a file is refused."""
    whole, cut = file.read_bytes(), file.with_stem("cut")
    for length in lengths:
        cut.write_bytes(whole[:length])
        with pytest.raises(InputError, match=rf"cut\{file.suffix}"):
            read(cut)


def hits_are_told(read: Reader, file: Path, rng: np.random.Generator, count: int) -> None:
    """A changed byte is read, or refused; nothing else is raised."""
    whole, hit = file.read_bytes(), file.with_stem("hit")
    for _ in range(count):
        data = bytearray(whole)
        data[rng.integers(len(data))] = rng.integers(256)
        hit.write_bytes(data)
        try:
            read(hit)
        except InputError as error:
            assert hit.name in error.place
