"""The page about a real small dataset, in a real browser."""

import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.chromium import Page, needs_chromium, opened

pytestmark = [pytest.mark.slow, needs_chromium]

_MAIN = "from openrooms_usd.cli import main; main()"
_SECTIONS = ("views", "contents", "channels", "cost", "quality", "failures", "splits", "made")


def orusd(*words: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", _MAIN, *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory, write_source: Callable[[Path], Path]) -> Path:
    """The page of a dataset with one room in two variants, and one that cannot be made."""
    folder = tmp_path_factory.mktemp("report")
    file = write_source(folder / "source")
    text = file.read_text().replace("[radiance, depth, instance, valid]", "[usual]")
    file.write_text(text)
    orusd("dataset", "run", file, "-o", folder / "out")
    done = orusd("dataset", "report", folder / "out", "--price", 0.04)
    assert done.returncode == 0, done.stderr
    assert "4 views, 2 shown" in done.stdout
    return folder / "out/report.html"


@pytest.fixture(scope="module")
def page(report: Path) -> Iterator[Page]:
    with opened(report) as found:
        yield found


def test_it_opens_in_silence_and_asks_for_nothing_else(page: Page, report: Path) -> None:
    assert page.messages == []
    outside = [address for address in page.requests if not address.startswith("data:")]
    assert outside == [report.resolve().as_uri()]


def test_every_picture_is_there_and_says_what_it_shows(page: Page) -> None:
    found = page.evaluate("[...document.images].map(i => [i.naturalWidth, i.alt])")
    # Two variants of a view, and one view in its channels.
    assert len(found) > 2 + 5
    assert all(width > 0 and alt for width, alt in found)


def test_every_section_is_there_and_has_what_belongs_into_it(page: Page) -> None:
    ids = page.evaluate("[...document.querySelectorAll('main > section')].map(s => s.id)")
    assert ids == list(_SECTIONS)
    links = page.evaluate("[...document.querySelectorAll('nav a')].map(a => a.hash.slice(1))")
    assert links == ids
    assert page.evaluate("document.querySelectorAll('#contents svg').length") >= 8
    assert "chiar" in page.evaluate("document.querySelector('#failures').innerText")
    assert "name: small" in page.evaluate("document.querySelector('#made pre').innerText")
    words = page.evaluate("[...document.querySelectorAll('svg text')].map(t => t.textContent)")
    assert {"office", "chair", "main", "wood"} <= {*words}


def test_behind_a_url_it_is_the_same_page(report: Path, tmp_path: Path) -> None:
    pytest.importorskip("fsspec")
    again = tmp_path / "again.html"
    done = orusd("dataset", "report", report.parent.as_uri(), "-o", again, "--price", 0.04)
    assert done.returncode == 0, done.stderr
    assert again.read_bytes() == report.read_bytes()


def test_names_in_the_page_are_its_own(page: Page) -> None:
    ids = page.evaluate("[...document.querySelectorAll('[id]')].map(e => e.id)")
    assert len(ids) == len({*ids})


@pytest.mark.parametrize("width", [320, 375, 768, 1440])
def test_no_window_is_too_narrow(page: Page, width: int) -> None:
    page.resize(width, 800)
    assert page.evaluate("document.documentElement.scrollWidth") == width
    outside = page.evaluate(
        "[...document.querySelectorAll('h1,h2,h3,p,img,svg,figure,dl')]"
        ".filter(e => e.getBoundingClientRect().right > innerWidth + 1).map(e => e.outerHTML)"
    )
    assert outside == []


def test_words_in_charts_do_not_lie_on_each_other(page: Page) -> None:
    page.resize(1280, 800)
    overlaps = page.evaluate("""
        [...document.querySelectorAll('svg')].flatMap(svg => {
            const boxes = [...svg.querySelectorAll('text')].map(t =>
                [t.textContent, t.getBoundingClientRect()]);
            return boxes.flatMap(([a, p], i) => boxes.slice(i + 1)
                .filter(([b, q]) => Math.min(p.right, q.right) - Math.max(p.left, q.left) > 1 &&
                    Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top) > 3)
                .map(([b, q]) => [a, b]));
        })""")
    assert overlaps == []


def test_words_stand_out_from_the_paper_also_in_the_dark(page: Page) -> None:
    light = page.evaluate("getComputedStyle(document.querySelector('svg text')).fill")
    page.darken()
    dark = page.evaluate("getComputedStyle(document.querySelector('svg text')).fill")
    paper = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert dark != light
    assert dark != paper
