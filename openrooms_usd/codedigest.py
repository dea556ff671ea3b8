"""A digest of the code that makes something: modules, and all that they import.

Layers, assets and cached results are kept as long as what determines them is the same, and code
determines them as much as any input does. A digest covers the syntax trees of modules of ours, of
those that they import, also inside functions, and the data files beside a module that it names.

What does not count:

- comments, docstrings, and how the text is laid out;
- packages that a dotted name only passes through, and imports for type checkers alone;
- modules imported by a computed name. What imports them calls `count`, and `counting` gathers what
  was called for while something was made;
- libraries of others. A layer carries its digest, and the same description gives the same bytes
  whatever is installed beside us. Caches, which stay on their machine, add `library_versions`.

Where a package has no source (bytecode alone), its version stands for it.
"""

import hashlib
import pkgutil
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache, wraps
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from pathlib import PurePath
from typing import Any, Final, TypeVar

from openrooms_usd.sourcetext import Text, Texts
from openrooms_usd.version import __version__

_T = TypeVar("_T")
_texts: Final = cache(Texts)

# What is followed wherever it is imported: the core, its schemas and its converters.
_OURS: Final = ("openrooms_usd", "orusd_")
# The distributions that are not called as what they install.
_DISTRIBUTIONS: Final = {"pxr": "usd-core", "yaml": "PyYAML"}

_counted: ContextVar[tuple[set[str], ...]] = ContextVar("counted", default=())


@contextmanager
def counting() -> Iterator[set[str]]:
    """Gather the names of modules that `count` is called with while the block runs.

    Threads take part that run in the context of the block, as `threads.mapped` has them.
    """
    found: set[str] = set()
    token = _counted.set((*_counted.get(), found))
    try:
        yield found
    finally:
        _counted.reset(token)


def count(module: str) -> None:
    """Say that what is being made depends on a module that no import names.

    Args:
        module: Its full name, whether or not there is such a module; ``package.*`` for all modules
            of a package.
    """
    for found in _counted.get():
        found.add(module)


def remembered(function: Callable[..., _T]) -> Callable[..., _T]:
    """`functools.cache` for what calls `count`: what it once counted counts at every call."""
    known: dict[tuple[Any, ...], tuple[_T, frozenset[str]]] = {}

    @wraps(function)
    def call(*arguments: Any) -> _T:
        if arguments not in known:
            with counting() as found:
                value = function(*arguments)
            known[arguments] = value, frozenset(found)
        value, modules = known[arguments]
        for module in modules:
            count(module)
        return value

    return call


@dataclass(frozen=True)
class _Module:
    """What is known of one module.

    Attributes:
        content: A digest of its syntax tree and of its data files.
        data: The names of the files beside it that it names.
        imports: The modules of ours that it imports.
        libraries: The packages of others that it imports.
    """

    content: str
    data: tuple[str, ...]
    imports: frozenset[str]
    libraries: frozenset[str]


@cache
def code_digest(*roots: str, leaves: tuple[str, ...] = (), apart: tuple[str, ...] = ()) -> str:
    """A digest of modules and of all that they import; the same on every machine.

    Files are read once in a process.

    Args:
        roots: Full names of modules; ``package.*`` for all modules of a package.
        leaves: Modules whose own code counts, but nothing for their imports: those that list many
            alternatives of which the roots name the one that is used.
        apart: Modules that do not count, nor what they alone import.

    Returns:
        64 hexadecimal digits.
    """
    found = _all(roots, leaves, apart)
    known = [f"{name} {module.content if module else ''}" for name, module in found]
    return hashlib.sha256("\n".join([__version__, *known]).encode()).hexdigest()


def modules(
    *roots: str, leaves: tuple[str, ...] = (), apart: tuple[str, ...] = ()
) -> tuple[str, ...]:
    """The modules that count for `code_digest`, sorted."""
    return tuple(name for name, _ in _all(roots, leaves, apart))


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


def _all(
    roots: tuple[str, ...], leaves: tuple[str, ...], apart: tuple[str, ...] = ()
) -> list[tuple[str, _Module | None]]:
    """The roots and all that they import, in the order of their names."""
    found: dict[str, _Module | None] = {}
    waiting = [name for root in roots for name in _expanded(root)]
    while waiting:
        name = waiting.pop()
        if name not in found and name not in apart:
            found[name] = module = _module(name)
            waiting += module.imports if module and name not in leaves else ()
    _texts().save()
    return sorted(found.items(), key=lambda item: item[0])


def _expanded(root: str) -> Iterable[str]:
    """The modules that a root names."""
    package, star, _ = root.partition(".*")
    if not star:
        return (root,)
    home = _home(package.partition(".")[0])
    folder = str(home / package.replace(".", "/")) if home else ""
    return sorted(f"{package}.{one.name}" for one in pkgutil.iter_modules([folder]))


@cache
def _module(name: str) -> _Module | None:
    """Read a module; None where it has no source."""
    path = _path(name)
    if path is None:
        return None
    text = _texts().of(_read(path) or b"")
    folder = path.rpartition("/")[0]
    beside = ((file, _read(f"{folder}/{file}")) for file in text.files)
    data = {file: content for file, content in beside if content is not None}
    content = hashlib.sha256(text.digest.encode())
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


def _imports(text: Text, package: str) -> Iterator[str]:
    """The modules that a text imports."""
    for start, names in text.imports:
        home = _absolute(start, package)
        if not names:
            yield home
        for name in names:
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
    top = path.partition("/")[0].removesuffix(".py")
    home, read = _home(top), getattr(getattr(_spec(top), "loader", None), "get_data", None)
    if home is None or read is None:
        return None
    try:
        data = bytes(read(str(home / path)))
    except OSError:
        return None
    # As in git: a file with a zero byte is not text.
    return data if b"\0" in data else data.replace(b"\r\n", b"\n")


def _home(top: str) -> PurePath | None:
    """The folder that a top package lies in; None: it has no source."""
    spec = _spec(top)
    if spec is None or spec.origin is None:
        return None
    return PurePath(spec.origin).parents[1 if spec.submodule_search_locations else 0]


@cache
def _spec(top: str) -> ModuleSpec | None:
    try:
        return find_spec(top)
    except (ImportError, ValueError):
        return None
