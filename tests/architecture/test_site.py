"""The site of the documentation: every page is found, and nothing comes from other servers."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml

from docs import reference_pages
from tests.chromium import needs_chromium, opened

ROOT = Path(__file__).parents[2]
PAGES = {path.relative_to(ROOT / "docs").as_posix() for path in (ROOT / "docs").rglob("*.md")}
# Pages that programs write; other tests compare them with what the programs say.
GENERATED = {f"reference/{name}" for name in reference_pages.PAGES} | {
    f"reference/{name}.md" for name in ("api", "channels", "settings", "usd-mapping")
}
MOST_WORDS = 45_000  # of all pages that people write, tables and code included
# Where `make docs` has it, or this environment.
MKDOCS = shutil.which("mkdocs", path=str(ROOT / ".venv-docs/bin")) or shutil.which("mkdocs")


def leaves(part: object) -> list[str]:
    """The pages of a part of the navigation, from top to bottom."""
    if isinstance(part, str):
        return [part]
    parts = part.values() if isinstance(part, dict) else part
    return [leaf for one in parts for leaf in leaves(one)]


def build(folder: Path) -> None:
    """Build the site as ``make docs`` does."""
    done = subprocess.run(
        [str(MKDOCS), "build", "--quiet", "--site-dir", folder],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr


def test_every_page_is_once_in_the_navigation() -> None:
    text = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    found = leaves(yaml.safe_load(text[text.index("\nnav:") :])["nav"])
    assert sorted(one for one in found if not one.startswith("project/")) == sorted(PAGES)


def test_the_pages_that_people_write_stay_short() -> None:
    words = {
        name: len((ROOT / "docs" / name).read_text(encoding="utf-8").split())
        for name in PAGES - GENERATED
    }
    longest = sorted(words, key=lambda name: words[name], reverse=True)[:5]
    assert sum(words.values()) <= MOST_WORDS, {name: words[name] for name in longest}


def test_links_lead_from_the_first_page_to_every_page() -> None:
    """On GitHub, which has no navigation."""
    seen, ahead = set[Path](), [ROOT / "docs/index.md"]
    while ahead:
        page = ahead.pop().resolve()
        if page not in seen and page.is_file():
            seen.add(page)
            links = re.findall(r"\]\((?!https?:|#)([^)#\s]+\.md)", page.read_text(encoding="utf-8"))
            ahead += [page.parent / link for link in links]
    assert {page for page in PAGES if (ROOT / "docs" / page).resolve() not in seen} == set()


@pytest.mark.slow
@pytest.mark.skipif(MKDOCS is None, reason="MkDocs is not installed (make docs)")
def test_the_site_is_complete_and_needs_no_network(tmp_path: Path) -> None:
    """Strict: links, anchors and pages are checked; code of ours is no part of the site."""
    build(tmp_path)
    assert list(tmp_path.rglob("*.py")) == []
    assert (tmp_path / "search/search_index.js").is_file()
    loads = re.compile(r'(?:\bsrc=|<link[^>]+href=)"?https?:[^">]+')
    assert [m for page in tmp_path.rglob("*.html") for m in loads.findall(page.read_text())] == []


@needs_chromium
@pytest.mark.slow
@pytest.mark.skipif(MKDOCS is None, reason="MkDocs is not installed (make docs)")
def test_the_site_can_be_searched_and_copied_from_a_disk(tmp_path: Path) -> None:
    """What is copied of a console is its commands, without prompts."""
    build(tmp_path)
    with opened(tmp_path / "howto/bake.html") as page:
        page.key("/")
        for letter in "lightmaps":
            page.key(letter)
        found = "[...document.querySelectorAll('.md-search-result__link')].map(a => a.href)"
        page.wait(f"{found}.length")
        first, *_ = page.evaluate(found)
        assert first.startswith((tmp_path / "howto/bake.html").as_uri())

        code = "document.querySelector('.highlight code')"
        page.evaluate(f"{code}.setAttribute('data-md-copying', '')")
        assert "orusd init" in (copied := page.evaluate(f"{code}.innerText"))
        assert "$" not in copied
