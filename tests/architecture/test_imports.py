"""Who imports whom, read from the syntax trees: the arrows of ARCHITECTURE.md hold."""

import ast
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = {
    "openrooms_usd": ROOT / "openrooms_usd",
    "orusd_schemas": ROOT / "schemas/orusd_schemas",
    **{path.name: path for path in (ROOT / "converters").glob("orusd_*")},
}

# From the strongest to the weakest: a module imports its own rank and those after it.
RANKS = (
    ("cli",),
    ("api",),
    (
        "appearance",
        "comparison",
        "composing",
        "dataset",
        "doctor",
        "rules",
        "validation",
        "package",
        "view",
        "edits",
        "loading",
        "steps",
        "rendering",
        "exporters",
        "engines",
        "simulation",
        "showroom",
        "importing",
        "demo",
    ),
    ("generation",),
    ("library",),
    ("usd",),
    (
        "description",
        "building",
        "geometry",
        "adapters",
        "atomic",
        "capture",
        "channels",
        "claims",
        "codedigest",
        "draws",
        "furniture",
        "isolation",
        "ledger",
        "physics",
        "progress",
        "removal",
        "scan",
        "sourcetext",
        "threads",
        "unfinished",
        "usercache",
        "unpickling",
    ),
    (
        "arrays",
        "colorimetry",
        "errors",
        "hdf5",
        "imagefile",
        "lazy",
        "lettering",
        "names",
        "portable",
        "processes",
        "scratch",
        "spelling",
        "tables",
        "untrusted",
        "urls",
        "version",
    ),
)
RANK = {name: rank for rank, names in enumerate(RANKS) for name in names}
# The arrows between neighbours of one rank, and those that skip what they must not see.
LEAVES = {"description", "geometry"}
FOR_CONVERTERS = {
    "appearance",
    "furniture",
    # Importers of finished scenes read models, and know what stands for those that are missing.
    "library",
    "usd",
    "geometry",
    "physics",
    "scan",
    "channels",
    "capture",
    "rendering",
    "exporters",
    "engines",
    "arrays",
    "colorimetry",
    "errors",
    "names",
    "atomic",
    "claims",
    "hdf5",
    "imagefile",
    "isolation",
    "ledger",
    "loading",
    "portable",
    "progress",
    "scratch",
    "spelling",
    "unpickling",
    "untrusted",
    "urls",
    "package",
}
HEAVY = {"pxr", "mitsuba", "drjit", "trimesh", "scipy", "shapely", "OpenImageIO", "embreex"}
# Imported by `orusd --help`; numpy is in because the description and the command line need none.
INSTANT = ("api", "cli", "description", "errors", "names", "adapters", "atomic")


class Import(NamedTuple):
    path: Path
    line: int
    module: str
    top: bool  # at module level and not for type checkers alone

    def __str__(self) -> str:
        return f"{self.path.relative_to(ROOT)}:{self.line} imports {self.module}"


def imports(path: Path) -> Iterator[Import]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    yield from _imports(path, tree.body, True)


def _imports(path: Path, body: list[ast.stmt], top: bool) -> Iterator[Import]:
    for node in body:
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield Import(path, node.lineno, alias.name, top)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: relative import"
            for alias in node.names:
                yield Import(path, node.lineno, f"{node.module}.{alias.name}", top)
        else:
            inner = [child for child in ast.iter_child_nodes(node) if isinstance(child, ast.stmt)]
            handlers = [h for h in ast.iter_child_nodes(node) if isinstance(h, ast.ExceptHandler)]
            inner += [statement for handler in handlers for statement in handler.body]
            runs = not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
            typing = isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
            yield from _imports(path, inner, top and runs and not typing)


ALL = [
    found
    for source in SOURCES.values()
    for path in sorted(source.rglob("*.py"))
    for found in imports(path)
]


def part(found: Import) -> str:
    """The part of the core that a module belongs to: its name below openrooms_usd."""
    inner = found.path.relative_to(SOURCES["openrooms_usd"])
    return inner.parts[0].removesuffix(".py")


def target(found: Import) -> str | None:
    """The part of the core that is imported; None for another package."""
    words = found.module.split(".")
    if words[0] != "openrooms_usd" or len(words) < 2:
        return None
    return words[1] if words[1] in RANK else None


def of(root: str) -> list[Import]:
    return [found for found in ALL if found.path.is_relative_to(SOURCES[root])]


def test_every_part_of_the_core_has_a_rank() -> None:
    parts = {path.stem for path in SOURCES["openrooms_usd"].glob("*.py")} | {
        path.name for path in SOURCES["openrooms_usd"].iterdir() if (path / "__init__.py").is_file()
    }
    assert parts - {"__init__"} == set(RANK)


def test_the_core_imports_downwards() -> None:
    wrong = [
        str(found)
        for found in of("openrooms_usd")
        if (to := target(found)) and part(found) in RANK and RANK[to] < RANK[part(found)]
    ]
    assert wrong == []


def test_leaves_import_only_the_lowest_rank() -> None:
    wrong = [
        str(found)
        for found in of("openrooms_usd")
        if part(found) in LEAVES and (to := target(found)) and to not in {part(found), *RANKS[-1]}
    ]
    assert wrong == []


def test_the_command_line_is_imported_by_nothing() -> None:
    wrong = [str(f) for f in ALL if target(f) == "cli" and part_or_none(f) != "cli"]
    assert wrong == []


def part_or_none(found: Import) -> str | None:
    return part(found) if found.path.is_relative_to(SOURCES["openrooms_usd"]) else None


def test_the_core_imports_no_converter() -> None:
    others = set(SOURCES) - {"openrooms_usd"}
    # The schemas may be registered by the core; they import nothing but pxr.
    wrong = [
        str(f) for f in of("openrooms_usd") if f.module.split(".")[0] in others - {"orusd_schemas"}
    ]
    assert wrong == []


@pytest.mark.parametrize("converter", sorted(set(SOURCES) - {"openrooms_usd", "orusd_schemas"}))
def test_a_converter_imports_only_the_core_below_it(converter: str) -> None:
    others = set(SOURCES) - {converter, "openrooms_usd"}
    for found in of(converter):
        assert found.module.split(".")[0] not in others, str(found)
        to = target(found)
        assert to is None or to in FOR_CONVERTERS, str(found)


def test_the_schemas_import_only_pxr() -> None:
    foreign = {f.module.split(".")[0] for f in of("orusd_schemas")} - set(sys.stdlib_module_names)
    assert foreign == {"pxr"}


def test_heavy_packages_are_not_imported_at_start() -> None:
    wrong = [
        str(found)
        for found in of("openrooms_usd")
        if found.top and part(found) in INSTANT and found.module.split(".")[0] in HEAVY
    ]
    assert wrong == []


def rings(arrows: dict[str, set[str]]) -> list[list[str]]:
    """The groups of names that lead to each other along the arrows."""

    def reached(start: str) -> set[str]:
        found: set[str] = set()
        waiting = list(arrows[start])
        while waiting:
            if (name := waiting.pop()) not in found:
                found.add(name)
                waiting += arrows.get(name, ())
        return found

    ways = {name: reached(name) for name in arrows}
    in_ring = {name for name in arrows if name in ways[name]}
    groups = {tuple(sorted(n for n in in_ring if n in ways[m] and m in ways[n])) for m in in_ring}
    return sorted(map(list, groups))


MODULES = {
    ".".join((root, *path.relative_to(source).with_suffix("").parts)): path
    for root, source in SOURCES.items()
    for path in source.rglob("*.py")
}


def module_of(name: str) -> str | None:
    """The module of ours that a name is, or that of the package that it stands for."""
    return next((m for m in (name, f"{name}.__init__") if m in MODULES), None)


@cache
def arrows() -> dict[str, set[str]]:
    """Which module imports which, inside functions and for type checkers too."""
    named = {path: module for module, path in MODULES.items()}
    found: dict[str, set[str]] = {module: set() for module in MODULES}
    for one in ALL:
        if target := module_of(one.module) or module_of(one.module.rpartition(".")[0]):
            found[named[one.path]].add(target)
    return found


PACKAGES = sorted({m.removesuffix(".__init__") for m in MODULES if m.endswith(".__init__")})


@pytest.mark.parametrize("package", PACKAGES)
def test_no_circle_between_the_parts_of_a_package(package: str) -> None:
    """Modules and chapters of one folder: none leads back to itself."""
    below = f"{package}."

    def part_of(module: str) -> str | None:
        inner = module.removeprefix(below)
        return inner.partition(".")[0] if inner != module else None

    between: dict[str, set[str]] = {}
    for module, targets in arrows().items():
        if source := part_of(module):
            parts = {other for t in targets if (other := part_of(t)) and other != source}
            between.setdefault(source, set()).update(parts)
    assert rings(between) == []


def test_rings_are_found() -> None:
    assert rings({"a": {"b"}, "b": {"c"}, "c": {"a", "d"}, "d": set()}) == [["a", "b", "c"]]
    assert rings({"a": {"b"}, "b": set()}) == []


def test_geometry_knows_no_usd_and_no_renderer() -> None:
    banned = {"pxr", "mitsuba", "drjit"}
    wrong = [
        str(f)
        for f in of("openrooms_usd")
        if part(f) == "geometry" and f.module.split(".")[0] in banned
    ]
    assert wrong == []


def test_what_reads_untrusted_bytes_as_code_is_not_used() -> None:
    banned = {"pickle", "shelve", "marshal", "dill", "joblib"}
    # Its machine, with few of its instructions: what may be called there is forbidden below.
    machine = {"openrooms_usd/unpickling/__init__.py"}
    users = {found.path for found in ALL if found.module.split(".")[0] in banned}
    assert {path.relative_to(ROOT).as_posix() for path in users} == machine
    calls = {"eval", "exec", "yaml.load", "yaml.unsafe_load", "yaml.full_load"}
    calls |= {"pickle.load", "pickle.loads", "pickle.Unpickler", "pickle._Unpickler"}
    for source in SOURCES.values():
        for path in source.rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            if not any(f"{call}(" in text for call in calls):
                continue
            for node in ast.walk(ast.parse(text)):
                if isinstance(node, ast.Call):
                    assert ast.unparse(node.func) not in calls, f"{path}:{node.lineno}"
