"""Habits that a look at the files can check."""

import ast
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = ("openrooms_usd", "schemas", "converters")
LONGEST = 400  # lines of a module
TEXT = {".json", ".md", ".py", ".toml", ".usda"}
GENERATED = {"generatedSchema.usda"}
BINARY = {".exr", ".png", ".usdc", ".usdz", ".glb", ".jpg", ".hdr"}


def tracked() -> list[Path]:
    """The files that belong to the repository, also those that are not committed yet."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    try:
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("not a git checkout")
    return [ROOT / line for line in done.stdout.splitlines() if (ROOT / line).is_file()]


def modules() -> list[Path]:
    return [path for source in SOURCES for path in sorted((ROOT / source).rglob("*.py"))]


def test_no_file_names_a_place_on_one_machine() -> None:
    home = re.compile(rb"/(?:home|Users|root|work|mnt|scratch)/[\w.-]+|[A-Z]:\\\\?Users\\")
    found = [
        f"{path.relative_to(ROOT)}: {match.group().decode()}"
        for path in tracked()
        if path.suffix not in BINARY and path != Path(__file__)
        for match in home.finditer(path.read_bytes())
    ]
    assert found == []


def test_no_module_is_too_long() -> None:
    lengths = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in modules()}
    assert {str(path): n for path, n in lengths.items() if n > LONGEST} == {}


def test_every_module_says_what_it_is() -> None:
    silent = [
        str(path.relative_to(ROOT))
        for path in modules()
        if not ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
    ]
    assert silent == []


def test_text_files_end_with_one_newline_and_have_unix_line_ends() -> None:
    wrong = []
    for path in tracked():
        read = path.suffix in TEXT and path.name not in GENERATED
        data = path.read_bytes() if read else b""
        if data and (b"\r" in data or not data.endswith(b"\n") or data.endswith(b"\n\n")):
            wrong.append(str(path.relative_to(ROOT)))
    assert wrong == []


def test_no_large_file_is_tracked() -> None:
    large = {str(p.relative_to(ROOT)): p.stat().st_size for p in tracked()}
    assert {name: size for name, size in large.items() if size > 2_000_000} == {}


def chapters() -> list[Path]:
    """Packages of several modules; the core itself is mapped by ARCHITECTURE.md.

    The command line has a table of its commands, and furniture one module a category.
    """
    without = {"openrooms_usd", "openrooms_usd/cli", "openrooms_usd/furniture/categories"}
    return [
        path.parent
        for path in modules()
        if path.name == "__init__.py"
        and len(list(path.parent.glob("*.py"))) > 3
        and path.parent.relative_to(ROOT).as_posix() not in without
    ]


@pytest.mark.parametrize("chapter", chapters(), ids=lambda path: path.name)
def test_the_map_of_a_chapter_names_all_that_is_in_it(chapter: Path) -> None:
    text = ast.get_docstring(ast.parse((chapter / "__init__.py").read_text(encoding="utf-8")))
    named = set(re.findall(r"\w+", text or ""))
    inside = {path.stem for path in chapter.glob("*.py")} - {"__init__", "__main__"}
    inside |= {path.parent.name for path in chapter.glob("*/__init__.py")}
    assert inside - named == set()
