"""A digest of the code that makes something: modules, and all that they import.

Layers, assets and cached results are kept as long as what determines them is the same, and code
determines them as much as any input does. A digest covers the text of modules of ours, of those
that they import, also inside functions, and of the data files beside a module that it names. Every
change of the text counts, comments too: looking closer would take longer than it saves.

What does not count:

- packages that a dotted name only passes through, and imports for type checkers alone;
- modules imported by a computed name: whoever makes one out names it as a root here;
- libraries of others. A layer carries its digest, and the same description gives the same bytes
  whatever is installed beside us. Caches, which stay on their machine, add `library_versions`.

Where a package has no source (bytecode alone), its version stands for it.
"""

import hashlib
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from pathlib import PurePath
from typing import Final

from openrooms_usd.version import __version__

# What is followed wherever it is imported: the core, its schemas and its converters.
_OURS: Final = ("openrooms_usd", "orusd_")
# The distributions that are not called as what they install.
_DISTRIBUTIONS: Final = {"pxr": "usd-core", "yaml": "PyYAML"}

# Imports as they stand at the beginning of a line. A regular expression takes a tenth of the time
# of a parser; what it finds in texts between quotes besides does no harm.
_IMPORT: Final = re.compile(
    r"^if TYPE_CHECKING:\n(?:[ \t]+[^\n]*\n|\n)+"
    r"|^[ \t]*from[ \t]+([\w.]+)[ \t]+import[ \t]+(\((?:[^)#]|#[^\n]*)*\)|[^\n]*)"
    r"|^[ \t]*import[ \t]+([\w., \t]+)",
    re.MULTILINE,
)
_COMMENT: Final = re.compile(r"#[^\n]*")
_IMPORTED: Final = re.compile(r"([\w.*]+)(?:[ \t]+as[ \t]+\w+)?")
_FILE_NAME: Final = re.compile(r"""["']([\w-]+\.[a-z]\w{1,4})["']""")


@dataclass(frozen=True)
class _Module:
    """What is known of one module.

    Attributes:
        content: A digest of its text and of its data files.
        data: The names of the files beside it that it names.
        imports: The modules of ours that it imports.
        libraries: The packages of others that it imports.
    """

    content: str
    data: tuple[str, ...]
    imports: frozenset[str]
    libraries: frozenset[str]


@cache
def code_digest(*roots: str, leaves: tuple[str, ...] = ()) -> str:
    """A digest of modules and of all that they import; the same on every machine.

    Files are read once in a process.

    Args:
        roots: Full names of modules.
        leaves: Modules whose own text counts, but nothing for their imports: those that list many
            alternatives of which the roots name the one that is used.

    Returns:
        64 hexadecimal digits.
    """
    known = [f"{name} {module.content if module else ''}" for name, module in _all(roots, leaves)]
    return hashlib.sha256("\n".join([__version__, *known]).encode()).hexdigest()


def modules(*roots: str, leaves: tuple[str, ...] = ()) -> tuple[str, ...]:
    """The modules that count for `code_digest`, sorted."""
    return tuple(name for name, _ in _all(roots, leaves))


@cache
def library_versions(*roots: str, leaves: tuple[str, ...] = ()) -> tuple[str, ...]:
    """The installed libraries of others that modules import, with their versions, sorted.

    Args:
        roots: As for `code_digest`.
        leaves: As for `code_digest`.
    """
    from importlib.metadata import PackageNotFoundError, version

    found = {name for _, module in _all(roots, leaves) if module for name in module.libraries}
    told = []
    for name in sorted(found - sys.stdlib_module_names):
        distribution = _DISTRIBUTIONS.get(name, name)
        try:
            told.append(f"{distribution} {version(distribution)}")
        except PackageNotFoundError:
            continue
    return tuple(told)


def _all(roots: tuple[str, ...], leaves: tuple[str, ...]) -> list[tuple[str, _Module | None]]:
    """The roots and all that they import, in the order of their names."""
    found: dict[str, _Module | None] = {}
    waiting = list(roots)
    while waiting:
        name = waiting.pop()
        if name not in found:
            found[name] = module = _module(name)
            waiting += module.imports if module and name not in leaves else ()
    return sorted(found.items(), key=lambda item: item[0])


@cache
def _module(name: str) -> _Module | None:
    """Read a module; None where it has no source."""
    path = _path(name)
    if path is None:
        return None
    source = _read(path) or b""
    text = source.decode("utf-8", "replace").replace("\\\n", " ")
    folder = path.rpartition("/")[0]
    # What looks for data says where it lies itself.
    named = set(_FILE_NAME.findall(text)) if "__file__" in text else ()
    beside = ((file, _read(f"{folder}/{file}")) for file in named)
    data = {file: content for file, content in beside if content is not None}
    content = hashlib.sha256(source)
    for file in sorted(data):
        content.update(f"\n{file} {hashlib.sha256(data[file]).hexdigest()}".encode())
    imported = set(_imports(text, _package(name, path)))
    ours = {other for other in imported if _is_followed(other, name)}
    others = frozenset(other.partition(".")[0] for other in imported - ours)
    return _Module(content.hexdigest(), tuple(sorted(data)), frozenset(ours), others)


def _package(name: str, path: str) -> str:
    """The package that relative imports of a module start from."""
    return name if path.endswith("/__init__.py") else name.rpartition(".")[0]


def _is_followed(other: str, importer: str) -> bool:
    return other.startswith(_OURS) or other.partition(".")[0] == importer.partition(".")[0]


def _imports(text: str, package: str) -> Iterator[str]:
    """The modules that a text imports."""
    for start, names, plain in _IMPORT.findall(text):
        if plain:
            yield from _IMPORTED.findall(plain)
        elif start:
            home = _absolute(start, package)
            for name in _IMPORTED.findall(_COMMENT.sub("", names)):
                # Either a module of a package, or what a module defines.
                inner = f"{home}.{name}"
                yield inner if _is_followed(home, package) and _path(inner) else home


def _absolute(start: str, package: str) -> str:
    inner = start.lstrip(".")
    up = len(start) - len(inner)
    if not up:
        return start
    parts = package.split(".")
    return ".".join([*parts[: len(parts) - up + 1], *filter(None, [inner])])


@cache
def _path(name: str) -> str | None:
    """Where a module lies, from the folder that its top package lies in; None: it has no source."""
    inner = name.replace(".", "/")
    package = name.rpartition(".")[0]
    if package and not (_path(package) or "").endswith("/__init__.py"):
        return None
    paths = (f"{inner}.py", f"{inner}/__init__.py")
    return next((path for path in paths if _read(path) is not None), None)


@cache
def _read(path: str) -> bytes | None:
    """A file of a package, with the line ends of Unix; None where there is none.

    Args:
        path: From the folder that the top package lies in. The module is not asked where it lies,
            because finding that out imports its packages.
    """
    spec = _spec(path.partition("/")[0].removesuffix(".py"))
    read = getattr(spec and spec.loader, "get_data", None)
    if spec is None or spec.origin is None or read is None:
        return None
    home = PurePath(spec.origin).parents[1 if spec.submodule_search_locations else 0]
    try:
        data = bytes(read(str(home / path)))
    except OSError:
        return None
    # As git does: what holds a zero byte is no text.
    return data if b"\0" in data else data.replace(b"\r\n", b"\n")


@cache
def _spec(top: str) -> ModuleSpec | None:
    try:
        return find_spec(top)
    except (ImportError, ValueError):
        return None
