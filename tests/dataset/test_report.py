"""The page about a dataset, from records that were written by hand: what it says, and to whom."""

import re
import sys
import xml.etree.ElementTree as ET
from html import escape, unescape
from pathlib import Path
from typing import Any

import pytest

from openrooms_usd.dataset.plan import Job, PlannedRoom
from openrooms_usd.dataset.records import LEFT_OUT, SCENE
from openrooms_usd.dataset.report import charts
from openrooms_usd.dataset.report.page import spread, write_report
from openrooms_usd.dataset.report.sections import contents, cost_table
from openrooms_usd.dataset.stats import Stats
from openrooms_usd.dataset.store import Store, write_json
from openrooms_usd.errors import InputError, MissingPackageError

HOSTILE = "<script>alert('x')</script>\"><img src=x onerror=alert(1)> $\\frac{1}{0}$ {{ 7*7 }}"

# A name that a folder can have.
HOSTILE_NAME = "<script>alert(1)&<img src=x>"


def room(number: int, kind: str = "office", name: str = "") -> PlannedRoom:
    return PlannedRoom(name or f"{kind}_{number}", number, {"type": kind}, "train")


def fill(root: Path, jobs: list[Job], name: str = "chair") -> Store:
    """Write the records of finished views, all alike, and of one that failed."""
    store = Store(root)
    store.write_plan(jobs)
    for job in jobs:
        lights = [{"kind": "lamp", "on": True, "lumen": 300.0, "kelvin": 2700.0}]
        entry = {"legend": {"category": {"5": name}}, "lights": lights}
        report = {"approximated": 0, "losses": []}
        shared = {"entry": entry, "report": report, "licences": [name], "files": {}}
        write_json(store.record_path(job, SCENE), {"key": job.key, **shared})
        for view in job.views:
            record = record_of(f"{job.name}/view_{view}", name)
            took = {"compose": 4.0, "translation": 2.0, "render": 10.0, "output": 1.0}
            timing = {**took, "threads": 2, "channels": {"radiance": 9.0, "depth": 0.1}}
            store.finish(job, view, record, timing)
    return store


def record_of(unit: str, name: str) -> dict[str, Any]:
    pose = [[1.0, 0.0], [0.0, 1.0]]
    gone = {"camera": name, "world_from_camera": pose, "faults": ["it is empty"]}
    channels = {
        "radiance": {"estimated_robust_error": 0.02},
        "depth": {"estimated_robust_error": 0.0},
    }
    return {
        "unit": unit,
        "room": "",
        "variant": "",
        "split": "",
        "source": {},
        "told": [],
        "quality": {"measures": {}, "faults": [f"it is dark {name}"]},
        "rejected": [gone],
        "entry": {"resolution": [], "K": [], "world_from_camera": [], "channels": channels},
        "pixels": {name: 10, "wall": 30},
        "materials": {f"wood/{name}": 40},
        "depth": [0, 30, 10],
        "files": {"a": {"sha256": "", "bytes": 1000}},
    }


def job(planned: PlannedRoom, variant: str = "main", views: int = 2) -> Job:
    return Job(planned, variant, 0, f"{planned.number} {variant}", tuple(range(views)))


def written(root: Path, **wishes: Any) -> str:
    page = root / "page.html"
    write_report(root, page, **wishes)
    return page.read_text(encoding="utf-8")


def test_names_from_strangers_are_shown_and_do_nothing(tmp_path: Path) -> None:
    done, lost = (job(room(n, HOSTILE, f"{HOSTILE_NAME}{n}"), views=1) for n in (0, 1))
    store = fill(tmp_path, [done], HOSTILE)
    store.write_plan([done, lost])
    store.render(done).mkdir(parents=True)
    store.fail(lost, 0, {"unit": HOSTILE, "code": "input", "reason": f"no such {HOSTILE}"})
    text = written(tmp_path)
    assert "<script" not in text
    assert re.findall(r"<img (?!src=\"data:)", text) == []
    assert "onerror" not in re.sub(r">[^<]*<", "><", text)
    # As failure, licence, category, fault and camera.
    assert unescape(text).count(f"{HOSTILE}</t") >= 5
    assert f"<h3>{escape(HOSTILE_NAME)}0</h3>" in text
    assert "{{ 7*7 }}" in text


def test_rooms_that_were_left_out_are_listed_with_the_reason(tmp_path: Path) -> None:
    done, gone = job(room(0)), job(room(1, "scan"))
    store = fill(tmp_path, [done])
    assert "left out" not in written(tmp_path).replace("camera that was left out", "")
    store.write_plan([done, gone])
    for view in gone.views:
        reason = {"unit": "", "code": LEFT_OUT, "reason": "its scan shows 41 % of the walls"}
        store.fail(gone, view, reason)
    text = written(tmp_path)
    assert "<dt>rooms left out</dt><dd>1</dd>" in text
    assert text.count("its scan shows 41 % of the walls") == 1
    assert "None: all views that were tried are there." in text


@pytest.mark.parametrize("entry", [{"renderer": 3}, {"stop": {"samples": "8"}}, {"bounces": []}])
def test_a_record_that_says_nonsense_is_none(tmp_path: Path, entry: dict[str, Any]) -> None:
    one = job(room(0))
    store = fill(tmp_path, [one])
    record = store.scene_record(one)
    assert record
    record["entry"] |= entry
    write_json(store.record_path(one, SCENE), record)
    assert store.scene_record(one) is None
    assert "No view is finished" not in written(tmp_path)


def test_a_page_says_what_the_records_say(tmp_path: Path) -> None:
    fill(tmp_path, [job(room(0)), job(room(1, "gym"))])
    (tmp_path / "dataset.yaml").write_text("name: homes\nrooms: [{count: 2}]\n")
    text = written(tmp_path, price=0.5)
    assert "<h1>homes</h1>" in text
    assert "rooms: [{count: 2}]" in text
    for title in (
        "Views",
        "Contents",
        "Channels",
        "Cost",
        "Quality",
        "Failures",
        "How it was made",
    ):
        assert f"<h2>{title}</h2>" in text
    for said in ("it is dark chair", "it is empty", "None: all views that were tried are there."):
        assert said in text
    for tag in ("http:", "https:", 'src="/', "@import", '<link rel="style'):
        found = [line for line in text.splitlines() if tag in line and "xmlns" not in line]
        assert found == []


@pytest.mark.slow
def test_a_page_is_the_same_bytes_again(tmp_path: Path) -> None:
    fill(tmp_path, [job(room(0)), job(room(1, "gym"))])
    assert written(tmp_path) == written(tmp_path)


@pytest.mark.slow
def test_a_page_stays_small_however_many_rooms_there_are(tmp_path: Path) -> None:
    sizes = []
    for count in (30, 300):
        root = tmp_path / str(count)
        fill(root, [job(room(n, f"kind {n}"), views=1) for n in range(count)])
        sizes.append(len(written(root, pictures=12)))
    assert sizes[1] < 1.2 * sizes[0] + 20_000


def test_a_dataset_without_any_view_has_a_page_too(tmp_path: Path) -> None:
    Store(tmp_path).write_plan([job(room(0))])
    assert "No view is finished." in written(tmp_path, price=1.0)
    with pytest.raises(InputError):
        write_report(tmp_path / "nowhere", tmp_path / "page.html")
    with pytest.raises(InputError, match="nan is not a price"):
        write_report(tmp_path, tmp_path / "other.html", price=float("nan"))
    assert not (tmp_path / "other.html").exists()


@pytest.mark.parametrize("package", ["jinja2", "matplotlib"])
def test_a_missing_package_is_named_with_its_extra(
    tmp_path: Path, package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(tmp_path, [job(room(0))])
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingPackageError) as found:
        write_report(tmp_path, tmp_path / "page.html")
    assert package in found.value.message
    assert "[report]" in str(found.value.remedy)
    assert not (tmp_path / "page.html").exists()


def test_cost_is_hours_times_cores_times_price() -> None:
    # Ten views of 36 s on 4 cores: 10 h, 40 hours of cores, a thousand of them.
    stats = Stats(views={"main": 10}, seconds={"render": 360.0}, core_seconds=1440.0, bytes=20_000)
    rows = dict(cost_table(stats, 0.25).rows)
    assert rows["hours of one worker"] == "10"
    assert rows["core-hours"] == "40"
    assert rows["storage"] == "2 MB"
    assert rows["money, at 0.25 for an hour of a core"] == "10"
    assert len(cost_table(stats, None).rows) == len(rows) - 1
    assert cost_table(Stats(), 1.0).rows == ()


def test_rooms_are_spread_over_types_and_over_the_dataset() -> None:
    rooms = [room(n, ("office", "gym")[n % 2]) for n in range(100)] + [room(100, "attic")]
    chosen = spread(rooms, 9)
    kinds = [one.source["type"] for one in chosen]
    assert (kinds.count("attic"), kinds.count("gym"), kinds.count("office")) == (1, 4, 4)
    assert [one.number for one in chosen if one.source["type"] == "office"] == [12, 36, 62, 86]
    assert spread(rooms[:3], 9) == rooms[:3]
    assert spread([], 9) == []


def test_the_last_bin_of_depths_has_no_end() -> None:
    (depth,) = contents(Stats(depth_m={"9.75": 1, "10": 3}))
    assert [row[0] for row in depth.table.rows] == ["9.75 to 10", "10 and more"]


def test_charts_are_the_same_bytes_and_hold_their_words_as_text() -> None:
    rows = charts.most({f"name {n}": float(n) for n in range(40)})
    assert rows[0] == ("name 39", 39.0)
    assert rows[-1] == ("17 others", sum(range(17)))
    first, again = charts.bars(rows, charts.count), charts.bars(rows, charts.count)
    assert first == again
    words = {node.text for node in ET.fromstring(first).iter("{http://www.w3.org/2000/svg}text")}
    assert {"name 39", "17 others", "136"} <= words
    assert charts._INK not in first
    renamed = charts.distinct(first, "a")
    names = re.findall(r'id="([^"]*)"', renamed)
    assert all(name.startswith("a-") for name in names)
    assert {name.removeprefix("#") for name in re.findall(r'href="([^"]*)"', renamed)} <= {*names}


@pytest.mark.parametrize(
    ("word", "expected"),
    [
        (charts.count(9999), "9,999"),
        (charts.count(1_234_567), "1.23 M"),
        (charts.size(27_400_000), "27.4 MB"),
        (charts.size(0), "0 bytes"),
        (charts.seconds(0.0123), "0.012 s"),
        (charts.seconds(90.0), "90 s"),
        (charts.seconds(7200.0), "2 h"),
        (charts.share(1, 8), "12 %"),
        (charts.share(1, 5000), "under 0.1 %"),
        (charts.share(0, 0), "0 %"),
        (charts.digits(123456.0), "123,000"),
        (charts.digits(0.000123), "0.000123"),
    ],
)
def test_numbers_are_worded_for_people(word: str, expected: str) -> None:
    assert word == expected
