"""What tests of all areas share: is a stage valid, a room composed once, the time they may take."""

import gc
import importlib.util
import inspect
import os
import re
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from pathlib import Path

import hypothesis
import pytest

# Our schemas, before any test looks a definition up: USD knows no others afterwards.
import orusd_schemas  # noqa: F401

ROOT = Path(__file__).parents[1]

# Machines are shared: how long an example takes says nothing.
hypothesis.settings.register_profile("patient", deadline=None)
hypothesis.settings.load_profile("patient")

# A room with a window, a door, a lamp, a repeated chair and an object on another one.
SMALL_ROOM = """\
name: small
room: office
seed: 3
layout:
  from: polygon
  polygon: [[0, 0], [4, 0], [4, 3], [0, 3]]
  openings:
    - {kind: window, wall: 0}
    - {kind: door, wall: 2, open: 40 deg}
furniture:
  from: objects
  objects:
    - {category: table, at: [1.5, 1.5], name: desk}
    - {category: chair, at: [1.5, 0.8], yaw: 180 deg}
    - {category: chair, at: [2.6, 1.5], yaw: 90 deg}
    - {category: table_lamp, at: [1.5, 1.6], on: desk}
"""

# Fixtures that compose a room for many tests.
ROOMS = ("composed_demo", "composed_bodies", "demo", "generated", "lab")

# What Windows lacks; tests of it are skipped there.
POSIX = re.compile(r"mkfifo|SIGKILL|SIGSTOP|SIGALRM|/dev/|/bin/|geteuid|\bstart\(")

# Captures of real rooms, which are not part of the project: where they are missing, so are their
# tests.
REAL = Path(os.environ.get("ORUSD_REAL") or Path(__file__).parents[2] / "shared" / "data")


@pytest.hookimpl(tryfirst=True)  # before xdist reads the marks
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Few of many cases are fast, and what shares something goes to one worker."""
    cases: Counter[str] = Counter()
    for item in items:
        if sys.platform == "win32" and isinstance(item, pytest.Function):
            needed = POSIX.search(inspect.getsource(item.function))
            item.add_marker(pytest.mark.skipif(bool(needed), reason="Windows lacks it"))
        test = item.nodeid.partition("[")[0]
        for rare in item.iter_markers("one_in"):
            if cases[test] % rare.args[0]:
                item.add_marker(rare.kwargs.get("rest", "slow"))
        cases[test] += 1
        if item.get_closest_marker("long"):
            item.add_marker(pytest.mark.slow)
        grouped = item.get_closest_marker("xdist_group")
        if isinstance(item, pytest.Function) and not grouped and (group := shared_by(item)):
            item.add_marker(pytest.mark.xdist_group(group))


def pytest_sessionstart() -> None:
    """While thousands of tests are collected there is no garbage, only looking for it."""
    gc.disable()


def pytest_collection_finish() -> None:
    gc.enable()
    gc.freeze()


def pytest_sessionfinish() -> None:
    gc.unfreeze()


def shared_by(test: pytest.Function) -> str | None:
    """The room that a test looks at, else its file; slow ones that share nothing go one by one."""
    for room in ROOMS:
        if room in test.fixturenames:
            return room
    file = test.nodeid.partition("::")[0]
    fixtures = [found[-1] for found in test._fixtureinfo.name2fixturedefs.values()]
    shares = any(one.scope != "function" and one.baseid == file for one in fixtures)
    return None if test.get_closest_marker("slow") and not shares else file


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--cpu-limit",
        type=float,
        metavar="SECONDS",
        default=float("inf"),
        help="list tests without the mark slow that take more processor time",
    )
    parser.addoption(
        "--cpu-fail",
        type=float,
        metavar="SECONDS",
        default=float("inf"),
        help="fail tests without the mark slow that take more processor time",
    )


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(CpuTimes(*map(config.getoption, ("cpu_limit", "cpu_fail"))))


class CpuTimes:
    """Processor time of tests without the mark slow, their own fixtures and processes included.

    Those beyond ``limit`` seconds are listed at the end, those beyond ``fail`` fail.
    """

    def __init__(self, limit: float, fail: float) -> None:
        self.limit, self.fail = limit, fail
        self.begin = self.shared = 0.0
        self.listed: dict[str, float] = {}

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self) -> Generator[None, object, object]:
        self.begin, self.shared = cpu_seconds(), 0.0
        return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(
        self, fixturedef: pytest.FixtureDef[object]
    ) -> Generator[None, object, object]:
        """What makes a thing that tests share counts for none of them."""
        begin, inner = cpu_seconds(), self.shared
        try:
            return (yield)
        finally:
            if fixturedef.scope != "function":
                self.shared = inner + cpu_seconds() - begin

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        report = yield
        if call.when == "call" and report.passed and not item.get_closest_marker("slow"):
            spent = cpu_seconds() - self.begin - self.shared
            # Properties travel from xdist's workers to the process that reports.
            report.user_properties.append(("cpu_seconds", spent))
            if spent > self.fail:
                report.outcome = "failed"
                report.longrepr = (
                    f"{spent:.1f} s of processor time, more than {self.fail:g} s: make it cheaper, "
                    "or mark it slow and leave a cheap test of the same thing"
                )
        return report

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        spent = dict(report.user_properties).get("cpu_seconds", 0.0)
        if isinstance(spent, float) and spent > self.limit:
            self.listed[report.nodeid] = spent

    @pytest.hookimpl(trylast=True)
    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        if self.listed:
            terminalreporter.section(f"more than {self.limit:g} s of processor time")
            for test, spent in sorted(self.listed.items(), key=lambda pair: -pair[1]):
                terminalreporter.line(f"{spent:5.1f} s  {test}")
        skipped = terminalreporter.stats.get("skipped", [])
        reasons = Counter(report.longrepr[2].removeprefix("Skipped: ") for report in skipped)
        if reasons:
            terminalreporter.section("skipped, by reason")
            for reason, count in reasons.most_common():
                terminalreporter.line(f"{count:5d}  {reason}")


def cpu_seconds() -> float:
    """Processor time of this process so far, and of the children that it waited for."""
    return sum(os.times()[:4])


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """What is cached is in the tests' own cache, one for all workers, not in the user's."""
    base = tmp_path_factory.getbasetemp()
    run = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ORUSD_CACHE", str(run / "cache"))
        yield


@pytest.fixture(scope="session")
def real() -> Callable[[str], Path]:
    """Where a real capture is, by its path below ``$ORUSD_REAL``; without it tests are skipped."""

    def find(name: str) -> Path:
        if not (REAL / name).exists():
            pytest.skip("real captures are missing: ORUSD_REAL names their folder")
        return REAL / name

    return find


@pytest.fixture(scope="session")
def assert_valid() -> Callable[..., None]:
    """Assert that a stage has no findings of ours, strict, and none of `nvidia_issues`.

    A layer that is not the whole scene yet may name the rules that others will fulfil:
    ``assert_valid(path, without=("material",))``.
    """
    from openrooms_usd.rules import validate_stage
    from openrooms_usd.validation.room_rules import ROOM_RULES
    from tests.validators import nvidia_issues

    # Rooms for tests may be dark, and crowded: that says nothing about their layers.
    shown = {rule.code for rule in ROOM_RULES}

    def check(path: Path, *, without: tuple[str, ...] = ()) -> None:
        findings = [
            f"{f.code} {f.place}: {f.message}"
            for f in validate_stage(path, strict=True)
            if f.code not in {*without, *shown}
        ]
        problems = [*findings, *nvidia_issues(path)]
        assert not problems, "\n".join(problems)

    return check


@pytest.fixture(scope="session")
def composed_demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The ``scene.usda`` of `SMALL_ROOM`; read it, and copy its folder to change it."""
    from openrooms_usd.composing import compose_room

    folder = tmp_path_factory.mktemp("small")
    (folder / "room.yaml").write_text(SMALL_ROOM)
    return compose_room(folder / "room.yaml", folder / "out").scene


@pytest.fixture(scope="session")
def composed_bodies(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The ``scene.usda`` of `SMALL_ROOM` with physics; copy its folder to change it."""
    from openrooms_usd.composing import compose_room

    folder = tmp_path_factory.mktemp("bodies")
    (folder / "room.yaml").write_text(f"{SMALL_ROOM}physics: {{}}\n")
    return compose_room(folder / "room.yaml", folder / "out").scene


@pytest.fixture(scope="session")
def torch_packages() -> str:
    """The folder of packages that PyTorch is in: our own, or that of `.ci/install-torch`, or of the
    Python that ORUSD_TORCH_PYTHON names. The test is skipped where there is none for this Python.
    """
    if found := importlib.util.find_spec("torch"):
        return str(Path(str(found.origin)).parents[1])
    python = os.environ.get("ORUSD_TORCH_PYTHON", str(ROOT / ".venv-torch/bin/python"))
    if not Path(python).exists():
        pytest.skip("PyTorch is missing (.ci/install-torch, ORUSD_TORCH_PYTHON)")
    code = "import sys, sysconfig; print(sys.version_info[:2], sysconfig.get_path('purelib'))"
    said = subprocess.run([python, "-c", code], capture_output=True, text=True, check=True).stdout
    version, folder = said.strip().rsplit(" ", 1)
    if version != str(sys.version_info[:2]):
        pytest.skip("PyTorch is installed for another version of Python")
    return folder


@pytest.fixture(scope="session")
def vectorized() -> str:
    """Mitsuba's fastest variant, which computes many samples at a time."""
    from orusd_mitsuba import variants

    chosen = variants.choose().variant
    if chosen.startswith("scalar"):
        pytest.skip("no usable LLVM (`orusd doctor` says why)")
    return chosen


@pytest.fixture
def in_time() -> Iterator[None]:
    """What hangs fails, instead of holding all other tests up."""

    def late(*given: object) -> None:
        raise AssertionError("it hangs")

    if sys.platform == "win32":
        yield
        return
    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(60)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)
