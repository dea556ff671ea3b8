"""What all commands have alike: three options, help with an example, names of before."""

import json
import re
import shlex
import shutil
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from openrooms_usd import cli
from openrooms_usd.cli import bar, console, main, orusd
from openrooms_usd.cli.command import Command
from openrooms_usd.progress import Counted
from tests.commands import output_of, run

ROOT = Path(__file__).parents[2]
SHARED = {"quiet": ["-q", "--quiet"], "verbose": ["-v", "--verbose"], "json": ["--json"]}


def walk(command: click.Command, *path: str) -> Iterator[tuple[tuple[str, ...], Command]]:
    """A command and all below it, with the words that lead there."""
    assert isinstance(command, Command), path
    yield path, command
    if isinstance(command, click.Group):
        context = click.Context(command)
        for name in command.list_commands(context):
            below = command.get_command(context, name)
            assert below is not None
            yield from walk(below, *path, name)


ALL = dict(walk(orusd))
LEAVES = {path: one for path, one in ALL.items() if not isinstance(one, click.Group)}
# What needs nothing but itself.
CHEAP = [
    ("init",),
    ("schema",),
    ("completion",),
    ("channels",),
    ("library", "list"),
    ("materials", "list"),
]
FORMER = [
    (path, old, new("1:5") if callable(new) else new)
    for path, one in ALL.items()
    for old, new in one.former.items()
    if old.startswith("-")
]


def parsed(path: tuple[str, ...], words: list[str]) -> click.Context:
    """The context of a command that has read its words."""
    return LEAVES[path].make_context(path[-1], words, parent=click.Context(orusd))


@pytest.mark.parametrize("path", ALL, ids=" ".join)
def test_every_command_takes_the_three_options(path: tuple[str, ...]) -> None:
    flags = {one.name: one.opts for one in ALL[path].params if one.name in SHARED}
    assert flags == SHARED
    said = output_of(*path, "--help")
    shared = said.partition("Global options:\n")[2]
    assert all(flag in shared for names in SHARED.values() for flag in names)
    assert set(re.findall(r"^(\w[\w ']*):$", said, re.M)) <= {
        *("Commands", "Options", "Global options", "Example", "Exit codes"),
        *("Getting started", "Rooms", "Rendering and light"),
        *("Viewing and export", "Libraries and formats"),
        *(
            "Light",
            "Quality",
            "Camera",
            "Renderer",
            "Video",
            "OpenRooms' files",
            "Page",
            "Photographs",
        ),
    }


@pytest.mark.parametrize("path", LEAVES, ids=" ".join)
def test_every_option_says_what_it_is(path: tuple[str, ...]) -> None:
    for option in LEAVES[path].params:
        if isinstance(option, click.Option):
            assert len((option.help or "").removesuffix("Repeatable.").split()) > 1, option.opts


@pytest.mark.parametrize("path", LEAVES, ids=" ".join)
def test_every_command_has_an_example_that_is_one_of_it(path: tuple[str, ...]) -> None:
    example = LEAVES[path].example
    assert example and f"Example:\n  {example}\n" in output_of(*path, "--help")
    words = shlex.split(example)
    assert tuple(words[: len(path) + 1]) == ("orusd", *path)
    assert parsed(path, words[len(path) + 1 :]).command is LEAVES[path]


@pytest.mark.parametrize("path", CHEAP, ids=" ".join)
def test_cheap_examples_run_and_print_as_they_are_asked(
    path: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words = shlex.split(LEAVES[path].example or "")[1:]
    said = {}
    for flag in ("--no-flag", "--quiet", "--verbose", "--json"):
        shutil.rmtree(tmp_path / "my_room", ignore_errors=True)
        done = run(*words, *([] if flag == "--no-flag" else [flag]))
        assert (done.exit_code, done.stderr) == (0, ""), flag
        said[flag] = done.stdout
    json.loads(said["--json"])
    is_asked = path != ("init",)
    assert said["--quiet"] == (said["--no-flag"] if is_asked else "")
    assert said["--verbose"] == said["--no-flag"] != ""


@pytest.mark.parametrize("words", ["init room FLAG", "init FLAG room", "FLAG init room"])
def test_the_options_go_before_and_after_the_command(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    document = json.loads(output_of(*words.replace("FLAG", "--json").split()))
    assert document["description"] == str(Path("room/room.yaml"))
    assert not output_of(*words.replace("FLAG", "-q").replace("room", "other").split())


def test_before_and_after_a_command_of_a_group() -> None:
    for words in ("library --json list", "--json library list", "library list --json"):
        assert "chair" in json.loads(output_of(*words.split()))


def test_quiet_and_verbose_exclude_each_other(tmp_path: Path) -> None:
    done = run("--quiet", "init", tmp_path / "room", "-v")
    assert done.exit_code == 2 and "exclude each other" in done.stderr


@pytest.mark.parametrize(("path", "old", "new"), FORMER, ids=str)
def test_former_options_work_with_a_note(path: tuple[str, ...], old: str, new: str) -> None:
    assert old not in re.findall(r"--[\w-]+", output_of(*path, "--help"))
    param = next(one.name for one in ALL[path].params if new in one.opts)
    chosen = {"--light": "lit", "--room": "a.yaml", "--classes": "coco", "--width": "80"}
    value = (chosen | {"--layout": "merged"}).get(old, 1)
    words = shlex.split(LEAVES[path].example or "")[len(path) + 1 :]
    if new in words:
        del words[words.index(new) : words.index(new) + 2]
    former, present = (parsed(path, [*words, f"{flag}={value}"]) for flag in (old, new))
    assert former.params == present.params and former.params[param]
    assert former.meta["openrooms_usd.former"] == [f"`{old}` is called `{new}` now"]


@pytest.mark.parametrize(
    ("words", "present", "params"),
    [
        (["--frames", "1:5"], "--time-codes", {"time_codes": "1:5"}),
        (["--frames=-2:5"], "--time-codes", {"time_codes": "-2:5"}),
        (["--frames", "--fps", "5"], "--keep-frames", {"keep_frames": True, "fps": 5}),
        (["--path", "walk", "--frames"], "--keep-frames", {"keep_frames": True, "spec": "walk"}),
    ],
)
def test_frames_of_a_render_were_two_things(
    words: list[str], present: str, params: dict[str, object]
) -> None:
    context = parsed(("render",), ["a.usda", "-o", "out", *words])
    assert params.items() <= context.params.items()
    assert context.meta["openrooms_usd.former"] == [f"`--frames` is called `{present}` now"]


@pytest.mark.parametrize("flag", ["--frames", "--layout"])
def test_these_belong_to_import_alone(flag: str) -> None:
    owners = {path[0] for path, one in LEAVES.items() if any(flag in p.opts for p in one.params)}
    assert owners == {"import"}


def test_former_commands_work_with_a_note(tmp_path: Path) -> None:
    for words, notes in (
        ("edits orphans", ["`edits` is called `edit` now"]),
        ("annotate orphans", ["`annotate` is called `edit` now"]),
        ("edit fit", ["`fit` is called `fix-units` now"]),
        ("edits adopt", ["`edits` is called `edit` now", "`adopt` is called `import-changes` now"]),
    ):
        done = run(*words.split(), tmp_path / "none")
        assert done.stderr.splitlines() == [f"note: {note}" for note in notes]
        assert not run(*words.split(), tmp_path / "none", "--quiet").stderr
    for former in ("annotate", "edits"):
        assert f"\n  {former} " not in output_of("--help")


def test_errors_are_documents_too(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    for words, code, kind in (
        (["validate", str(tmp_path / "none.usda"), "--json"], 2, "input"),
        (["render", "--json", "--nosuch"], 2, "usage"),
    ):
        monkeypatch.setattr(sys, "argv", ["orusd", *words])
        with pytest.raises(SystemExit) as ended:
            main()
        said = capsys.readouterr()
        error = json.loads(said.out)["error"]
        assert (ended.value.code, error["code"]) == (code, kind)
        assert error["message"] in said.err.replace("\n", " ") or kind == "input"
        assert {*error} == {"code", "message", "place", "remedy"}


def asking(**words: bool) -> click.Context:
    context = click.Context(orusd)
    for name in words:
        console.remember(context, name)
    return context


def test_progress_in_a_log_is_lines_that_say_something_new(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(bar, "_LINE_SECONDS", 0.01)

    def next_line() -> str:
        while not (said := capsys.readouterr().err):
            time.sleep(0.005)
        time.sleep(0.05)
        assert not capsys.readouterr().err
        return said

    with asking().scope(), bar.progress_bar("reading") as told:
        assert next_line() == "  0% reading\n"
        told(Counted("room_0/main/view_0", 1, 3), 1 / 3)
        assert next_line() == " 33% room_0/main/view_0 (1 of 3)\n"
    for asked in (asking(quiet=True), asking(json=True)):
        with asked.scope(), bar.progress_bar("reading"):
            time.sleep(0.05)
        assert not capsys.readouterr().err


def test_a_moment_has_no_progress_and_verbose_the_time_of_each_step(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for context in (asking(), asking(quiet=True), asking(json=True)):
        with context.scope(), bar.progress_bar("reading") as told:
            told("walls", 0.5)
        assert capsys.readouterr() == ("", "")
    with asking(verbose=True).scope(), bar.progress_bar("reading") as told:
        for step in ("walls", "walls", Counted("lamps", 2, 3)):
            time.sleep(0.01)
            told(step, 0.5)
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(" s  ")[1] for line in lines] == ["reading", "walls", "lamps (2 of 3)"]
    assert float(lines[1].split()[0]) >= 0.01


def test_a_terminal_sees_what_is_done_and_the_time_left(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    for context in (asking(quiet=True), asking()):
        with context.scope(), bar.progress_bar("reading") as told:
            for done in range(1, 5):
                told(f"view_{done}", done / 5)
                time.sleep(0.12)
        said = capsys.readouterr().err
        assert bool(said) != console.asked(context).quiet
    plain = re.sub(r"\x1b\[[\d;?]*[A-Za-z]", "", said)
    assert "view_4" in plain and "80%" in plain and re.search(r"0:00:0\d left", plain)


def test_verbose_prints_what_is_counted_otherwise(capsys: pytest.CaptureFixture[str]) -> None:
    names = [f"prim_{number}" for number in range(9)]
    assert console.named(names) == "9 x: prim_0, prim_1, prim_2 and 6 more"
    with asking(verbose=True).scope():
        assert all(name in console.named(names) for name in names)


def test_the_commands_say_nothing_past_the_shared_functions() -> None:
    """Tables of rich, too, are printed where the options are known."""
    for path in Path(cli.__file__).parent.glob("*.py"):
        if path.name != "console.py":
            assert "Console()" not in path.read_text(), path.name
