"""What may have been meant by a name that is none, wherever one is asked for."""

from collections.abc import Callable
from pathlib import Path

import pytest

import openrooms_usd as ou
from openrooms_usd.errors import OrusdError
from openrooms_usd.spelling import did_you_mean, nearest
from tests.commands import run

ROOT = Path(ou.__file__).parent


@pytest.mark.parametrize(
    ("word", "meant"),
    [("chiar", "chair"), ("Bed", "bed"), ("coffee-table", "coffee_table"), ("bike", "bicycle")],
)
def test_the_nearest_name_is_found(word: str, meant: str) -> None:
    known = ["bed", "bicycle", "binder", "chair", "coffee_table"]
    assert nearest(word, known, {"bike": "bicycle"}) == meant
    assert did_you_mean(word, known, {"bike": "bicycle"}) == f" (did you mean {meant!r}?)"
    assert did_you_mean("quux", known) == did_you_mean(3, known) == ""


def of_a_room(**row: object) -> Callable[[], object]:
    return lambda: ou.load_room({"furniture": {"objects": [{"at": [1, 1], **row}]}})


@pytest.mark.parametrize(
    ("ask", "meant"),
    [
        (lambda: ou.generate("bedrom"), "bedroom"),
        (lambda: ou.generate("bedroom", style="industral"), "industrial"),
        (of_a_room(category="bike"), "bicycle"),
        (of_a_room(category="chair", yow=3), "yaw"),
        (lambda: ou.load_room({"lihgts": {}}), "lights"),
        (lambda: ou.RenderSettings(sampels=3), "samples"),
        (lambda: ou.compose({}, "x", only="layuot"), "layout"),
        (lambda: ou.convert("x", "y", to="mitsubba"), "mitsuba"),
        (lambda: ou.simulate("x", engine="mujocco"), "mujoco"),
    ],
)
def test_python_says_what_may_have_been_meant(
    ask: Callable[[], object], meant: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(OrusdError) as refused:
        ask()
    assert f"did you mean {meant!r}?" in str(refused.value)


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        ("rendr", "render"),
        ("dataset wirte", "write"),
        ("library lst", "list"),
        ("edit import-change", "import-changes"),
        ("import roomplam x -o y", "roomplan"),
        ("generate --type bedrom -o x", "bedroom"),
        ("compose x -o y --only layuot", "layout"),
        ("render x --rendrer y", "--renderer"),
    ],
)
def test_the_command_line_says_what_may_have_been_meant(words: str, meant: str) -> None:
    done = run(*words.split())
    assert done.exit_code != 0 and f"id you mean {meant!r}?" in f"{done.output} {done.exception}"


def test_one_function_guesses() -> None:
    guessing = [path for path in ROOT.rglob("*.py") if "difflib" in path.read_text("utf-8")]
    assert guessing == [ROOT / "spelling.py"]
