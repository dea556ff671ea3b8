"""What a stranger sees of the package: names, help, completion, and what they cost."""

import inspect
import json
import re
import rlcompleter
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import openrooms_usd as ou

ASKED = {
    "bake",
    "compose",
    "convert",
    "find_appearance",
    "generate",
    "import_capture",
    "load_room",
    "new_room",
    "open_scene",
    "probe",
    "relight",
    "render",
    "run_dataset",
    "simulate",
    "write_dataset",
}
FUNCTIONS = [name for name in dir(ou) if inspect.isfunction(getattr(ou, name))]


def loaded(code: str) -> set[str]:
    """The packages that a process has loaded after running some code."""
    script = f"import json, sys\n{code}\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    return {name.split(".")[0] for name in json.loads(done.stdout.splitlines()[-1])}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_paths_are_text_as_well(name: str) -> None:
    """No argument takes a Path alone; what texts become is `openrooms_usd.api.given`'s."""
    wanted = {
        argument.name: {str(one) for one in re.findall(r"\w+", str(argument.annotation))}
        for argument in inspect.signature(getattr(ou, name)).parameters.values()
    }
    narrow = [
        argument for argument, words in wanted.items() if "Path" in words and "str" not in words
    ]
    assert not narrow


def test_dir_and_completion_show_it() -> None:
    assert set(FUNCTIONS) >= ASKED
    completer = rlcompleter.Completer({"ou": ou})
    offered = completer.attr_matches("ou.rend")
    assert offered == ["ou.render(", "ou.render_path("]
    assert set(dir(ou.robots)) >= {"rover", "RobotCameras", "load_world"}
    assert all(getattr(ou.robots, name) is not None for name in dir(ou.robots))


def test_completion_loads_nothing_heavy() -> None:
    code = "import openrooms_usd as ou\nfor name in dir(ou): getattr(ou, name)\ndir(ou.robots)"
    assert loaded(code) & {"pxr", "numpy", "scipy", "mitsuba", "shapely", "trimesh"} == set()


@pytest.mark.one_in(9)
@pytest.mark.parametrize(
    "first",
    [
        "import openrooms_usd.rendering.driver, openrooms_usd.composing, openrooms_usd.generation",
        "from openrooms_usd.rendering import render_stage\nimport openrooms_usd.engines",
        "ou.render, ou.compose, ou.generate, ou.convert, ou.validate, ou.simulate",
    ],
)
def test_a_function_is_not_hidden_by_the_module_of_its_name(first: str) -> None:
    code = (
        f"import openrooms_usd as ou\n{first}\n"
        "import openrooms_usd.rendering, openrooms_usd.composing, openrooms_usd.exporters\n"
        "assert all(callable(getattr(ou, name)) for name in dir(ou)"
        " if name not in ('__version__', 'robots'))\n"
        "from openrooms_usd.rendering.contract import View"
    )
    assert "pxr" not in loaded("import openrooms_usd") and loaded(code)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_explains_itself(name: str) -> None:
    function = getattr(ou, name)
    text = inspect.getdoc(function) or ""
    for parameter in inspect.signature(function).parameters.values():
        assert f"    {parameter.name}: " in text, parameter.name
        assert parameter.annotation is not inspect.Parameter.empty
    assert "Raises:" in text
    assert inspect.signature(function).return_annotation is not inspect.Signature.empty


@pytest.mark.parametrize("name", FUNCTIONS)
def test_what_takes_long_tells_its_progress_in_one_way(name: str) -> None:
    parameters = inspect.signature(getattr(ou, name)).parameters
    takes_long = name in {
        "bake",
        "compare",
        "compose",
        "find_appearance",
        "probe",
        "render",
        "render_path",
        "run_dataset",
        "simulate",
        "write_dataset",
    }
    assert ("progress" in parameters) == takes_long
    if takes_long:
        assert str(parameters["progress"].annotation).endswith("[[str, float], None]")


@pytest.mark.slow
def test_a_type_checker_sees_the_signatures(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    (tmp_path / "user.py").write_text(USER)
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--no-incremental", "--follow-imports=silent", "user.py"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    said = [line for line in done.stdout.splitlines() if ": error: " in line]
    assert len(said) == 4, done.stdout + done.stderr
    assert 'Module has no attribute "rendr"' in said[0]
    assert '"samples" to "RenderSettings" has incompatible type "str"' in said[1]
    assert 'Unexpected keyword argument "sample"' in said[2]
    assert "RoomType" in said[3] or "Literal" in said[3]


USER = """\
import openrooms_usd as ou

scene: ou.Scene = ou.compose({"room": "office"}, "out")
ou.rendr
ou.RenderSettings(samples="4")
ou.RenderSettings(sample=4)
ou.render(scene, samples=4)
ou.generate("livingroom")
depth = ou.render(scene)["left"]["depth"]
depth.mean()
"""


def test_help_is_of_the_function(capsys: pytest.CaptureFixture[str]) -> None:
    help(ou.render)
    said: Any = capsys.readouterr().out
    assert said.startswith("Help on function render in module openrooms_usd.api.renders:")
    assert "cameras: " in said
