"""Names from files of others reach a terminal as text, never as commands to it."""

import ast
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from openrooms_usd import cli
from openrooms_usd.cli import EXIT_CODES, console
from openrooms_usd.cli.console import echo
from openrooms_usd.cli.interruption import EXIT_CODE
from openrooms_usd.cli.validating import _print_findings
from openrooms_usd.errors import InputError, OrusdError, printable
from openrooms_usd.validation.model import Finding
from tests.commands import output_of, run

ROOT = Path(__file__).parents[2]

HOSTILE = [
    "\x1b[2J",
    "\x07",
    "\x9b31m",
    "\x7f",
    "\r",
    "\b",
    "\u202e",
    "\u2066",
    "\u2028",
    "\ud800",
    "\0",
]
FOLDER = Path(cli.__file__).parent


@pytest.mark.parametrize("sign", HOSTILE)
def test_an_error_escapes_what_a_terminal_obeys(sign: str) -> None:
    error = InputError(f"bad {sign} message", place=f"a{sign}b", remedy=f"do {sign}")
    assert sign[0] not in str(error)
    assert all(line.isprintable() for line in str(error).split("\n"))
    # What programs read is as it is.
    assert error.as_dict()["place"] == f"a{sign}b"


def test_lists_of_ours_keep_their_lines_and_names_make_none() -> None:
    error = OrusdError("two:\n  one\n  other", place="a\nremedy: trust me", remedy="mend\nboth")
    assert str(error) == "a\\nremedy: trust me: two:\n  one\n  other\n  remedy: mend\nboth"


@pytest.mark.parametrize("text", ["Stühle", "椅子", "tab\there", "é", "a b", "☃"])
def test_what_people_write_stays(text: str) -> None:
    assert printable(text) == text


@pytest.mark.parametrize("sign", HOSTILE)
def test_commands_print_it_escaped(sign: str, capsys: pytest.CaptureFixture[str]) -> None:
    echo(f"note: {sign}")
    assert sign[0] not in capsys.readouterr().out


def test_commands_print_by_one_function_alone() -> None:
    for path in FOLDER.glob("*.py"):
        if path.name in ("console.py", "__init__.py"):
            continue
        tree = ast.walk(ast.parse(path.read_text()))
        calls = [ast.unparse(node.func) for node in tree if isinstance(node, ast.Call)]
        assert not {"click.echo", "click.secho", "print"} & set(calls), path.name


def test_a_stage_of_others_cannot_colour_its_report(tmp_path: Path) -> None:
    name = "a\x1b[31m"
    (tmp_path / "a.usda").write_text(
        '#usda 1.0\ndef Cube "a" (\n  assetInfo = {\n'
        f'    string name = "{name}"\n    string license = "{name}"\n  }}\n) {{\n}}\n'
    )
    shown = run("validate", tmp_path / "a.usda")
    assert "\x1b[31m" not in shown.output and "\\x1b[31m" in shown.output.replace("\n", "")
    data = run("validate", "--json", tmp_path / "a.usda")
    assert json.loads(data.stdout)["licences"][0]["name"] == name


def test_every_importer_says_what_it_reads() -> None:
    shown = run("import", "--help").output.partition("Commands:\n")[2]
    listed = shown.partition("\n\n")[0].splitlines()
    said = [
        line.split(maxsplit=1)[1] for line in listed if line.startswith("  ") and line[2] != " "
    ]
    assert len(set(said)) == len(said) >= 9
    assert all(sentence.startswith("Read ") for sentence in said)


def test_help_names_room_types_and_no_functions_of_ours() -> None:
    assert "living_room" in run("generate", "--help").output
    assert "-o, --out DIR|URL" in run("dataset", "run", "--help").output


def test_notes_and_findings_that_say_the_same_are_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    console.echo_notes(["a door moved", "no roof", "a door moved"])
    findings = [Finding("error", "rule", f"/World/Thing_{n}", "has no material") for n in range(7)]
    _print_findings(Path("room.usda"), findings)
    notes, findings_text = capsys.readouterr().out.split("room.usda")
    assert notes.splitlines() == ["note: a door moved (2 times)", "note: no roof"]
    assert ": 7 errors" in findings_text
    assert "7 x: /World/Thing_0, /World/Thing_1, /World/Thing_2 and 4 more" in findings_text
    assert findings_text.count("has no material") == 1


def test_the_documented_exit_codes_are_those_that_there_are() -> None:
    text = (ROOT / "docs/reference/errors.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+) \| (.*) \|$", text, flags=re.MULTILINE)
    assert {int(code): meaning for code, meaning in rows} == EXIT_CODES
    kinds = [OrusdError]
    for kind in kinds:
        kinds += kind.__subclasses__()
    assert {kind.exit_code for kind in kinds} | {0, EXIT_CODE} == {*EXIT_CODES}
    assert all(meaning.split()[0] in output_of("--help") for meaning in EXIT_CODES.values())


def test_a_shell_completes_commands(tmp_path: Path) -> None:
    """By what `orusd completion` prints, in a real one."""
    bash = shutil.which("bash") or pytest.skip("no bash")
    command = tmp_path / "orusd"
    code = "from openrooms_usd.cli import orusd; orusd(prog_name='orusd')"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -c "{code}"\n')
    command.chmod(0o755)
    script = output_of("completion", "bash")
    words = "COMP_WORDS=(orusd com); COMP_CWORD=1"
    asked = f'{script}\n{words}; _orusd_completion {command}; echo "${{COMPREPLY[@]}}"'
    done = subprocess.run([bash, "-c", asked], capture_output=True, text=True, check=True)
    assert {"compose", "compare"} < {*done.stdout.split()}
    for shell in ("zsh", "fish"):
        assert f"_ORUSD_COMPLETE={shell}_complete" in output_of("completion", shell)
