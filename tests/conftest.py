"""What tests of every area share: is a stage valid, and a small room that was composed once."""

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import hypothesis
import pytest

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
alignment:
  from: objects
  objects:
    - {category: table, at: [1.5, 1.5], name: desk}
    - {category: chair, at: [1.5, 0.8], yaw: 180 deg}
    - {category: chair, at: [2.6, 1.5], yaw: 90 deg}
    - {category: table_lamp, at: [1.5, 1.6], on: desk}
"""

# Captures of real rooms, which are not part of the project: where they are missing, so are their
# tests.
REAL = Path(os.environ.get("ORUSD_REAL") or Path(__file__).parents[2] / "shared" / "data")

# Rules of usd-validation-nvidia that do not fit a room, each with the reason.
LEFT_OUT: tuple[str, ...] = ()


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Textures of the tests come from the tests' own cache, not from the user's."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ORUSD_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="session")
def real() -> Callable[[str], Path]:
    """Where a real capture is, by its path below ``$ORUSD_REAL``; the test is skipped without."""

    def find(name: str) -> Path:
        if not (REAL / name).exists():
            pytest.skip(f"{name} is not here: ORUSD_REAL says where real captures are")
        return REAL / name

    return find


@pytest.fixture(scope="session")
def assert_valid() -> Callable[..., None]:
    """Assert that a stage has no findings of ours, strict, and none of usd-validation-nvidia's.

    A layer that is not the whole scene yet may name the rules that others will fulfil:
    ``assert_valid(path, without=("material",))``.
    """
    from openrooms_usd.validate import validate_stage

    def check(path: Path, *, without: tuple[str, ...] = ()) -> None:
        findings = [
            f"{f.code} {f.place}: {f.message}"
            for f in validate_stage(path, strict=True)
            if f.code not in without
        ]
        problems = [*findings, *nvidia_issues(path)]
        assert not problems, "\n".join(problems)

    return check


def nvidia_issues(path: Path) -> list[str]:
    """The errors and failures that usd-validation-nvidia finds in a stage."""
    import usd_validation_nvidia as nvidia

    engine = nvidia.ValidationEngine()
    for name in LEFT_OUT:
        engine.disable_rule(getattr(nvidia, name))
    bad = (nvidia.IssueSeverity.ERROR, nvidia.IssueSeverity.FAILURE)
    return sorted(
        f"{issue.rule.__name__ if issue.rule else '-'} {issue.at}: {issue.message}"
        for issue in engine.validate(str(path)).issues()
        if issue.severity in bad
    )


@pytest.fixture(scope="session")
def composed_demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The ``scene.usda`` of `SMALL_ROOM`; read it, and copy its folder to change it."""
    from openrooms_usd.compose import compose_room

    folder = tmp_path_factory.mktemp("small")
    (folder / "room.yaml").write_text(SMALL_ROOM)
    return compose_room(folder / "room.yaml", folder / "out").scene


@pytest.fixture(scope="session")
def composed_bodies(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The ``scene.usda`` of `SMALL_ROOM` with physics; copy its folder to change it."""
    from openrooms_usd.compose import compose_room

    folder = tmp_path_factory.mktemp("bodies")
    (folder / "room.yaml").write_text(f"{SMALL_ROOM}physics: {{}}\n")
    return compose_room(folder / "room.yaml", folder / "out").scene
