"""What systems do differently stands in one module each: read from the sources."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "openrooms_usd"
SOURCES = [
    path
    for folder in (PACKAGE, ROOT / "schemas", ROOT / "converters")
    for path in sorted(folder.rglob("*.py"))
]


@pytest.mark.parametrize(
    ("call", "owners"),
    [
        (r"os\.kill\(", ("processes.py",)),
        (r"(?<!posixpath\.)\b(relpath|commonpath)\(", ("portable.py",)),
        (r"os\.path\.normpath\(", ("library/ownmaterials/mtlxtext.py", "library/models/urdf.py")),
        (r"shlex\.(quote|join)\(", ("portable.py",)),
        (r"NamedTemporaryFile\(", ()),
        (r"\bTemporaryDirectory\(", ("scratch.py",)),
        (r"\bpass_fds\b", ("steps/physics/ahead.py",)),
        (r"os\.get[eg]?uid\(", ("dataset/scratch.py",)),
        (r"os\.(fork|killpg|setsid|mkfifo)\(|select\.select\(|\bfcntl\b|shell=True", ()),
        (r"\.(read|write)_text\(\)", ()),
    ],
)
def test_what_systems_do_differently_stands_in_one_place(
    call: str, owners: tuple[str, ...]
) -> None:
    found = {path for path in SOURCES if re.search(call, path.read_text(encoding="utf-8"))}
    assert found <= {PACKAGE / owner for owner in owners}
