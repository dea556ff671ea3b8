"""The tests' own rules: what takes long is marked, and of many cases few are fast."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

CONFTEST = Path(__file__).parents[1] / "conftest.py"
SETTINGS = "[pytest]\nmarkers =\n  slow: s\n  one_in(n): n\n  xdist_group(name): g\n"
TESTS = """
import subprocess, sys, time
import pytest

BURN = "import time\\nwhile time.process_time() < {}: pass"
burn = lambda: exec(BURN.format(time.process_time() + 0.15))
made = []

@pytest.fixture(scope="module")
def shared(): burn()
@pytest.fixture
def own(): burn()

def test_itself(): burn()
def test_its_own_fixture(own): pass
def test_its_process(): subprocess.run([sys.executable, "-c", BURN.format(0.15)], check=True)
def test_what_is_shared(shared): pass
def test_first_use():
    made or burn()
    made.append(1)
def test_sleep(): time.sleep(0.3)
@pytest.mark.slow
def test_marked(): burn()
@pytest.mark.parametrize("missing", "ab")
def test_of_what_is_missing(missing): pytest.skip("no such tool")
@pytest.mark.one_in(3)
@pytest.mark.parametrize("case", "abcde")
def test_cases(case): pass
"""
TOO_LONG = {"test_itself", "test_its_own_fixture", "test_its_process", "test_first_use"}


def outcomes(folder: Path, *words: str) -> tuple[set[str], set[str], str]:
    """Names of tests that passed and that failed, and all that was said."""
    shutil.copy(CONFTEST, folder)
    (folder / "pytest.ini").write_text(SETTINGS)
    (folder / "test_some.py").write_text(TESTS)
    call = [sys.executable, "-m", "pytest", "-rA", "-p", "no:cacheprovider", *words]
    said = subprocess.run(call, cwd=folder, capture_output=True, text=True).stdout
    passed, failed = (
        {
            line.split("::")[1].split(" ")[0]
            for line in said.splitlines()
            if line.startswith(f"{word} test_some.py")
        }
        for word in ("PASSED", "FAILED")
    )
    return passed, failed, said


@pytest.mark.slow
@pytest.mark.parametrize("workers", [(), ("-n", "2")])
def test_what_takes_long_is_listed_and_fails_only_where_that_is_asked(
    tmp_path: Path, workers: tuple[str, ...]
) -> None:
    passed, failed, said = outcomes(tmp_path, "--cpu-limit", "0.1", *workers)
    assert not failed and passed >= TOO_LONG, said
    listed = said.partition("more than 0.1 s of processor time ==")[2].partition("== skipped")[0]
    assert {line.split("::")[1] for line in listed.splitlines() if "::" in line} == TOO_LONG, said
    passed, failed, said = outcomes(tmp_path, "--cpu-fail", "0.1", *workers)
    assert failed == TOO_LONG, said
    assert {"test_what_is_shared", "test_sleep", "test_marked"} <= passed
    assert said.count("of processor time, more than 0.1 s") >= len(TOO_LONG)


def test_what_is_skipped_is_counted_by_reason(tmp_path: Path) -> None:
    _, _, said = outcomes(tmp_path, "-k", "missing")
    assert re.search(r"= skipped, by reason =+\n +2  no such tool\n", said), said


def test_of_many_cases_few_are_fast(tmp_path: Path) -> None:
    passed, _, said = outcomes(tmp_path, "-m", "not slow", "-k", "cases or marked")
    assert passed == {"test_cases[a]", "test_cases[d]"}, said


def test_what_shares_something_goes_to_one_worker(tmp_path: Path) -> None:
    # As pytest and pytest-xdist agree on it: else each worker composes each room.
    words = ("-n", "2", "--dist", "loadgroup", "-m", "not slow", "-k", "cases", "-v")
    _, _, said = outcomes(tmp_path, *words)
    assert len(set(re.findall(r"\[(gw\d)\].* PASSED .*test_cases", said))) == 1, said
