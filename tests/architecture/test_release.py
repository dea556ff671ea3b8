"""What a public project says of itself agrees with what it is."""

import re
import tomllib
from pathlib import Path

import yaml

from openrooms_usd.version import __version__

ROOT = Path(__file__).parents[2]
KINDS = {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}
WORDS = 25  # of an entry of the changelog
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_the_citation_names_this_version_and_the_paper() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == __version__
    (paper,) = citation["references"]
    assert (paper["year"], len(paper["authors"])) == (2021, 17)


def test_the_changelog_has_this_release_in_short_entries_by_kind() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    first, latest, *_ = re.findall(r"^## (.+)$", text, re.MULTILINE)
    assert first == "[Unreleased]"
    assert latest == f"[{__version__}] - {citation['date-released']}"
    assert set(re.findall(r"^### (.+)$", text, re.MULTILINE)) <= KINDS
    entries = re.findall(r"^- (.+)$", text, re.MULTILINE)
    assert [entry for entry in entries if len(entry.split()) > WORDS] == []


def test_each_python_that_is_tested_is_named() -> None:
    workflow = (ROOT / ".github/workflows/tests.yml").read_text(encoding="utf-8")
    tested = yaml.safe_load(workflow)["jobs"]["tests"]["strategy"]["matrix"]["python"]
    stem = "Programming Language :: Python :: 3."
    named = [row.removeprefix(stem[:-2]) for row in PROJECT["classifiers"] if row.startswith(stem)]
    assert tested == named
    assert PROJECT["requires-python"] == f">={named[0]}"
