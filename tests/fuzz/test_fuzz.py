"""The fuzz campaign: its cases end well, and nothing that ends badly escapes it."""

import json
import random
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.fuzz import bytewise, containers
from tests.fuzz.__main__ import schedule
from tests.fuzz.case import VERDICTS
from tests.fuzz.kinds import Kind
from tests.fuzz.running import SOURCES, kinds_of
from tests.fuzz.spoiling import prepare, spoilt

ROOT = Path(__file__).parents[2]
KINDS = tuple(kinds_of(SOURCES).values())


def campaign(target: Path, *words: object) -> tuple[subprocess.CompletedProcess[str], Any]:
    command = [sys.executable, "-m", "tests.fuzz", "--json", target, *words]
    done = subprocess.run([*map(str, command)], cwd=ROOT, capture_output=True, text=True)
    assert target.is_file(), done.stdout + done.stderr
    return done, json.loads(target.read_text())


linux = pytest.mark.skipif(sys.platform != "linux", reason="it looks into /proc")


@linux
@pytest.mark.slow
@pytest.mark.parametrize("cases", [80, pytest.param(500, marks=pytest.mark.long)])
def test_whatever_is_read_is_accepted_or_refused_in_a_sentence(cases: int, tmp_path: Path) -> None:
    done, found = campaign(tmp_path / "tally.json", "--cases", cases, "--seconds", 60)
    assert found["defects"] == [], done.stdout
    assert done.returncode == 0
    *kinds, total = found["rows"]
    assert total["cases"] == cases
    assert total["refused"] > cases / 5 < total["accepted"]
    skipped = set(found["skipped"])
    assert {row["kind"] for row in kinds} == {kind.name for kind in KINDS} - skipped


@pytest.mark.slow
@linux
def test_everything_that_goes_wrong_is_seen(tmp_path: Path) -> None:
    """The planted kinds are named by what the campaign has to say of them."""
    words = ("--planted", "--cases", 14, "--seconds", 2, "--mebibytes", 300)
    keep = tmp_path / "kept"
    done, found = campaign(tmp_path / "tally.json", *words, "--keep", keep)
    assert done.returncode == 1
    *rows, total = found["rows"]
    assert total["cases"] == len(rows) == 14
    for row in rows:
        name = row["kind"].removeprefix("planted.").replace("-", " ")
        (seen,) = (verdict for verdict in VERDICTS if row[verdict])
        assert name.startswith(seen.replace("-", " ")), row
    crash, hang = (
        next(row for row in found["defects"] if row["kinds"] == [f"planted.{name}"])
        for name in ("crash", "hang")
    )
    assert (crash["what"], hang["what"]) == ("SIGSEGV", "hang")
    # What is kept can be looked at: the input as it was given.
    assert (keep / "planted.crash-0/in/a.txt").read_text() == "1 2 3\n"
    assert json.loads((keep / "planted.crash-0/outcome.json").read_text())["verdict"] == "crash"


@pytest.mark.slow
@linux
def test_one_case_can_be_run_again(tmp_path: Path) -> None:
    words = ("--only", "capture.boxes-csv", "--case", 7)
    first, found = campaign(tmp_path / "a.json", *words, "--keep", tmp_path / "a")
    again, _ = campaign(tmp_path / "b.json", *words, "--keep", tmp_path / "b")
    assert json.loads(first.stdout)[0]["verdict"] == json.loads(again.stdout)[0]["verdict"]
    assert found["rows"][0]["cases"] == 1
    for path in sorted((tmp_path / "a").rglob("in/*.csv")):
        assert path.read_bytes() == (tmp_path / "b" / path.relative_to(tmp_path / "a")).read_bytes()


@pytest.fixture
def planted(tmp_path: Path) -> Iterator[tuple[Kind, Path]]:
    kind = next(kind for kind in KINDS if kind.name == "capture.boxes-csv")
    (tmp_path / "planted").mkdir()
    kind.plant(tmp_path / "planted")
    yield kind, tmp_path


def test_a_case_is_fixed_by_seed_and_number(planted: tuple[Kind, Path]) -> None:
    kind, folder = planted

    def content(number: int, seed: int, name: str) -> dict[str, bytes]:
        place = folder / name
        place.mkdir()
        prepare(kind, number, seed, folder / "planted", place)
        return {p.name: p.read_bytes() for p in (place / "in").iterdir() if p.is_file()}

    sound = {p.name: p.read_bytes() for p in (folder / "planted/in").iterdir()}
    assert content(0, 0, "sound") == sound
    others = [content(number, 0, f"n{number}") for number in range(2, 12)]
    assert content(3, 0, "again") == others[1]
    assert sum(other != sound for other in others) >= 8
    assert content(3, 1, "seed") != others[1]


def test_every_kind_gets_cases_by_its_share() -> None:
    cases = schedule(KINDS, 2000)
    assert len(set(cases)) == 2000
    counts = {kind.name: sum(name == kind.name for name, _ in cases) for kind in KINDS}
    assert min(counts.values()) > 10
    assert counts["room.yaml"] > 3 * counts["panorama"]
    assert schedule(KINDS, 500) == cases[:500]


def test_what_is_spoilt_inside_has_sums_that_agree() -> None:
    """A changed PNG chunk or zip member is read as far as its content, not refused by its sum."""
    import io
    import zipfile

    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        archive.writestr("a.txt", "content")
    rng = random.Random(1)
    for _ in range(20):
        data = containers.spoil_zip(made.getvalue(), rng, lambda name, part: part + b"!")
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            assert archive.testzip() is None
    page = b"x" * 1020
    whole = page + containers._crc32c(page).to_bytes(4, "big")
    assert containers.spoil_e57(whole, rng, lambda name, part: part) == whole
    assert containers._crc32c(b"123456789") == 0xE3069283


@pytest.mark.parametrize("suffix", [".json", ".yaml", ".csv", ".bin", ".png", ".usda", ".npz"])
def test_mutators_take_whatever_there_is(suffix: str) -> None:
    rng = random.Random(2)
    for data in (b"", b"\0", b"x", b'{"a": [1, {"b": 2}]}', b"a: [1, 2]\n", bytes(range(256)) * 4):
        for _ in range(40):
            assert isinstance(spoilt(f"a{suffix}", data, data, rng), bytes)
    for mutate in (*bytewise.BYTES, *bytewise.TEXT):
        assert isinstance(mutate(b"", rng), bytes)
    changed = [spoilt("a.json", b'{"a": [1, {"b": 2}]}', b"", rng) for _ in range(50)]
    assert len(set(changed)) > 30
