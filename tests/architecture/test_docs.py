"""What the documents show is true: commands run, YAML loads, links lead somewhere."""

import ast
import inspect
import os
import re
import shlex
import subprocess
import sys
from operator import attrgetter
from pathlib import Path
from typing import NamedTuple

import pytest
import yaml

from docs import api, reference_pages

ROOT = Path(__file__).parents[2]
DOCUMENTS = [
    *(ROOT / name for name in ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md")),
    *sorted((ROOT / "docs").rglob("*.md")),
]
FENCE = re.compile(r"^( *)```(\w*)[^\n]*\n(.*?)^\1```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\((?!https?:|mailto:|#)([^)#\s]+)")


class Block(NamedTuple):
    document: Path
    line: int
    language: str
    text: str

    def __str__(self) -> str:
        return f"{self.document.name}-{self.line}"


BLOCKS = [
    Block(path, text.count("\n", 0, match.start()) + 1, match[2], match[3])
    for path in DOCUMENTS
    if path.is_file()
    for text in [path.read_text(encoding="utf-8")]
    for match in FENCE.finditer(text)
]


def python_of(document: Path) -> str:
    """What a document shows of Python, block after block, each where it stands in the file."""
    text = ""
    for block in BLOCKS:
        if block.document == document and block.language == "python":
            text += "\n" * (block.line - text.count("\n")) + block.text
    return text


PYTHON = [
    d
    for d in DOCUMENTS
    if d.is_file() and d.parent.name != "tutorials" and "import openrooms_usd as ou" in python_of(d)
]


def commands(block: Block) -> list[str]:
    """The commands of a block: all lines of ``bash``, those after ``$`` of ``console``."""
    lines = block.text.replace("\\\n", " ").splitlines()
    if block.language == "console":
        lines = [line.strip()[2:] for line in lines if line.strip().startswith("$ ")]
    return [line.split(" #")[0].strip() for line in lines if line.split("#")[0].strip()]


def runnable(document: Path) -> list[str]:
    """What a reader would type; ``make`` and tutorials are checked elsewhere."""
    if document.parent.name == "tutorials":
        return []
    blocks = [b for b in BLOCKS if b.document == document and b.language == "console"]
    return [c for block in blocks for c in commands(block) if shlex.split(c)[0] != "make"]


@pytest.mark.slow
@pytest.mark.parametrize(
    "document", [d for d in DOCUMENTS if d.is_file() and runnable(d)], ids=lambda path: path.name
)
def test_the_commands_of_a_document_run_in_order(document: Path, tmp_path: Path) -> None:
    """Each in the same empty folder, with this environment's ``orusd`` first on the path."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for command in runnable(document):
        done = subprocess.run(
            ["bash", "-c", command],
            cwd=tmp_path,
            env={**os.environ, "PATH": path},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, f"$ {command}\n{done.stdout}{done.stderr}"
        assert "` is called `" not in done.stderr, f"a former name: {command}\n{done.stderr}"


@pytest.mark.slow
@pytest.mark.parametrize("document", PYTHON, ids=lambda path: path.name)
def test_the_python_of_a_document_runs_in_order(document: Path, tmp_path: Path) -> None:
    """All blocks in one process, in an empty folder; what warns fails."""
    script = tmp_path / "document.py"
    script.write_text(python_of(document), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-W", "error", script], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("document", PYTHON, ids=lambda path: path.name)
def test_the_python_of_a_document_calls_what_there_is(document: Path) -> None:
    """Every function of the front door exists and takes the arguments that are shown."""
    import openrooms_usd as ou

    for node in ast.walk(ast.parse(python_of(document))):
        if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "ou":
            assert node.attr in dir(ou)
        if isinstance(node, ast.Call) and ast.unparse(node.func).startswith("ou."):
            function = attrgetter(ast.unparse(node.func).removeprefix("ou."))(ou)
            keywords = {word.arg: word.value for word in node.keywords if word.arg}
            inspect.signature(function).bind(*node.args, **keywords)


def test_make_is_only_asked_for_targets_that_exist() -> None:
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    words = [
        shlex.split(command)
        for block in BLOCKS
        if block.language in ("console", "bash")
        for command in commands(block)
    ]
    asked = {word for line in words if line[0] == "make" for word in line[1:] if "=" not in word}
    assert asked <= targets
    assert {"demo", "test"} <= asked


@pytest.mark.parametrize("block", [b for b in BLOCKS if b.language in ("yaml", "yml")], ids=str)
def test_yaml_loads_as_a_room_or_a_part_of_one_or_as_a_dataset(
    block: Block, tmp_path: Path
) -> None:
    from openrooms_usd.description import load_dataset, load_room
    from openrooms_usd.description.room import Room

    data = yaml.safe_load(block.text)
    assert isinstance(data, dict)
    if "rooms" in data:
        (tmp_path / "dataset.yaml").write_text(block.text, encoding="utf-8")
        load_dataset(tmp_path / "dataset.yaml")
        return
    assert set(data) <= {field.alias or name for name, field in Room.model_fields.items()}
    (tmp_path / "room.yaml").write_text(block.text, encoding="utf-8")
    load_room(tmp_path / "room.yaml")


@pytest.mark.parametrize("document", [d for d in DOCUMENTS if d.is_file()], ids=lambda p: p.name)
def test_links_lead_to_files(document: Path) -> None:
    text = FENCE.sub("", document.read_text(encoding="utf-8"))
    assert [link for link in LINK.findall(text) if not (document.parent / link).exists()] == []


def test_the_chapters_that_the_architecture_names_exist() -> None:
    """Every path between backticks lies below the core or the checkout."""
    text = FENCE.sub("", (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8"))
    named = {path for path in re.findall(r"`([\w/.]+?)/?`", text) if "/" in path or ".py" in path}
    named |= set(re.findall(r"`([a-z]+)/`", text))
    named = {path for path in named if not path.startswith("/") and path != "edits.usda"}
    assert len(named) > 30
    missing = [
        path
        for path in sorted(named)
        if not any((base / path).exists() for base in (ROOT, ROOT / "openrooms_usd"))
    ]
    assert missing == []


def test_the_architecture_names_every_chapter() -> None:
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    chapters = {p.parent.name for p in (ROOT / "openrooms_usd").glob("*/__init__.py")}
    assert {name for name in chapters if f"`{name}/`" not in text} == set()


def test_the_reference_of_python_says_what_the_docstrings_say() -> None:
    assert api.PAGE.read_text(encoding="utf-8") == api.page(), "run: python -m docs.api"


@pytest.mark.parametrize("name", reference_pages.PAGES)
def test_the_reference_says_what_commands_models_and_errors_say(name: str) -> None:
    shown = (reference_pages.FOLDER / name).read_text(encoding="utf-8")
    assert shown == reference_pages.PAGES[name](), "run: python -m docs.reference_pages"
