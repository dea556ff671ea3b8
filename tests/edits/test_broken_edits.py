"""Edits that USD cannot read are refused by every command, with one message that says where."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pxr import Sdf

from openrooms_usd.composing import compose_room
from openrooms_usd.errors import InputError
from tests.commands import run

ROOM = """\
layout: {polygon: [[0, 0], [3, 0], [3, 3], [0, 3]]}
furniture: {objects: []}
materials: {resolution: 16}
cameras: {resolution: [8, 6], views: [{name: eye, eye: [1, 1, 1.5], target: [2, 2, 1]}]}
"""
HEAD = b'#usda 1.0\nover "World"\n{\n'
# By what is wrong with it: the layer, and the line that the message names.
BROKEN = {
    "nothing in it": (b"", None),
    "blank": (b" \n", None),
    "no USD": (b"hello\n", None),
    "only the start of a crate": (b"PXR-USDC", None),
    "bytes": (bytes(range(256)), None),
    "a mark before the text": (b"\xef\xbb\xbf" + HEAD + b"}\n", None),
    "a byte that is no text": (HEAD + b'  string a = "\xff"\n}\n', 4),
    "cut off": (HEAD + b'  over "a"\n', 4),
    "never closed": (HEAD, 4),
    "closed twice": (HEAD + b"}\n}\n", 5),
    "an open quote": (b'#usda 1.0\nover "World\n{\n}\n', 2),
    "a word for a number": (HEAD + b"  double a = oops\n}\n", 4),
    "two numbers of three": (HEAD + b"  double3 a = (1, 2)\n}\n", 4),
    "an unknown word": (HEAD + b'}\novre "World"\n{\n}\n', 5),
    "a name twice": (HEAD + b'  over "a" {}\n  over "a" {}\n}\n', 5),
}


@pytest.fixture(scope="module")
def composed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("room")
    (folder / "room.yaml").write_text(ROOM)
    compose_room(folder / "room.yaml", folder / "out", workers=1)
    return folder


@pytest.fixture
def room(composed: Path) -> Iterator[Path]:
    """A composed room, whose edits are whole again afterwards."""
    edits = composed / "out/layers/edits.usda"
    whole = edits.read_bytes()
    yield composed
    edits.write_bytes(whole)


def commands(folder: Path) -> list[list[Any]]:
    scene = folder / "out/scene.usda"
    return [
        ["compose", folder / "room.yaml", "-o", folder / "out"],
        ["render", scene, "-o", folder / "none", "--channels", "depth"],
        ["validate", scene],
        ["convert", scene, folder / "none", "--format", "openrooms-xml"],
        ["edit", "orphans", folder / "out"],
        ["edit", "fix-units", folder / "out"],
        ["edit", "orphans", scene],
        ["edit", "fix-units", scene],
    ]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("kind", BROKEN)
def test_every_command_refuses_it_alike(kind: str, room: Path) -> None:
    text, line = BROKEN[kind]
    edits = room / "out/layers/edits.usda"
    before = tree(room)
    edits.write_bytes(text)
    said = {refusal(words) for words in commands(room)}
    assert len(said) == 1, said
    (message,) = said
    assert message.startswith(f"{edits}"), message
    assert line is None or f"edits.usda:{line}:" in message, message
    edits.write_bytes(b"")
    assert tree(room) == before | {"out/layers/edits.usda": b""}


def refusal(words: list[Any]) -> str:
    done = run(*words)
    assert isinstance(done.exception, InputError), (words[0], done.output, done.exception)
    assert done.exception.remedy
    return str(done.exception)


def tree(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_edits_in_binary_form_are_refused_under_the_name_of_a_text(room: Path) -> None:
    """USD goes by the ending of a name; such a layer would be passed over."""
    edits = room / "out/layers/edits.usda"
    Sdf.Layer.FindOrOpen(str(edits)).Export(str(room / "other.usdc"))
    edits.write_bytes((room / "other.usdc").read_bytes())
    for words in commands(room):
        assert refusal(words).startswith(f"{edits}: not a readable USD file")
