"""Equal descriptions give equal bytes, whatever the process, its workers and its places."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from openrooms_usd.composing import compose_room
from openrooms_usd.demo import copy_example

MAIN = "from openrooms_usd.cli import main; main()"

# Two surroundings that differ in whatever a program might let into its output.
HERE = {"PYTHONHASHSEED": "0", "TZ": "UTC", "LC_ALL": "C", "COLUMNS": "80"}
THERE = {"PYTHONHASHSEED": "4321", "TZ": "Asia/Tokyo", "LC_ALL": "C.UTF-8", "COLUMNS": "200"}


def orusd(cwd: Path, surroundings: dict[str, str], *words: object) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", MAIN, *map(str, words)],
        cwd=cwd,
        env=dict(os.environ) | surroundings,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def tree(folder: Path) -> dict[str, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def assert_same(a: dict[str, bytes], b: dict[str, bytes]) -> None:
    assert sorted(a) == sorted(b)
    assert [name for name in a if a[name] != b[name]] == []


@pytest.fixture(scope="module")
def twins(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The bundled example, composed twice: by one worker here, and by four there."""
    first = tmp_path_factory.mktemp("first")
    second = tmp_path_factory.mktemp("second") / "deep" / "in" / "a folder"
    for folder, surroundings, workers in ((first, HERE, 1), (second, THERE, 4)):
        copy_example(folder)
        out = "scene" if surroundings is HERE else folder / "scene"
        files = ("--flatten", "--usdz", "--workers", workers)
        orusd(folder, surroundings, "compose", "room.yaml", "-o", out, *files)
    return first / "scene", second / "scene"


@pytest.mark.slow
def test_one_worker_and_four_write_the_same_bytes(twins: tuple[Path, Path]) -> None:
    one, four = map(tree, twins)
    assert {"scene.usda", "scene.usdc", "scene.usdz", "layers/edits.usda"} <= set(one)
    assert sum(name.endswith(".png") for name in one) > 20
    assert_same(one, four)
    for home in twins:
        assert not [name for name, data in one.items() if str(home.parent).encode() in data]


@pytest.mark.slow
def test_two_renders_write_the_same_bytes(
    twins: tuple[Path, Path], tmp_path: Path, variant: str
) -> None:
    how = ("--resolution", "24x18", "--spp", "2", "--variant", variant)
    first, second = tmp_path / "pictures", tmp_path / "other pictures"
    orusd(twins[0], HERE, "render", "scene.usda", "-o", first, *how)
    orusd(tmp_path, THERE, "render", twins[1] / "scene.usda", "-o", second.name, *how)
    a, b = tree(first), tree(second)
    assert {"manifest.json", "contact_sheet.png", "sitting/channels.exr"} <= set(a)
    assert a.pop("timing.json") != b.pop("timing.json")
    assert_same(a, b)
    for home in (tmp_path, twins[0]):
        assert not [name for name, data in a.items() if str(home).encode() in data]


def test_every_room_is_composed_to_the_same_bytes(room: Path, tmp_path: Path) -> None:
    description = room.parent / "source" / "room.yaml"
    compose_room(description, tmp_path, workers=4)
    first = {name: data for name, data in tree(room.parent).items() if "source/" not in name}
    assert_same(first, tree(tmp_path))
