"""Kinds that go wrong on purpose, one for each verdict: the campaign has to see every one."""

import ctypes
import sys
import time
from collections.abc import Callable
from pathlib import Path

from tests.fuzz.kinds import Kind


def _plant(folder: Path) -> None:
    (folder / "in").mkdir()
    (folder / "in/a.txt").write_text("1 2 3\n")


def _refuse(message: str) -> None:
    from openrooms_usd.errors import InputError

    raise InputError(message, place="planted")


def _traceback(folder: Path) -> None:
    raise KeyError("planted")


def _printed(folder: Path) -> None:
    sys.stderr.write('Traceback (most recent call last):\n  File "x.py", line 1\nKeyError: 1\n')


def _crash(folder: Path) -> None:
    ctypes.string_at(0)


def _hang(folder: Path) -> None:
    with (folder / "beside/pipe").open("rb") as stream:
        stream.read()


def _spin(folder: Path) -> None:
    while True:
        time.sleep(0.01)


def _memory(folder: Path) -> None:
    bytearray(b"x") * (1 << 40)


def _resident(folder: Path) -> None:
    held = bytearray(600 << 20)
    held[::4096] = b"x" * len(range(0, len(held), 4096))


def _half(folder: Path) -> None:
    (folder / "out").mkdir()
    (folder / "out/scene.usda").write_text("half")
    _refuse("half-written")


def _left(folder: Path) -> None:
    (folder / "out").mkdir()
    (folder / "out/.scene.usda.1234").write_text("left")


def _outside(folder: Path) -> None:
    (folder / "beside/keep.txt").unlink()


def _beside(folder: Path) -> None:
    (folder / "here/new.txt").write_text("new")
    _refuse("written elsewhere")


def _codes(folder: Path) -> None:
    sys.stdout.write("a name \x1b[31mwith colour\n")


def _kind(name: str, run: Callable[[Path], object]) -> Kind:
    return Kind(f"planted.{name}", _plant, ((1, run),), share=1)


KINDS = (
    _kind("refused", lambda folder: _refuse("no")),
    _kind("accepted", lambda folder: None),
    _kind("traceback", _traceback),
    _kind("traceback-printed", _printed),
    _kind("crash", _crash),
    _kind("hang", _hang),
    _kind("hang-spinning", _spin),
    _kind("memory", _memory),
    _kind("memory-resident", _resident),
    _kind("half-written", _half),
    _kind("half-written-left", _left),
    _kind("outside-touched", _outside),
    _kind("outside-touched-beside", _beside),
    _kind("control-codes", _codes),
)
