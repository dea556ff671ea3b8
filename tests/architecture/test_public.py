"""The public names, and what a process pays before it does anything."""

import ast
import json
import subprocess
import sys
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path

import pytest

import openrooms_usd
from openrooms_usd import adapters, cli

ROOT = Path(__file__).parents[2]
HEAVY = set("pxr mitsuba drjit numpy scipy shapely trimesh OpenImageIO pydantic yaml rich".split())


def test_all_names_the_facade_and_nothing_else() -> None:
    assert openrooms_usd.__all__ == sorted(openrooms_usd.__all__)
    assert set(openrooms_usd.__all__) == {*openrooms_usd._HOME, "__version__"}


@pytest.mark.parametrize("name", sorted(openrooms_usd._HOME))
def test_a_public_name_is_what_its_module_defines(name: str) -> None:
    assert getattr(openrooms_usd, name) is getattr(import_module(openrooms_usd._HOME[name]), name)


def test_type_checkers_see_what_runs() -> None:
    """The imports under TYPE_CHECKING name the same modules as the table of the façade."""
    tree = ast.parse(Path(openrooms_usd.__file__).read_text(encoding="utf-8"))
    conditions = [node for node in tree.body if isinstance(node, ast.If)]
    (block,) = (node for node in conditions if ast.unparse(node.test) == "TYPE_CHECKING")
    seen = {
        alias.name: node.module
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert seen == openrooms_usd._HOME


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="nonsense"):
        openrooms_usd.nonsense  # noqa: B018


@pytest.mark.parametrize(
    "code",
    [
        "import openrooms_usd",
        "import openrooms_usd.cli",
        "from click.testing import CliRunner; from openrooms_usd.cli import orusd\n"
        "assert CliRunner().invoke(orusd, ['--help']).exit_code == 0",
    ],
)
def test_starting_loads_nothing_heavy(code: str) -> None:
    """Which modules are loaded is what start-up costs, and it is the same on every machine."""
    script = f"import json, sys\n{code}\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    loaded = {name.split(".")[0] for name in json.loads(done.stdout)}
    assert loaded & HEAVY == set()


@pytest.mark.parametrize("name", cli.orusd.list_commands(None))  # type: ignore[arg-type]
def test_a_command_exists_and_explains_itself(name: str) -> None:
    command = cli.orusd.get_command(None, name)  # type: ignore[arg-type]
    assert command is not None and command.help


@pytest.mark.parametrize(
    "group", [adapters.IMPORTERS, adapters.RENDERERS, adapters.EXPORTERS, adapters.DATASETS]
)
def test_an_adapter_of_ours_is_found_and_loads(group: str) -> None:
    ours = [point for point in entry_points(group=group) if point.value.startswith("orusd_")]
    assert ours
    for point in ours:
        assert adapters.load(group, point.name)
