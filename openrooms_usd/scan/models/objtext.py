"""OBJ text as the format has it, of what other programs write: decimal commas, counts from 0.

Comments go and continued lines are joined first, so that all that looks at lines sees statements.
"""

import re
from pathlib import Path
from typing import Final

from openrooms_usd.errors import InputError

# Wavefront, "Object Files", version 3.
KNOWN: Final = frozenset(
    "v vt vn vp f l p fo g o s mg usemtl mtllib usemap maplib bevel c_interp d_interp lod"
    " shadow_obj trace_obj ctech stech cstype deg bmat step curv curv2 surf parm"
    " trim hole scrv sp end con call csh".split()
)
"""Words that begin lines."""

_COMMENT: Final = re.compile(r"[ \t]*#[^\n]*")
_CONTINUED: Final = re.compile(r"(?:[^\n]*\\[ \t\r]*\n)+[^\n]*")
_CONTINUES: Final = re.compile(r"\\[ \t\r]*\n")
_VERTEX: Final = re.compile(r"^[ \t]*v[tn]?[ \t].*$", re.MULTILINE)
_FACE: Final = re.compile(r"^[ \t]*[flp][ \t].*$", re.MULTILINE)
_COMMA: Final = re.compile(r"^[ \t]*v[ \t][^\n]*,", re.MULTILINE)
_ZERO: Final = re.compile(r"^[ \t]*f[ \t](?:[^\n]*[ \t])?0+(?=[/\s]|$)", re.MULTILINE)
_COUNT: Final = re.compile(r"(?<![-\d])\d+")


def statements(text: str) -> str:
    """The text of an OBJ or MTL file, a statement a line: without comments, with as many lines."""
    text = _COMMENT.sub("", text) if "#" in text else text
    return _CONTINUED.sub(_joined, text) if _CONTINUES.search(text) else text


def _joined(match: re.Match[str]) -> str:
    line, count = _CONTINUES.subn(" ", match[0])
    return line + "\n" * count


def standard_obj(text: str, place: Path) -> tuple[str, tuple[str, ...]]:
    """The statements of an OBJ file with decimal points and faces that count from 1.

    Args:
        text: Of the whole file.
        place: The file, for messages.

    Returns:
        The statements, a line each, with as many lines, and sentences about what was changed.

    Raises:
        InputError: Faces count from 0 and from 1.
    """
    text, notes = statements(text), list[str]()
    if _COMMA.search(text):
        text = _VERTEX.sub(_with_points, text)
        notes.append("its numbers have decimal commas: they are read as points")
    if _ZERO.search(text):
        vertices = len(re.findall(r"^[ \t]*v[ \t]", text, re.MULTILINE))
        last = re.compile(rf"^[ \t]*f[ \t](?:[^\n]*[ \t])?{vertices}(?=[/\s]|$)", re.MULTILINE)
        if last.search(text):
            raise InputError(
                f"faces name vertex 0, and vertex {vertices} of {vertices}: OBJ counts from 1",
                place=place,
                remedy="mend the program that wrote it, or convert the mesh to PLY",
            )
        text = _FACE.sub(_from_one, text)
        notes.append("its faces count vertices from 0, unlike OBJ: they are read so")
    return text, tuple(notes)


def _with_points(match: re.Match[str]) -> str:
    return re.sub(r"(?<=\d),(?=\d)", ".", match[0]).replace(",", " ")


def _from_one(match: re.Match[str]) -> str:
    return _COUNT.sub(lambda count: str(int(count[0]) + 1), match[0])
