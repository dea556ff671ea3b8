"""The text of MaterialX files, before any library sees it: what is refused, and what it names.

Entities are refused unread, and so is nesting that could exhaust a parser's stack. Files may only
name what lies below the folder of the .mtlx, or the user's own files by absolute paths.
"""

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final
from xml.etree.ElementTree import Element

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.library.models.plainxml import read_xml
from openrooms_usd.library.ownmaterials.material import licence_files

_MOST_INCLUDES: Final = 256
_INCLUDE: Final = "{http://www.w3.org/2001/XInclude}include"


@dataclass
class Outline:
    """What a file names.

    Attributes:
        text: The whole file.
        includes: The files that it includes, as written.
        files: Its pictures, as written, with the prefixes of the elements around them.
    """

    text: str
    includes: list[str] = field(default_factory=list)
    files: list[str] = field(default_factory=list)


def read_outline(path: Path) -> Outline:
    """Read a MaterialX file's text and check that a parser can be trusted with it.

    Raises:
        InputError: It cannot be read, is not XML, has a DOCTYPE or entities, or is nested too deep.
    """
    outline = Outline(untrusted.read_text(path))
    _gather(read_xml(path, "MaterialX", "text"), "", outline)
    return outline


def _gather(element: Element, prefix: str, outline: Outline) -> None:
    prefix += element.get("fileprefix", "")
    if element.tag == _INCLUDE:
        outline.includes.append(element.get("href", ""))
    elif element.get("type") == "filename" and element.get("value"):
        outline.files.append(prefix + element.get("value", ""))
    for child in element:
        _gather(child, prefix, outline)


def located(name: str, folder: Path) -> Path | None:
    """Where a named file lies, or None when the name leads out of the folder, or to no file.

    Args:
        name: As a file says it; an absolute path is the user's own choice.
        folder: The folder of the .mtlx.
    """
    plain = name.replace("\\", "/")
    target = Path(os.path.normpath(folder / plain))
    try:
        untrusted.check_path(target)
        inside = target.resolve().is_relative_to(folder.resolve())
    except (InputError, OSError, RuntimeError):  # links in a circle
        return None
    return target if inside or Path(plain).is_absolute() else None


def included(path: Path, name: str) -> Path:
    """The file that a MaterialX file includes.

    Raises:
        InputError: It lies outside the folder of ``path``, or is missing.
    """
    target = located(name, path.parent)
    if target is None or Path(name).is_absolute():
        raise InputError(
            f"it includes {name[:200]!r}, which lies outside its folder",
            place=path,
            remedy="copy the included file into the folder",
        )
    if not target.is_file():
        raise InputError(
            f"it includes {name[:200]!r}, which is missing", place=path, remedy="copy it there"
        )
    return target


def files_named(path: Path) -> list[Path]:
    """A MaterialX file, what it includes, its pictures and its licence, as far as they exist.

    Raises:
        InputError: A file of them is refused.
    """
    found = {path, *licence_files(path.parent)}
    for file, outline in outlines(path):
        places = [located(name, path.parent) for name in outline.files]
        found |= {file, *(place for place in places if place and place.is_file())}
    return sorted(found)


def outlines(path: Path) -> Iterator[tuple[Path, Outline]]:
    """A MaterialX file and all that it includes, each once, itself first.

    Raises:
        InputError: A file of them is refused or missing.
    """
    waiting, seen = [path], {path.resolve()}
    while waiting:
        file = waiting.pop()
        outline = read_outline(file)
        yield file, outline
        for name in outline.includes:
            target = included(path, name)
            if target.resolve() not in seen:
                seen.add(target.resolve())
                waiting.append(target)
        if len(seen) > _MOST_INCLUDES:
            raise InputError(
                f"the MaterialX file includes more than {_MOST_INCLUDES} others",
                place=path,
                remedy="export it again",
            )
